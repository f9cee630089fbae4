#include "diagnosis/noise/log_probability.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace jaculus::diagnosis {
namespace {

/// log Phi(x) of the standard normal, also far in its lower tail.
double log_normal_cdf(double x) {
  if (x > -8.0) return std::log(0.5 * std::erfc(-x / std::numbers::sqrt2));
  return -0.5 * x * x - std::log(-x) - 0.5 * std::log(2.0 * std::numbers::pi);
}

/// log of the probability that a normal of this mean and deviation has within a range, also where
/// that is far in a tail.
double log_normal_mass(const Bounds& range, double mean, double deviation) {
  double low = (range.lower - mean) / deviation, high = (range.upper - mean) / deviation;
  if (low > 0.0)
    std::swap(low = -low, high = -high);  // by the lower tail, where logarithms are exact
  const double above = log_normal_cdf(low), all = log_normal_cdf(high);
  return std::isinf(low) ? all : all + std::log1p(-std::exp(above - all));
}

}  // namespace

double log_of_sum(double a, double b) {
  const double most = std::max(a, b);
  return std::isinf(most) ? most : most + std::log1p(std::exp(std::min(a, b) - most));
}

double log_mass_ratio(const Bounds& range, double mean, double deviation) {
  return log_normal_mass(range, mean, deviation) - log_normal_mass(range, 0.0, 1.0);
}

}  // namespace jaculus::diagnosis
