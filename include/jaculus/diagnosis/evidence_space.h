#pragma once
// Rows made white: the space in which residuals of the true model are independent standard normal numbers.
//
//   y = f(p) + A n + D d + e,   n ~ N(m, S^2) nuisances of every run,   d ~ N(0, I) smooth faults of the plant, shared by runs,
//   e: noise with sigma_c and neighbours' correlation rho_c^(gap/spacing).
// 1. Whitening          w_i = (r_i - rho r_{i-1})/(sigma sqrt(1 - rho^2)),  first of a span r/sigma
// 2. Runs' nuisances    M^-1/2 = I - U diag(1 - 1/sqrt(1 + s^2)) U^T,  W A S = U diag(s) V^T, run by run
// 3. Plant's faults     the same with what 1 and 2 make of D, over all runs of a condition
// Marginalising n and d is thus a fixed linear map T, and a model's residual T (y - f(p) - A m) is judged by its plain square sum;
// log det T is the same for every model and drops out of comparisons.
// D: K = 6 modes a channel over the window's time, sqrt(2) sin((k - 1/2) pi t/T), cosines for channels that follow the loop's hold
// (a torque may be wrong at once, a position can't), each with standard deviation (discrepancy_c)/sqrt(K).

#include <vector>

#include "jaculus/diagnosis/linearisation.h"

namespace jaculus {

/// I - U diag(shrink) U^T on some rows.
struct Shrinkage {
  Matrix U;       ///< rows x k, orthonormal columns
  Vector shrink;  ///< k, 1 - 1/sqrt(1 + s^2)
  void apply(VectorRef x) const;
};
/// That of the columns A, already scaled by their priors.
Shrinkage shrinkage(const Matrix& A);

struct ConditionSpace {
  std::vector<RowSpan> spans;  ///< of the condition's rows, those that take part
  std::vector<int> run_first;  ///< where each run's rows begin here
  std::vector<int> run_count;
  int rows = 0;
  Vector sigma;            ///< standard deviation of every row here [unit]
  Vector weight;           ///< 1/(sigma sqrt(1 - rho^2)) of every row here
  Vector previous;         ///< rho to the row before, 0 at a span's start
  Vector prior_mean_rows;  ///< A m, raw rows of the condition
  std::vector<Shrinkage> runs;
  Shrinkage shared;

  /// Steps 1 to 3 on a raw vector (a residual less nothing, a sensitivity) of all the condition's rows.
  [[nodiscard]] Vector apply(const Vector& raw) const;
  [[nodiscard]] Vector whiten(const Vector& raw) const;  ///< step 1 alone
};

struct EvidenceSpace {
  std::vector<ConditionSpace> conditions;
  int rows = 0;
  std::vector<Vector> measured;  ///< raw rows less the nuisances' prior mean, a condition each

  /// T (y - A m - f).
  [[nodiscard]] Vector residual(const std::vector<Vector>& predicted) const;
  /// T g of a raw difference of predictions.
  [[nodiscard]] Vector apply(const std::vector<Vector>& raw) const;
};

/// Which runs of which condition take part; empty: all.
using RunMask = std::vector<std::vector<bool>>;
EvidenceSpace evidence_space(const DiagnosisProblem& problem, const Linearisation& about, const RunMask& mask = {});

/// Modes of runs' own ways (Channel::wander).
constexpr int kWanderModes = 10;

/// Modes of step 3 at the rows of a channel, rows x K.
Matrix fault_modes(const Condition& condition, const Channel& channel, const Vector& time, int modes);

}  // namespace jaculus
