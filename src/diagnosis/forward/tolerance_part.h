#pragma once
// What tolerances add to an effect of the same quantity.
//
// A joint may rub by its builder's tolerance and by an effect: data tell the sum, priors share it
// out, and a user who is told one part is told too little. With n(theta, t) the quantities that
// tolerances move (ToleranceDirection::reads), G = dn/dtheta and T = dn/dt at (theta, 0), the
// tolerances t are as good as a change of the effect's parameters by
//   D t,   D = argmin |G D - T|^2 = G^+ T,
// so that theta + D t is by how much the robot's quantities are off their files, an effect of
// several joints by the mean over them. Effects that move no such quantity have D = 0.

#include <vector>

#include "diagnosis/forward/tolerance_directions.h"
#include "jaculus/effects/effect.h"

namespace jaculus::diagnosis {

/// D at `theta`, parameters of the effect x directions [a parameter's unit a deviation].
Matrix tolerance_part(const simulation::Plant& nominal, const effects::Effect& effect,
                      const Vector& theta, const std::vector<ToleranceDirection>& directions);

}  // namespace jaculus::diagnosis
