#pragma once
// A robot's URDF moving along a plan or a log: one HTML file with three.js in it.

#include <string>

#include "jaculus/model/robot.h"
#include "jaculus/report/stick_figure.h"

namespace jaculus {

/// The page. Joints of a pair (robot.yaml) move alike. InputError where nothing tells where the robot is, or where jaculus was built
/// without its web assets.
std::string view3d_html(const Robot& robot, const MotionChannels& channels, const std::string& title);

}  // namespace jaculus
