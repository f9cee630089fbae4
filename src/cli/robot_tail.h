#pragma once
// A tail proposed for an imported robot.

#include <string>

#include "jaculus/model/robot.h"

namespace jaculus::cli {

/// `attach` of robot.yaml: Minitaur's tail (Norby et al. 2021) in proportion to this robot's legs,
/// at the hips of its rear ones, turned by a motor like theirs. `mass`: as the key `mass` takes it.
/// InputError where the robot has no rear_foot or no motor in that leg.
std::string tail_section(const model::Robot& robot, const std::string& mass);

/// InputError where `mass` is neither a mass nor a share in percent; empty is none.
void check_tail_mass(const std::string& mass);

/// Gives joints that state no largest torque or speed those of their motors, as joints of what is
/// attached, for other programs.
void state_limits(const model::PlanarModel& model, model::SpatialTree& tree);

}  // namespace jaculus::cli
