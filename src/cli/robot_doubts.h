#pragma once
// What a robot file states and no robot has.

#include <string>
#include <vector>

#include "jaculus/model/robot.h"

namespace jaculus::cli {

/// Of a legged robot: largest torques beyond any motor's, and speeds with which none leaps. Files
/// have them as place holders.
std::vector<std::string> doubtful_limits(const model::Robot& robot);

}  // namespace jaculus::cli
