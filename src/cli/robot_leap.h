#pragma once
// A leap for a robot that was imported, in terms of its own size, weight and motors.

#include <filesystem>
#include <string>

#include "jaculus/model/propose.h"
#include "jaculus/model/robot.h"

namespace jaculus::cli {

/// Torque behind the gear that is assumed of motors whose torque nobody stated, over weight times
/// leg length [-].
inline constexpr double kTorqueAssumed = 0.25;

/// Writes leap.yaml, which extends problems/leap_template.yaml, where the robot has front_foot and
/// rear_foot and motors that turn; returns its name, else nothing. It says what the template can't
/// know: a largest torque of W L / 4 and ranges of 3 rad where the file states none.
std::string write_first_leap(const model::Robot& robot, const model::Proposal& proposal,
                             const std::filesystem::path& folder);

}  // namespace jaculus::cli
