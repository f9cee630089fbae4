#pragma once
// The files of a plan: what a solve leaves in its folder.
//
//   plan.csv         the motion, torques and forces over time
//   iterations.csv   how the solver went, without times, so that every run writes the same
//   solution.json    variables and multipliers, to start another solve from
//   timing.json      wall seconds, apart from everything that is the same on every run
//   summary.json     see summary.h; written last: where it is, the others are

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "jaculus/solver/plan.h"
#include "jaculus/solver/summary.h"
#include "jaculus/trajectory/csv.h"
#include "jaculus/trajectory/trajectory.h"

namespace jaculus::solver {

/// A plan without the nonlinear program that made it.
struct SolvedPlan {
  Summary summary;
  /// the plan, or the last iterate where the solve did not converge
  std::optional<trajectory::Trajectory> trajectory;
  /// primal and dual, to resume or warm-start; null where there is none
  nlohmann::ordered_json solution;
  std::vector<IterationInfo> history;  ///< every iteration of the solver
  WallSeconds wall_seconds;            ///< that the solve took
};

/// The figures and the motion of a plan of `problem`.
SolvedPlan solved_plan(const Plan& plan, const transcription::Problem& problem);

/// Writes the files above into a folder that exists; unwritable: InputError.
void write_plan(const SolvedPlan& solved, const std::filesystem::path& folder);

/// The tables of a plan's folder.
struct PlanTables {
  trajectory::Table plan;     ///< plan.csv; no columns where there is no plan
  trajectory::Table history;  ///< iterations.csv; no columns where there is none
};

PlanTables plan_tables(const SolvedPlan& solved);

/// What write_plan() wrote into `folder`.
PlanTables read_plan_tables(const std::filesystem::path& folder);

}  // namespace jaculus::solver
