#include "evaluation/rank_statistics.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cassert>
#include <cmath>

namespace jaculus::evaluation {

RankStatistics rank_statistics(const std::vector<int>& ranks, int draws, int bins) {
  assert(bins > 1 && (draws + 1) % bins == 0 && "rank_statistics: bins of equal width");
  RankStatistics out;
  out.count = count_of(ranks);
  out.histogram.assign(bins, 0);
  if (ranks.empty()) return out;

  const int width = (draws + 1) / bins;
  for (const int rank : ranks) {
    assert(rank >= 0 && rank <= draws);
    ++out.histogram[rank / width];
  }
  const double n = out.count, expected = n / bins;
  out.chi2 = 0.0;
  for (const int held : out.histogram) out.chi2 += std::pow(held - expected, 2) / expected;
  const boost::math::chi_squared_distribution<double> chi(bins - 1);
  out.probability = boost::math::cdf(boost::math::complement(chi, out.chi2));

  std::vector<int> sorted = ranks;
  std::sort(sorted.begin(), sorted.end());
  out.ecdf = 0.0;
  for (int rank = 0; rank <= draws; ++rank) {
    const auto below = std::upper_bound(sorted.begin(), sorted.end(), rank) - sorted.begin();
    const double uniform = (rank + 1.0) / (draws + 1.0);
    out.ecdf = std::max(out.ecdf, std::abs(static_cast<double>(below) / n - uniform));
  }
  out.band = std::sqrt(std::log(2.0 / 0.05) / (2.0 * n));
  return out;
}

Vector bounded_normal(const Vector& mean, const Matrix& root, const std::vector<Bounds>& ranges,
                      std::mt19937_64& random) {
  constexpr int kTries = 20000;
  std::normal_distribution<double> normal;
  for (int k = 0; k < kTries; ++k) {
    Vector z(mean.size());
    for (double& one : z) one = normal(random);
    const Vector x = mean + root.triangularView<Eigen::Lower>() * z;
    bool within = true;
    for (int i = 0; i < count_of(ranges); ++i) within = within && ranges[i].contains(x[i]);
    if (within) return x;
  }
  return {};
}

}  // namespace jaculus::evaluation
