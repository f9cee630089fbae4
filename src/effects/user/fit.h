#pragma once
// Whether a robot can have a user's effect: its joints, motors, bodies and channels, and what units
// formulas have with them.

#include <optional>
#include <string>
#include <vector>

#include "effects/user/program.h"
#include "effects/user/spec.h"

namespace jaculus::effects {

/// InputError, with the place in the file, where it can't.
void require_robot(const EffectSpec& spec, const model::PlanarModel& model);
/// The same, and the units of formulas by what the robot's joints are.
void require_units(const EffectSpec& spec, const model::PlanarModel& model);

/// Whether a reading is of a body or its point.
bool of_body(simulation::ReadingKind kind);

/// A body and a point of it.
struct BodyPoint {
  std::string body;
  Vec2 point = Vec2::Zero();  ///< [m]
};
/// A body, foot or other point by its name; nothing where the robot has none.
std::optional<BodyPoint> body_point(const model::PlanarModel& model, const std::string& name);

/// Joints of the place in a robot.
std::vector<std::string> joints_of(const EffectPlace& place, const model::PlanarModel& model);

}  // namespace jaculus::effects
