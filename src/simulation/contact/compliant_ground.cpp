#include "simulation/contact/compliant_ground.h"

#include <algorithm>
#include <cmath>

namespace jaculus::simulation::detail {

namespace {

/// Along the floor a sole is stiffer than the floor under it by this factor, with a damper of this
/// time constant beside the spring [s]: plates give way downwards, and a sole's rubber shears by
/// little.
constexpr double kSoleStiffness = 20.0, kSoleTime = 1e-4;

}  // namespace

CompliantGround::CompliantGround(const Plant& plant)
    : compliance_(plant.ground.compliance),
      damping_ratio_(plant.ground.damping_ratio),
      friction_(plant.ground.friction) {
  int feet = 0;
  for (const model::PlanarPoint& foot : plant.model.feet) feet += foot.count;
  mass_of_foot_ = plant.model.total_mass() / std::max(1, feet);
}

SoleState CompliantGround::sole(const Unilateral& point, const ContactState& c, bool touches,
                                double bristle) const {
  const double stiffness = point.count / compliance_;
  const double damping = 2.0 * damping_ratio_ * std::sqrt(stiffness * point.count * mass_of_foot_);

  SoleState s;
  s.normal = touches ? std::max(0.0, -stiffness * c.gap - damping * c.normal_rate) : 0.0;
  const double shear = kSoleStiffness * stiffness, cone = friction_ * s.normal;
  const double free = -shear * (bristle + kSoleTime * c.tangential_rate);
  s.tangential = std::clamp(free, -cone, cone);

  const bool sticks = s.tangential == free;
  s.touch = sticks ? Touch::stick : (free > 0.0 ? Touch::slip_minus : Touch::slip_plus);
  s.bristle_rate = sticks ? c.tangential_rate : -(bristle + s.tangential / shear) / kSoleTime;
  return s;
}

}  // namespace jaculus::simulation::detail
