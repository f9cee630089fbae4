#pragma once
// A leap planned again with the effect known: what was planned against what the robot with the
// effect then does, before and after.
//
//   before: the problem as it stands
//   after: with the effect's model values in its overrides (Effect::overrides)
//   planned acceleration  = forward velocity of the base at the plan's end over its duration
//   realised acceleration = the same of the robot at that time, the plan replayed with torque
//       feed-forward and joint PD at 1 kHz
// The robot is a plant with the effect, or the testbed's with a physical change. Neither knows of
// the plan's margins.

#include <filesystem>
#include <functional>
#include <string>

#include "jaculus/effects/select.h"
#include "jaculus/solver/plan.h"
#include "jaculus/testbed/changes.h"

namespace jaculus::evaluation {

/// Replays a plan (columns of plan.csv) and returns the base's forward velocity at the plan's end
/// [m/s]; NaN where the robot did not get that far.
using PlanReplay = std::function<double(const trajectory::Table& plan)>;

/// On a plant of the robot in `folder` with `effects`.
PlanReplay replay_on_plant(const std::filesystem::path& folder,
                           const std::vector<effects::EffectValue>& effects);
/// On the testbed's robot, changed. InputError where the build has no MuJoCo.
PlanReplay replay_on_testbed(const std::filesystem::path& folder, const testbed::Changes& changes);

struct ReplanFigures {
  std::string status;  ///< of the solve
  bool converged = false;
  double duration = kNaN;                                            ///< of the plan [s]
  double planned_speed = kNaN, realised_speed = kNaN;                ///< [m/s]
  double planned_acceleration = kNaN, realised_acceleration = kNaN;  ///< [m/s^2]

  /// What the robot falls short of its plan by [m/s^2].
  [[nodiscard]] double shortfall() const { return planned_acceleration - realised_acceleration; }
};

struct Replan {
  /// false: the effect has no model values, so that `after` is `before`
  bool planner_knows = false;
  std::vector<effects::ModelOverride> overrides;  ///< that the second plan had
  ReplanFigures before, after;
};

/// Plans twice and replays both. Numerical failure is a status; a problem that does not fit its
/// robot an InputError.
Replan replan(const transcription::Problem& problem,
              const std::vector<effects::EffectValue>& effects, const PlanReplay& replay,
              const solver::PlanOptions& options = {});

std::string replan_json(const Replan& replan);
std::string replan_text(const Replan& replan);

}  // namespace jaculus::evaluation
