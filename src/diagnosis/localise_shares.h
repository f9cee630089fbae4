#pragma once
// Shares of the gap over components, from linear signatures, by averaging over sparse explanations.
//
//   r = sum_{e in s} S_e theta_e + N eta + noise,   noise ~ N(0, kappa I),   theta ~ N(0, I) (half of it where one-sided)
// Rows are scaled by noise and autocorrelation, columns of S_e by the prior's width. Nuisances eta (prior precision L) go out first:
//   P = I - N (N^T N + L)^-1 N^T,   G = S^T P S,   b = S^T P r,   so that for a subset s of effects
//   log evidence = -1/2 log det A + 1/2 b_s^T A^-1 b_s / kappa^2 + sum_one-sided log(Phi(mean/deviation)/(1/2)),   A = I + G_ss/kappa
//   posterior    = N(A^-1 b_s/kappa, A^-1), cut to the sides.
// kappa = 1 + max(0, chi2 of the best subset - rows) / 20: what the linear model leaves beyond noise is structured and fills some
// twenty independent directions, in each of which it weighs as that much noise.
// Subsets of none to three effects have prior weights 0.5, 0.35, 0.1, 0.05; within a size in proportion to the product over its
// effects of 1/(effects of the component), so that no component gains by having many entries.
// Share of a component: f_c = sum of its effects' contributions, explained energy ||P sum_c f_c||^2, whose Shapley value is
// f_c^T P f (opposing parts count as zero), over the sum of those and the energy that stays unexplained beyond noise.
// Limits of validity: signatures linear up to the measured gap; sides treated one by one.

#include <cstdint>
#include <vector>

#include "jaculus/diagnosis/localise.h"

namespace jaculus {

/// A component's part in an effect: the columns of what the effect does there alone.
struct SharePart {
  Component component = Component::body;
  std::vector<int> columns;  ///< as many as the candidate has
};

/// One effect: its columns of the system, and on which side of nominal each may lie. One that acts in several components at once
/// (all legs) has a part for each, whose columns sum to its own.
struct ShareCandidate {
  std::vector<int> columns;
  std::vector<int> sides;  ///< +1, -1: one-sided; 0: both
  std::vector<SharePart> parts;

  [[nodiscard]] bool acts_in(Component component) const;
};

/// Sums over blocks of rows (trials) after nuisances.
struct ShareSystem {
  explicit ShareSystem(int columns) : G(Matrix::Zero(columns, columns)), b(Vector::Zero(columns)) {}

  Matrix G;           ///< p x p
  Vector b;           ///< p
  double rr = 0.0;    ///< energy of the residual after nuisances
  double rows = 0.0;  ///< its expectation under noise alone: effective rows less nuisances

  /// Adds a block: S (k x p), r (k), nuisances N (k x m) with prior precision (m; 0: free). `effective`: independent rows of it.
  void add(const Matrix& S, const Vector& r, const Matrix& N, const Vector& precision, double effective);
  /// Takes columns out as nuisances of prior precision 1, shared by all blocks. They stay in place, as zeros.
  void project_out(const std::vector<int>& columns);
};

struct ShareOptions {
  int largest = 3;            ///< effects at once
  double floor_error = 0.05;  ///< relative standard deviation of the noise floor's variance
  int samples = 4000;
  std::uint64_t seed = 1;
};

struct ShareAnswer {
  std::vector<ComponentShare> components;
  double unexplained = 0.0;
  double nothing = 0.0;  ///< posterior probability that no effect is at work
  double kappa = 1.0;
};

ShareAnswer component_shares(const ShareSystem& system, const std::vector<ShareCandidate>& candidates,
                             const ShareOptions& options = {});

}  // namespace jaculus
