#pragma once
// Poses that stay: torques that hold one, and the place that loose parts find by themselves.

#include <vector>

#include "simulation/contact/plant_equations.h"

namespace jaculus::simulation::detail {

/// Torques u before the gears [N m] that come nearest to keeping the accelerations zero at given
/// modes: least |a(u)|^2, a being affine in u; of several the smallest u. From then on the
/// equations command them, until the controller's first command. False where they are singular.
bool hold_by_torques(PlantEquations& equations, double t, const State& y,
                     const std::vector<Touch>& modes);

/// Turns y, which is at rest, into the static equilibrium of what neither a motor nor a rigid
/// contact holds: hinges hang, a compliant floor carries. A y that moves stays as it is. False
/// where there is none.
bool settle_loose_parts(PlantEquations& equations, double t, const std::vector<Touch>& modes,
                        State& y);

}  // namespace jaculus::simulation::detail
