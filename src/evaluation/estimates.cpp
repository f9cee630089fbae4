#include "evaluation/estimates.h"

#include <algorithm>
#include <boost/math/distributions/beta.hpp>
#include <boost/math/distributions/binomial.hpp>
#include <cassert>
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
  using Beta = boost::math::beta_distribution<double>;
  const double k = successes, n = trials;
  ScoreEstimate e{k / n, {0.0, 1.0}, trials};
  if (successes > 0) e.ci95.lower = boost::math::quantile(Beta(k, n - k + 1.0), 0.025);
  if (successes < trials) e.ci95.upper = boost::math::quantile(Beta(k + 1.0, n - k), 0.975);
  return e;
}

ScoreEstimate mean(const std::vector<double>& values) {
  if (values.empty()) return {};
  ScoreEstimate e{average(values), {kNaN, kNaN}, static_cast<int>(values.size())};
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
  ScoreEstimate e{n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]), {-kInfinity, kInfinity}, 0};
  e.count = static_cast<int>(n);
  // The largest r with P(Binomial(n, 1/2) <= r - 1) <= 0.025: values r and n + 1 - r (from one) bound the median.
  const boost::math::binomial_distribution<double> flips(static_cast<double>(n), 0.5);
  std::size_t r = 0;
  while (r + 1 <= n / 2 && boost::math::cdf(flips, static_cast<double>(r)) <= 0.025) ++r;
  if (r > 0) e.ci95 = {values[r - 1], values[n - r]};
  return e;
}

}  // namespace jaculus::evaluation
