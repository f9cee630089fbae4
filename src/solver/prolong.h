#pragma once
// A solution on a coarse mesh as a start on a finer one: variables and multipliers.
//
// The program's Lagrangian on a mesh is a quadrature of the continuous problem's, so
//   defects            lambda = the costate in the interval's middle: it does not depend on h
//   path rows, bounds  lambda = w mu(t): the multiplier of the continuous limit at the point's time
//                      times the share w of the duration that the point stands for, which is
//                      proportional to h
//   node rows, bounds at both ends of the plan, of durations and of extra variables: of one
//                      instant, the same on every mesh
// With half the interval length, a product of slack and multiplier is half as large, and so is the
// barrier parameter that belongs to it.

#include "jaculus/solver/ipopt.h"
#include "jaculus/transcription/nonlinear_program.h"

namespace jaculus::solver::detail {

/// A start on `fine`, whose problem is that of `coarse` on another mesh, from what a solve of
/// `coarse` ended with. Nodes and inputs are interpolated in time, the rest is copied.
Start prolong(transcription::NonlinearProgram& coarse, const NlpResult& result,
              transcription::NonlinearProgram& fine);

/// Mean product of slack and multiplier over all rows and bounds that are inequalities: the barrier
/// parameter whose central path passes nearest. Rows and bounds that `start` passes count as met
/// with no slack. 0 where there is no inequality or the program isn't defined there.
double mean_complementarity(transcription::NonlinearProgram& program, const Start& start);

/// `options` for a solve from a prolonged start: the first barrier, and slacks are hardly pushed.
SolverOptions prolonged_options(SolverOptions options, double barrier);

}  // namespace jaculus::solver::detail
