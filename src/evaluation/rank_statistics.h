#pragma once
// Simulation-based calibration: ranks of true values among draws of their posterior, which are
// uniform over 0 to the number of draws where the posterior is right. A heap in the middle: the
// posterior is too wide; at both ends: too narrow; at one: it is off.
//   chi2   of equal bins against equal counts, with its upper tail's probability
//   ecdf   largest distance of the ranks' distribution from the uniform one; within `band` with 95
//   %
//          at least, over all ranks at once (Massart's constant: sqrt(ln(2/0.05)/2n))
// Source: Talts et al., arXiv:1804.06788 (2018); Massart, Annals of Probability 18 (1990).

#include <random>
#include <vector>

#include "jaculus/core/types.h"

namespace jaculus::evaluation {

struct RankStatistics {
  int count = 0;
  std::vector<int> histogram;
  double chi2 = kNaN, probability = kNaN;
  double ecdf = kNaN, band = kNaN;
};

/// Ranks among `draws` draws, each 0 to `draws`; `bins` divides draws + 1.
RankStatistics rank_statistics(const std::vector<int>& ranks, int draws, int bins);

/// A draw from a normal distribution within a range a parameter, by rejection; nothing where the
/// range holds next to none of it. `root`: lower triangular, root root^T the covariance.
Vector bounded_normal(const Vector& mean, const Matrix& root, const std::vector<Bounds>& ranges,
                      std::mt19937_64& random);

}  // namespace jaculus::evaluation
