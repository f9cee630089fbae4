#pragma once
// Which few groups of functions a missing force follows.
//
// Of boxes k of one coordinate, f_k = x_k . b + e_k. Neighbours' e are correlated two ways: what is
// missing beyond x may be slow, and the rates at the ends of a box, which neighbours share, are
// measured with noise, whose differences make neighbours' errors opposite:
//   cov(e) = s^2 (rho^|i - j| + lambda T_ij),   T = 2 on the diagonal, -1 beside it,
// within chunks of consecutive boxes and zero between them; (rho, lambda) are the most likely ones
// of a grid. A set of groups of k functions has the score (Schwarz 1978)
//   -(N log(RSS/N) + log det)/2 - k/2 log N - log(periods tried, where it has a periodic group),
// and groups join one by one while the score rises.
//
// Stability (Meinshausen and Buhlmann 2010; complementary pairs of Shah and Samworth 2013): the
// same selection on B random halves of the chunks and on the other halves. A group stands if a
// share tau of the 2 B halves chose it. Their Theorem 2 bounds the expected number of groups that
// stand though a half is not likelier than by chance to choose them: where the shares' distribution
// is unimodal,
//   E <= C(tau) q^2/p,   C = 4 (1 - tau + 1/(2 B))/(1 + 1/B) for 3/4 < tau <= 1,
// q groups chosen of p in a half on average; tau is the least that makes the bound
// settings.pattern_level.

#include <vector>

#include "diagnosis/remainder/regressors.h"
#include "jaculus/diagnosis/settings.h"

namespace jaculus::diagnosis {

/// Consecutive boxes.
struct Chunk {
  int first = 0, count = 0;
};
/// Runs cut into chunks of nearly one length, some 40 in all, none of fewer than five boxes and few
/// of more than 40.
std::vector<Chunk> chunks_of(const std::vector<int>& run);

/// (rho, lambda).
struct NoiseShape {
  double slow = 0.0, rates = 0.0;
};
/// L^-1 X, L L^T the covariance of a chunk's rows for s = 1.
Matrix whitened(const NoiseShape& shape, const Matrix& X);

struct Selected {
  std::vector<int> groups;  ///< of PlaceRegressors::groups, its size for the periodic one
  double period = kNaN;     ///< [rad or m]
  NoiseShape shape;
  std::vector<double> chosen;  ///< by what share of the halves, a group each
  double needed = 1.0;         ///< tau
};
/// Groups that the whole data choose, at most settings.most_followed, and how stably.
Selected select_regressors(const PlaceRegressors& place, const std::vector<Chunk>& chunks,
                           const Settings& settings);

}  // namespace jaculus::diagnosis
