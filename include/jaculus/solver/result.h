#pragma once
// How a solve ended and what it left. The solution of a solve that did not converge can't be taken
// by accident:
// x() refuses it, last_iterate() must be asked for by that name.

#include <string>
#include <string_view>
#include <vector>

#include "jaculus/core/types.h"

namespace jaculus::solver {

enum class Status {
  optimal,     ///< first-order conditions hold to the tolerance
  acceptable,  ///< they hold to the looser acceptable tolerance, and progress has ended
  infeasible,  ///< a local minimum of the constraint violation that is not zero
  /// some lower bound is above its upper one, or not a number; nothing was run
  contradictory_bounds,
  iteration_limit,
  time_limit,
  interrupted,        ///< by a signal
  stopped,            ///< by the progress callback
  diverged,           ///< iterates run away: probably unbounded
  stalled,            ///< no further step is found, neither in the search nor in its restoration
  evaluation_failed,  ///< the functions are not defined, or not finite, where the solver needs them
  no_freedom,         ///< fewer free variables than equality rows
  failed              ///< anything else (memory, internal errors); message says what
};

/// "optimal", "iteration_limit", ... as written into summary.json.
std::string to_string(Status status);
/// Its inverse; std::invalid_argument on another word.
Status status_from_string(std::string_view text);

/// One iteration as the progress callback sees it.
struct IterationInfo {
  int iteration = 0;
  double objective = 0.0;  ///< in its own unit
  /// largest violation of a row, unscaled, rows of different units mixed
  double infeasibility = 0.0;
  double dual_infeasibility = 0.0;  ///< scaled [-]
  double barrier = 0.0;             ///< barrier parameter, scaled [-]
  bool restoration = false;         ///< the solver is looking for feasibility only
  double elapsed_s = 0.0;           ///< wall time [s]
};

/// Number of calls of each function of the Nlp.
struct EvaluationCounts {
  int objective = 0;
  int gradient = 0;
  int constraints = 0;
  int jacobian = 0;
  int hessian = 0;
};

struct WallSeconds {
  double total = 0.0;
  double functions = 0.0;      ///< inside the Nlp
  double linear_solver = 0.0;  ///< building, factorising and back-solving linear systems
};

/// A bound that no point can satisfy.
struct BoundConflict {
  std::string name;  ///< of the variable or row
  std::string unit;
  double lower = 0.0;
  double upper = 0.0;
};

/// Result of one solve. n variables, m rows; multipliers belong to the unscaled problem, with
///   grad f + J' row_multipliers - lower_multipliers + upper_multipliers = 0,
///     lower, upper multipliers >= 0.
/// Those of variables with equal bounds are what makes this stationarity hold. For a square problem
/// they mean nothing.
class NlpResult {
 public:
  Status status = Status::failed;
  std::string message;       ///< one sentence on how it ended, for users
  Vector row_multipliers;    ///< [m]
  Vector lower_multipliers;  ///< [n]
  Vector upper_multipliers;  ///< [n]
  double objective = kNaN;
  double max_violation = kNaN;         ///< largest violation of rows and bounds, unscaled
  double max_scaled_violation = kNaN;  ///< the same, each divided by its scale [-]
  int iterations = 0;
  /// of `iterations`, those of a feasibility stage that came first
  int feasibility_iterations = 0;
  EvaluationCounts evaluations;
  WallSeconds wall_seconds;
  std::vector<IterationInfo> history;
  std::vector<BoundConflict> conflicts;  ///< where status is contradictory_bounds

  [[nodiscard]] bool converged() const {
    return status == Status::optimal || status == Status::acceptable;
  }

  /// The solution [n]. std::logic_error unless converged().
  [[nodiscard]] const Vector& x() const;
  /// Where the solver stood when it ended [n], whatever that is worth; empty where it never
  /// started.
  [[nodiscard]] const Vector& last_iterate() const { return x_; }
  void set_iterate(Vector x) { x_ = std::move(x); }

 private:
  Vector x_;
};

/// Everything of a result as bytes, doubles exact; for pipes and journals on one machine type, not
/// an exchange format.
std::string serialise(const NlpResult& result);
/// Its inverse; std::runtime_error on bytes that serialise() did not write.
NlpResult deserialise_result(std::string_view bytes);

}  // namespace jaculus::solver
