#pragma once
// Interior-point solution of an Nlp by Ipopt: Waechter, Biegler, "On the implementation of an
// interior-point filter line-search algorithm for large-scale nonlinear programming", Math.
// Program. 106 (2006). Ipopt 3.11 to 3.14.
//
// Ipopt sees the problem divided by the scales of the Nlp; `tolerance` is of the scaled optimality
// error, and no row may be off by more than `row_tolerance` in its own unit. Rows and variables
// with equal bounds are equalities and constants. Same inputs, same iterates: BLAS runs on one
// thread, the clock has no say unless time_limit_s is reached.
// One solve at a time runs in a process (MUMPS keeps global state); several at once need a process
// each, see core/tasks.h.

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/solver/result.h"
#include "jaculus/transcription/nlp.h"

namespace jaculus::solver {

struct SolverOptions {
  double tolerance = 1e-6;  ///< of the scaled optimality error [-]
  /// held for 15 iterations it ends a solve that can't do better [-]
  double acceptable_tolerance = 1e-4;
  double row_tolerance = 1e-4;  ///< largest violation of a row, in the row's unit
  int max_iterations = 1000;
  double time_limit_s = kInfinity;  ///< wall time [s]
  /// `frontal`, for systems that are a chain along time (MUMPS where they aren't), mumps, or ma27,
  /// ma57, ... where the HSL library is installed
  std::string linear_solver = "frontal";
  bool exact_hessian = true;      ///< false: limited-memory BFGS
  bool stop_on_interrupt = true;  ///< end with Status::interrupted once interrupt_requested()
  /// further options by Ipopt's own names, over everything above
  std::map<std::string, std::string> ipopt = {};

  /// Called after every iteration; false ends the solve with Status::stopped.
  std::function<bool(const IterationInfo&)> progress = {};
};

/// Multipliers to warm-start with, in the convention of NlpResult.
struct Duals {
  Vector rows;   ///< [m]
  Vector lower;  ///< [n]
  Vector upper;  ///< [n]
};

/// Where a solve starts: x is moved into its bounds. With duals it is a warm start: the point is
/// hardly pushed away from its bounds and the barrier begins small.
struct Start {
  Vector x;  ///< [n]
  std::optional<Duals> duals = {};
};

/// A start from a result, converged or not.
Start warm_start(const NlpResult& result);

/// Solves. Numerical failure is a status. InputError on an unknown or ill-valued `ipopt` option or
/// linear solver. Exceptions from the Nlp or the callback pass through. In development the
/// environment variable JACULUS_IPOPT_OPTIONS, "name value;name value", adds options over all
/// others.
NlpResult solve_nlp(transcription::Nlp& nlp, const Start& start, const SolverOptions& options = {});

/// Every variable and row whose bounds nothing can satisfy, variables first.
std::vector<BoundConflict> bound_conflicts(const transcription::Nlp& nlp);

/// Version of the Ipopt that was compiled against, "3.11.9".
std::string ipopt_version();

}  // namespace jaculus::solver
