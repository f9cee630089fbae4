#pragma once
// What a model may leave though its sensors are good: forces that the plant lacks.
//
//   r = T (y - A m - f(p)) = G w + e,   w_k ~ N(0, s_g(k)^2),  e ~ N(0, I)
//   G  slopes by generalised forces that are constant over boxes of time, a group a coordinate
//      under a plan, a group a coordinate and band under a logged input (force_bands.h); and smooth
//      modes of every channel under a plan, a group a channel (nuisances.h)
// The deviations s are unknown and belong to a model: a wrong model needs larger ones. They are
// estimated for each by maximising its evidence (variance components; MacKay 1992, section 2;
// process noise of grey-box models: Kristensen, Madsen and Jorgensen 2004). What a model lacks is
// thus counted by independent boxes of time, not by samples, in every mode and on every robot: no
// number of samples makes a wrong model certain.

#include <string>
#include <vector>

#include "diagnosis/forward/problem.h"

namespace jaculus::diagnosis {

/// I - U diag(shrink) U^T on some rows.
struct Shrinkage {
  Matrix U;       ///< rows x k, orthonormal columns
  Vector shrink;  ///< k, 1 - 1/sqrt(1 + s^2)
  void apply(VectorRef x) const;
};
/// That of the columns A, already scaled by their priors.
Shrinkage shrinkage(const Matrix& A);

/// d(rows)/d(force) at one point of the parameters, raw rows.
struct RandomColumns {
  std::vector<Matrix> forces;  ///< a dataset each: rows x boxes of all groups
  std::vector<int> group;      ///< of every column of `forces`, index in Hypotheses::forces
};
/// Where a simulation fails the column is zero: nothing is granted there.
RandomColumns random_columns(const Problem& problem, const std::vector<Alignment>& alignments,
                             const Vector& p, const std::vector<Vector>& rows_at_p);

/// Rows that share their w: a dataset under a plan, a window under a logged input.
struct RandomBlock {
  int first = 0, count = 0;  ///< white rows
  Matrix columns;            ///< G, count x k
  std::vector<int> group;    ///< of every column
  Matrix gram;               ///< G^T G
};

/// Columns that share a deviation.
struct RandomGroup {
  std::string name;      ///< "elbow", "channel x"
  int force = -1;        ///< index in Hypotheses::forces; -1: no force
  double share = 1.0;    ///< of the force's mean square that the group's deviation squared is
  int slower = -1;       ///< the group before it, whose deviation its own is not below; -1: none
  double largest = 1e4;  ///< deviation at most; of a force settings.largest_force
};

/// Of white rows.
struct RandomEffects {
  std::vector<RandomGroup> groups;
  std::vector<RandomBlock> blocks;

  [[nodiscard]] int size() const { return count_of(groups); }
};

/// Deviations to begin with: small beside what the groups may reach.
Vector first_scales(const RandomEffects& effects);

/// Products of white columns X with the random effects and one another: all that evidence needs.
struct Products {
  Matrix gram;                 ///< X^T X
  std::vector<Matrix> blocks;  ///< G^T X, a block each
};
Products products_of(const RandomEffects& effects, const Matrix& X);

/// X^T V^-1 X and log det V, V = I + G S^2 G^T.
struct Weighed {
  Matrix gram;
  double log_det = 0.0;
};
Weighed weigh(const RandomEffects& effects, const Products& products, const Vector& scales);

/// The linear Gaussian model r = Y u + G w + e, u ~ N(0, I), of X = [r Y].
struct LinearEvidence {
  double log_evidence = 0.0;  ///< up to the constant of the rows
  Vector mean;                ///< of u
  Matrix covariance;          ///< of u
};
LinearEvidence linear_evidence(const RandomEffects& effects, const Products& products,
                               const Vector& scales);

/// Deviations that maximise the evidence, and what it costs that they could be chosen: Laplace's
/// factor over log s_g, of prior deviation `spread`, -log(1 + 2 spread^2 told_g)/2, where told_g is
/// the number of w of the group that the data tell.
struct ScaleEstimate {
  Vector scales;
  double log_cost = 0.0;  ///< to be added to a log evidence by these scales; not positive
};
/// Of X = [r Y], from `scales` on: s^2 <- |w|^2/told, MacKay's fixed point; the best of at most
/// `steps`. With no step: the cost of `scales`. A group that would fall below its slower one has
/// its deviation in common with it, by pooled |w|^2 and told.
ScaleEstimate estimated_scales(const RandomEffects& effects, const Products& products,
                               Vector scales, int steps, double spread);

/// Of each group, of how many of its w the data tell, X = [r Y].
Vector told_by(const RandomEffects& effects, const Products& products, const Vector& scales);

}  // namespace jaculus::diagnosis
