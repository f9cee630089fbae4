#pragma once
// What a model may leave though its sensors are good.
//
// Under a logged input forces that the plant lacks:
//   r = T (y - A m - f(p)) = G w + e,   w_k ~ N(0, s_g(k)^2),  e ~ N(0, I)
//   G  slopes by generalised forces over a window's boxes of time, a group a coordinate and band
//      (force_bands.h)
//
// Under a plan a misfit in each coordinate that is measured. All trials have it, and it may have
// any form: of the N rows of a coordinate, of all datasets, n values may be off by it, which ones
// is not known (n: settings.discrepancy_modes of each dataset that measures it). With E = |r|^2 of
// these rows, s the misfit's root mean square and 1 + m = 1 + s^2 N/n the variance of these values,
//   -2 log density = (E - N + n)/(1 + m) + n log(1 + m) + N - n:
// n values hold the misfit, the others noise alone. At the most likely m this is
//   n log(1 + (E - N)/n) where E > N, else E,
// and no misfit is less than settings.least_misfit noise floors, for below that thousands of rows
// would decide by details of the noise. A model is thus worth the share that it takes off the
// misfit of each coordinate. The most likely parameters are those of least squares whose weights
// follow from what they leave in each: they minimise the sum of the logarithms of the energies, not
// of the energies (several responses of unknown variances: Box and Draper 1965; L2 calibration: Tuo
// and Wu 2015). One size for all would let the coordinate whose sensor is best, a bus voltage good
// to 2 mV, outvote the others whatever the plant holds of it. Limits of validity: such a sum may
// have a valley for each coordinate that parameters can nearly explain, and a fit under a plan ends
// in the one below plain least squares, where it sets out; channels of one coordinate share a size.
// Granted instead as forces that act on rows, V = I + G S^2 G^T, a misfit costs nothing along G,
// and a wrong model is fitted to what is left there: fast details of impacts (Brynjarsdottir and
// O'Hagan 2014 and Plumlee 2017 on such discrepancies, which make parameters meaningless).
//
// The deviations s are unknown and belong to a model: a wrong model needs larger ones. They are
// estimated for each by maximising its evidence (variance components; MacKay 1992, section 2;
// process noise of grey-box models: Kristensen, Madsen and Jorgensen 2004). What a model lacks is
// thus counted by independent values, not by samples, in every mode and on every robot: no number
// of samples makes a wrong model certain.

#include <string>
#include <utility>
#include <vector>

#include "diagnosis/forward/problem.h"

namespace jaculus::diagnosis {

/// s^2 below which a direction stays as it is: it would shrink by 5e-6 of itself [-]. Chosen.
inline constexpr double kLeastEnergy = 1e-5;

/// I - U diag(shrink) U^T on some rows.
struct Shrinkage {
  Matrix U;                       ///< rows x k, orthonormal columns
  Vector shrink;                  ///< k, 1 - 1/sqrt(1 + s^2)
  void apply(MatrixRef X) const;  ///< on each column
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

/// Rows that share their w: a window under a logged input.
struct RandomBlock {
  int first = 0, count = 0;  ///< white rows
  Matrix columns;            ///< G, count x k
  std::vector<int> group;    ///< of every column
  Matrix gram;               ///< G^T G
};

/// What shares a deviation.
struct RandomGroup {
  std::string name;      ///< "elbow"; of a misfit "misfit of x"
  int force = -1;        ///< index in Hypotheses::forces; -1: no force
  double share = 1.0;    ///< of the force's mean square that the group's deviation squared is
  int slower = -1;       ///< the group before it, whose deviation its own is not below; -1: none
  double largest = 1e4;  ///< deviation at most; of a force settings.largest_force
  double least = 0.0;    ///< of a misfit at least, settings.least_misfit
};

/// The misfit of a coordinate, of the datasets under a plan.
struct Misfit {
  int group = 0;
  double values = 0.0;                     ///< n, that it counts as
  double rows = 0.0;                       ///< N, of those that take part, less what stands apart
  std::vector<std::pair<int, int>> spans;  ///< of white rows: first, count

  /// 1 + m of a misfit of root mean square s.
  [[nodiscard]] double variance(double s) const;
  /// The s of most density where its rows have the energy E, within the group's ends; the least
  /// where none of them takes part.
  [[nodiscard]] double likely(double energy, const RandomGroup& group) const;
  /// E, |r|^2 of its rows, of all white rows r.
  [[nodiscard]] double energy(const Vector& r) const;
  /// Its part of log det V, n log(1 + m) + (N - n) m/(1 + m).
  [[nodiscard]] double log_det(double s) const;
};

/// Of white rows.
struct RandomEffects {
  std::vector<RandomGroup> groups;
  std::vector<RandomBlock> blocks;
  std::vector<Misfit> misfits;
  /// White rows of neither, beside a misfit: first, count (nuisances that stand apart,
  /// whitening.h).
  std::vector<std::pair<int, int>> plain{};

  [[nodiscard]] int size() const { return count_of(groups); }
};

/// Those of a model that lacks nothing: no force, the least misfits.
Vector complete_scales(const RandomEffects& effects);
/// Deviations with those of misfits zero.
Vector without_misfits(const RandomEffects& effects, Vector scales);

/// Deviations to begin with: small beside what the groups may reach.
Vector first_scales(const RandomEffects& effects);

/// Products of white columns X with the random effects and one another: all that evidence needs.
struct Products {
  Matrix gram;                  ///< X^T X
  std::vector<Matrix> blocks;   ///< G^T X, a block each
  std::vector<Matrix> misfits;  ///< X^T X of the rows of a misfit, a misfit each
  /// Of u, at their most probable and not marginalised: what all models share (tolerances, unknown
  /// gains). How well these are told goes with the misfit, and would count against the model that
  /// leaves less.
  std::vector<Eigen::Index> shared{};
};
Products products_of(const RandomEffects& effects, const Matrix& X);

/// X^T V^-1 X and log det V: V = I + G S^2 G^T on the rows of a block, 1 + m on those of a misfit.
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
/// `at`: where Laplace's method is applied, a fit's u; null: at the most probable of the linear
/// model, which it is for forces.
LinearEvidence linear_evidence(const RandomEffects& effects, const Products& products,
                               const Vector& scales, const Vector* at = nullptr);

/// Deviations that maximise the evidence, and what it costs that they could be chosen: Laplace's
/// factor over log s_g, of prior deviation `spread`, -log(1 + 2 spread^2 told_g)/2, where told_g is
/// the number of w of the group that the data tell.
struct ScaleEstimate {
  Vector scales;
  double log_cost = 0.0;      ///< to be added to a log evidence by these scales; not positive
  double log_evidence = 0.0;  ///< by these scales, without what their choice costs
  Vector mean;                ///< of u, likewise

  /// Log evidence with what the choice of the scales costs.
  [[nodiscard]] double evidence() const { return log_evidence + log_cost; }
};
/// Of X = [r Y], from `scales` on: s^2 <- |w|^2/told, MacKay's fixed point, and of a misfit
/// s^2 N <- E - N with E expected over u; of at most `steps` the best by the evidence, in which
/// what is shared is not integrated over. With no step: the cost of `scales`. A group that would
/// fall below its slower one has its deviation in common with it, by pooled |w|^2 and told.
ScaleEstimate estimated_scales(const RandomEffects& effects, const Products& products,
                               Vector scales, int steps, double spread, const Vector* at = nullptr);

/// The same scales, but those of misfits at the most likely for a residual r, none below its
/// least.
Vector misfits_of(const RandomEffects& effects, const Vector& r, const Vector& scales);

/// log det V of the misfits alone.
double misfits_log_det(const RandomEffects& effects, const Vector& scales);

/// Of each group, of how many of its w the data tell, X = [r Y]; of a misfit's values
/// n (1 - v_0/v)^2, v = 1 + m and v_0 that of the least.
Vector told_by(const RandomEffects& effects, const Products& products, const Vector& scales);

}  // namespace jaculus::diagnosis
