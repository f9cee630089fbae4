#pragma once
// Commands from a plan's table, for the motors of a robot on the testbed.

#include <filesystem>
#include <string>

#include "jaculus/testbed/motor_commands.h"
#include "jaculus/testbed/trials.h"
#include "jaculus/trajectory/csv.h"
#include "testbed/robot_files.h"

namespace jaculus::testbed {

/// A plan as commands and the pose in which it begins.
struct PlanCommands {
  Commands commands;
  std::map<std::string, double> start;
  double duration = 0.0;  ///< [s]
};

/// Columns <joint>, <joint>_velocity and, by `quantity`, <joint>_torque (at the joint; its gear is
/// divided out), <joint>_duty or <joint>_voltage. A joint of the robot that the plan lacks, a gap
/// or time that falls: InputError with the file.
PlanCommands plan_commands(const trajectory::Table& plan, const RobotFiles& files,
                           trajectory::Quantity quantity, const std::filesystem::path& file);

/// What a dataset asks for, as commands; the pose that it states wins over the plan's. Of `spec`
/// the places of gains within stated ranges count. InputError for commands that do not fit.
PlanCommands dataset_commands(const trajectory::Dataset& asked, const RobotFiles& files,
                              const TrialSpec& spec);

}  // namespace jaculus::testbed
