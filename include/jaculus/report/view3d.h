#pragma once
// A robot's URDF moving along a plan or a log: one HTML file with three.js in it.

#include <string>

#include "jaculus/model/robot.h"
#include "jaculus/trajectory/csv.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::report {

/// The page of a plan, a table with the column `time`. Joints of a pair (robot.yaml) move alike.
/// InputError where nothing tells where the robot is, or where jaculus was built without its web
/// assets.
std::string view3d_html(const model::Robot& robot, const trajectory::Table& plan,
                        const std::string& title);

/// The page of a trial, likewise.
std::string view3d_html(const model::Robot& robot, const trajectory::Trial& trial,
                        const std::string& title);

}  // namespace jaculus::report
