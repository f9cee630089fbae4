#pragma once
// Sensitivities of the best objective to the limits (shadow prices), from the multipliers of a
// solve.
//
// With the Lagrangian of NlpResult, f + lambda' g - z_l' (x - x_l) - z_u' (x_u - x), the envelope
// theorem gives
//   d f*/d (row limit) = -lambda,   d f*/d x_l = z_l,   d f*/d x_u = -z_u,
//     d f*/d (fixed value) = z_l - z_u,
// to first order, while the same limits stay active, at a regular local optimum. A rate of 0.43 for
// "rear motor voltage, upper" is 0.43 units of the objective a volt: raising the limit by a volt
// changes the objective by about +0.43.

#include <string>
#include <vector>

#include "jaculus/solver/result.h"
#include "jaculus/transcription/nlp.h"

namespace jaculus::solver {

enum class Side { lower, upper, fixed };  ///< fixed: equal bounds, an equality

/// Sensitivity of the best objective to one active limit.
struct LimitSensitivity {
  bool is_row = true;
  int index = 0;  ///< of the row or variable
  std::string name;
  std::string unit;  ///< of the limit
  Side side = Side::fixed;
  double limit = 0.0;   ///< in `unit`
  double rate = 0.0;    ///< d objective / d limit [objective's unit over `unit`]
  double scaled = 0.0;  ///< rate x scale of the limit / scale of the objective [-], to rank by
};

struct SensitivityOptions {
  /// the Nlp minimises the negative of what the user maximises: rates of the latter
  bool maximise = false;
  /// smallest |scaled| that is listed: below are inactive limits and round-off
  double threshold = 1e-6;
  /// list equality rows and fixed variables as well (nobody can relax a defect)
  bool equalities = false;
};

/// Active limits by falling |scaled|, then index. std::logic_error unless the result converged:
/// multipliers elsewhere mislead.
std::vector<LimitSensitivity> limit_sensitivities(const transcription::Nlp& nlp,
                                                  const NlpResult& result,
                                                  const SensitivityOptions& options = {});

/// "lower", "upper", "fixed".
std::string to_string(Side side);

}  // namespace jaculus::solver
