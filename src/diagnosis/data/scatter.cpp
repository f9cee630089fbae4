#include "diagnosis/data/scatter.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>

namespace jaculus::diagnosis {
namespace {

// Of an estimator, shares without a unit.
//
// Of second differences the smallest that are kept: chosen, as steps of commands are rarer than one
// in ten. The variance of a normal number within +-z, P(|x| < z) = 0.9, is 1 - 2 z phi(z)/0.9.
constexpr double kKept = 0.9, kKeptVariance = 0.6230;
// The variance of a second difference of white noise, over that of a sample: 1 + 4 + 1.
constexpr double kSquares = 6.0;
// Samples, below which there is nothing to keep a share of. Chosen.
constexpr std::size_t kLeast = 10;
// Means of an octave, for the least of several to be no accident: 32 tell a variance to a third.
constexpr std::size_t kLeastMeans = 32;

/// Means of two neighbours each; of an odd number the last is left out.
std::vector<double> halved(const std::vector<double>& x) {
  std::vector<double> means;
  for (std::size_t i = 0; i + 1 < x.size(); i += 2) means.push_back(0.5 * (x[i] + x[i + 1]));
  return means;
}

}  // namespace

double median(std::vector<double> values) {
  assert(!values.empty());
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double scatter_of(const std::vector<double>& x) {
  if (x.size() < kLeast) return 0.0;
  std::vector<double> squares;
  for (std::size_t i = 1; i + 1 < x.size(); ++i)
    squares.push_back(std::pow(x[i - 1] - 2.0 * x[i] + x[i + 1], 2));
  std::sort(squares.begin(), squares.end());
  const auto kept = static_cast<std::size_t>(kKept * static_cast<double>(squares.size()));
  double sum = 0.0;
  for (std::size_t i = 0; i < kept; ++i) sum += squares[i];
  return std::sqrt(sum / (static_cast<double>(kept) * kKeptVariance * kSquares));
}

std::vector<double> scatter_by_octaves(std::vector<double> x) {
  std::vector<double> octaves;
  for (; x.size() >= (octaves.empty() ? kLeast : kLeastMeans); x = halved(x))
    octaves.push_back(std::pow(scatter_of(x), 2));
  return octaves;
}

double most_flicker(const std::vector<double>& octaves) {
  if (octaves.empty()) return 0.0;
  double least = octaves.front();
  for (std::size_t o = 1; o < octaves.size(); ++o) {
    const double share = std::exp2(-static_cast<double>(o));  // 1/m
    const double beyond = (octaves[o] - share * octaves.front()) / (1.0 - share);
    least = std::min(least, std::max(0.0, beyond));
  }
  return std::sqrt(least / (0.5 * std::log(256.0 / 27.0)));
}

}  // namespace jaculus::diagnosis
