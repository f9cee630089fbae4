#pragma once

#include <string>
#include <vector>

#include "jaculus/model/robot.h"

namespace jaculus::model {

/// One line on a robot's size: bodies, mass, coordinates, motors, loops.
std::string size_line(const Robot& robot);

/// What was understood of a robot, for people: its size and notes.
std::string describe_robot(const Robot& robot);

/// Friction that the robot's file states at joints whose motor has none in robot.yaml, or that have
/// no motor, one sentence for each kind: plans and simulations don't know it, the robot has it.
std::vector<std::string> friction_left_out(const Robot& robot);

}  // namespace jaculus::model
