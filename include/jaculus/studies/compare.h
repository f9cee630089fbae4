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
// serves and the figure is marked `unlike`. A ratio to next to nothing says nothing: below
// kLeastAcceleration and kLeastGain it is NaN, and the change in m/s^2 stands for it.

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

/// Least acceleration that another is a ratio of [m/s^2]: a hundredth of gravity, which a floor
/// that leans by half a degree gives to whatever slides on it.
inline constexpr double kLeastAcceleration = 0.1;
/// Least gain that another is a ratio of, over the reference's acceleration [-]. Plans of one leap
/// on other meshes and from other starts differ by 0.5 to 1 % (docs/paper.md), the difference of
/// two by as much again.
inline constexpr double kLeastGain = 0.02;

/// A gain over a partner; NaN where either did not converge.
struct Gain {
  std::string over;           ///< name of the partner; empty where there is none
  bool unlike = false;        ///< the partner was planned under other conditions
  double base = kNaN;         ///< [-]; NaN where the partner hardly accelerates
  double com = kNaN;          ///< [-]; the same
  double time = kNaN;         ///< share of the duration saved [-]
  double base_change = kNaN;  ///< [m/s^2]
  double com_change = kNaN;   ///< [m/s^2]
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
  /// gain of drag and inertia over gain of inertia alone, less one [-]; NaN where inertia alone
  /// gains next to nothing
  double base = kNaN;
  double com = kNaN;
  double base_change = kNaN;  ///< what drag adds to inertia [m/s^2]
  double com_change = kNaN;   ///< [m/s^2]
};

/// One for every plan with drag and every reference (no tail, tail held) that is there.
std::vector<DragWorth> drag_worth(const std::vector<ComparedPlan>& plans);

}  // namespace jaculus::studies
