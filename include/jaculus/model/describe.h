#pragma once

#include <string>

#include "jaculus/model/robot.h"

namespace jaculus::model {

/// One line on a robot's size: bodies, mass, coordinates, motors, loops.
std::string size_line(const Robot& robot);

/// What was understood of a robot, for people: its size and notes.
std::string describe_robot(const Robot& robot);

}  // namespace jaculus::model
