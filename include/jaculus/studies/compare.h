#pragma once
// Comparison of solved problems: what a tail is worth, over no tail and over a tail that is only
// carried.
//
//   gain of A over B = a_A / a_B - 1,   a = v_x/T of the base (or of the centre of mass) [m/s^2]
//   gain of drag and inertia over gain of inertia alone = (a_drag - a_ref)/(a_inertial - a_ref) - 1
//
// with the reference once a robot without tail and once one with its tail held. Like is compared
// with like: the partner of a plan is the one of the wanted kind that was planned under the same
// conditions (limits, phases, ends, constraints); where there is none, the first of that kind
// serves and the figure is marked `unlike`.

#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/model/planar.h"
#include "jaculus/transcription/problem.h"

namespace jaculus::studies {

enum class TailKind {
  none,      ///< nothing that feels the air, nothing held
  held,      ///< a body with drag on the robot, its joint locked
  inertial,  ///< it moves, its drag is switched off
  drag       ///< it moves and feels the air
};

std::string to_string(TailKind kind);

/// What the tail of a problem may do. `model` is the robot with the problem's overrides, nothing
/// locked.
TailKind tail_kind(const transcription::Problem& problem, const model::PlanarModel& model);

/// Everything that must be alike for two plans to be compared, as text: limits, phases and grid,
/// bounds and ends of all that is not the tail, constraints, objective, transcription.
std::string conditions(const transcription::Problem& problem);

struct ComparedPlan {
  std::string name;
  TailKind kind = TailKind::none;
  std::string conditions;
  bool converged = false;
  double base_acceleration = kNaN;  ///< [m/s^2]
  double com_acceleration = kNaN;   ///< [m/s^2]
  double duration = kNaN;           ///< [s]
};

/// A gain over a partner; NaN where either did not converge.
struct Gain {
  std::string over;     ///< name of the partner; empty where there is none
  bool unlike = false;  ///< the partner was planned under other conditions
  double base = kNaN;   ///< [-]
  double com = kNaN;    ///< [-]
  double time = kNaN;   ///< share of the duration saved [-]
};

struct PlanGains {
  Gain over_first;     ///< over the robot without tail where one is there, else over the first plan
  Gain over_inactive;  ///< over the one with its tail held
};

/// Gains of each plan, in the order given.
std::vector<PlanGains> gains(const std::vector<ComparedPlan>& plans);

/// What drag adds to the gain of a tail's inertia.
struct DragWorth {
  std::string drag, inertial, over;  ///< names of the three plans
  bool unlike = false;               ///< not all three were planned under the same conditions
  double base = kNaN;  ///< gain of drag and inertia over gain of inertia alone, less one [-]
  double com = kNaN;
};

/// One for every plan with drag and every reference (no tail, tail held) that is there.
std::vector<DragWorth> drag_worth(const std::vector<ComparedPlan>& plans);

}  // namespace jaculus::studies
