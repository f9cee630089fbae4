#pragma once
// Generalised forces that the plant may lack, along its coordinates and motors (hypotheses.h).

#include <string>
#include <utility>
#include <vector>

#include "jaculus/simulation/plant.h"

namespace jaculus::diagnosis {

/// A force of a motor that counts as large [N m, or N where it slides]: its limit, or for one
/// without what holds the robot's weight, at `lever` [m] where it turns.
double large_force(const model::PlanarModel& robot, const model::PlanarMotor& motor, double lever);

/// Coordinates along which a force may be missing, with one that counts as large [N m, or N where
/// it slides]: of the body its weight, or that at `lever` [m]; of a joint its motor's limit, or the
/// same.
std::vector<std::pair<std::string, double>> force_scales(const model::PlanarModel& robot,
                                                         double lever);

/// Whether a force along a coordinate can act on a robot.
bool has_place(const model::PlanarModel& robot, const std::string& name);

/// "N" of the body's x and z and of joints that slide, else "N m".
std::string force_unit(const model::PlanarModel& robot, const std::string& name);

/// A force of the world along one coordinate, `value` [N m or N] over a box of time [s].
simulation::Push box_push(const std::string& name, double value, double start, double duration);

}  // namespace jaculus::diagnosis
