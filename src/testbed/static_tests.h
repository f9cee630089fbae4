#pragma once
// What a test of the changed robot itself shows of an effect's parameters, where the build is not
// the parameter: the shaft's stiffness under a force at the scoop, play under torque both ways,
// restitution of a tail thrown at its stop, a plate's yielding under load. Everything else is what
// MuJoCo's model holds.

#include <string>
#include <vector>

#include "jaculus/testbed/changes.h"
#include "testbed/robot_files.h"

namespace jaculus::testbed {

/// Parameters in the catalogue's order and terms; NaN where the testbed's law has no such number.
std::vector<double> measured_parameters(const std::string& effect, const std::vector<double>& typed,
                                        const RobotFiles& files, const Changes& changes);

}  // namespace jaculus::testbed
