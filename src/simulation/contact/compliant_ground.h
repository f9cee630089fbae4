#pragma once
// A floor that gives way: forces, no constraints. Normal force of Kelvin and Voigt without pull (m:
// the robot's mass over its feet), and a sole that is a spring and a damper side by side in series
// with a slider:
//     f_z = max(0, d/c + 2 zeta sqrt(m/c) d'),   f_t = -20 (s + T v_t)/c within +-mu f_z,
//     s' = -(s + c f_t/20)/T   (= v_t while it sticks).
// Forces are continuous in the state, so that stick and slip are no events here, only landing and
// lifting are.

#include <vector>

#include "simulation/contact/contact_law.h"
#include "simulation/contact/contacts.h"

namespace jaculus::simulation::detail {

/// What the floor does at one sole.
struct SoleState {
  double tangential = 0.0, normal = 0.0;  ///< force of the floor [N]
  double bristle_rate = 0.0;              ///< s' [m/s]
  Touch touch = Touch::stick;             ///< whether it sticks or slips
};

class CompliantGround {
 public:
  explicit CompliantGround(const Plant& plant);

  /// Whether the floor gives way at all.
  [[nodiscard]] bool present() const { return compliance_ > 0.0; }
  /// `touches`: whether the sole is in contact; `bristle`: its deflection s [m].
  [[nodiscard]] SoleState sole(const Unilateral& point, const ContactState& contact, bool touches,
                               double bristle) const;

 private:
  double compliance_;     ///< of one foot of a pair [m/N]
  double damping_ratio_;  ///< [-]
  double friction_;       ///< [-]
  double mass_of_foot_;   ///< the robot's, over its feet left and right [kg]
};

}  // namespace jaculus::simulation::detail
