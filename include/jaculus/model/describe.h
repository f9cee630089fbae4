#pragma once

#include <string>

#include "jaculus/model/robot.h"

namespace jaculus::model {

/// What was understood of a robot, for people: its size and notes.
std::string describe_robot(const Robot& robot);

}  // namespace jaculus::model
