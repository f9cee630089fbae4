#include "evaluation/estimates.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cassert>
#include <cmath>
#include <numeric>
#include <random>

namespace jaculus::evaluation {
namespace {

double average(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

ScoreEstimate proportion(int successes, int trials) {
  assert(successes >= 0 && successes <= trials);
  if (trials == 0) return {};
  constexpr double z = 1.959963984540054;  // of 95 %
  const double n = trials, p = successes / n;
  const double shrunk = 1.0 + z * z / n;
  const double middle = (p + 0.5 * z * z / n) / shrunk;
  const double half = z * std::sqrt(p * (1.0 - p) / n + 0.25 * z * z / (n * n)) / shrunk;
  return {p, {std::max(0.0, middle - half), std::min(1.0, middle + half)}, trials};
}

ScoreEstimate mean(const std::vector<double>& values) {
  if (values.empty()) return {};
  ScoreEstimate e{average(values), {kNaN, kNaN}, count_of(values)};
  if (values.size() == 1) return e;
  constexpr std::size_t kResamples = 4000;
  std::mt19937_64 random(20260101);
  std::uniform_int_distribution<std::size_t> pick(0, values.size() - 1);
  std::vector<double> means(kResamples);
  for (double& m : means) {
    double sum = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) sum += values[pick(random)];
    m = sum / static_cast<double>(values.size());
  }
  std::sort(means.begin(), means.end());
  e.ci95 = {means[kResamples / 40], means[kResamples - 1 - kResamples / 40]};
  return e;
}

ScoreEstimate median(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  ScoreEstimate e{n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]),
                  {-kInfinity, kInfinity},
                  0};
  e.count = count_of(values);
  // The largest r with P(Binomial(n, 1/2) <= r - 1) <= 0.025: values r and n + 1 - r (from one)
  // bound the median.
  const boost::math::binomial_distribution<double> flips(static_cast<double>(n), 0.5);
  std::size_t r = 0;
  while (r + 1 <= n / 2 && boost::math::cdf(flips, static_cast<double>(r)) <= 0.025) ++r;
  if (r > 0) e.ci95 = {values[r - 1], values[n - r]};
  return e;
}

}  // namespace jaculus::evaluation
