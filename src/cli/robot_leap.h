#pragma once
// A leap for a robot that was imported, in terms of its own size, weight and motors.

#include <filesystem>
#include <string>

#include "jaculus/model/propose.h"
#include "jaculus/model/robot.h"

namespace jaculus::cli {

/// Writes leap.yaml, a problem for `jaculus solve`, where the robot has front_foot and rear_foot
/// and motors that turn; returns its name, else nothing. With L the leg's length and W the weight:
/// from rest to sqrt(g L) / 2 forward, phases scaled by sqrt(L / g), largest torques as robot.yaml
/// has them or W L / 4 where none is known.
std::string write_first_leap(const model::Robot& robot, const model::Proposal& proposal,
                             const std::filesystem::path& folder);

}  // namespace jaculus::cli
