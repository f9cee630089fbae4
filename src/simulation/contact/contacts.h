#pragma once
// Contacts that push only, and where they are at a state of the mechanism: feet and other points on
// the floor, joints at their stops.

#include <string>
#include <vector>

#include "jaculus/simulation/plant.h"
#include "simulation/plant/mechanism.h"

namespace jaculus::simulation::detail {

/// A contact that pushes only: a foot, another point, or a joint's stop.
struct Unilateral {
  std::string name;              ///< of the foot, point or joint
  int body = 0;                  ///< that it is on; of a stop: the joint's link
  Vec2 position = Vec2::Zero();  ///< in the body's frame [m]
  double radius = 0.0;           ///< of a foot [m]
  int count = 1;                 ///< left and right
  double mu = -1.0;              ///< Coulomb's coefficient [-]; negative: a stop
  double side = 0.0;             ///< of a stop: +1 keeps above `bound`, -1 below
  double bound = 0.0;            ///< [rad or m]
  double restitution = 0.0;      ///< of a stop [-]
  int foot = -1;                 ///< index of the model's feet, -1: none of them

  [[nodiscard]] bool stop() const { return side != 0.0; }
};

/// All of a plant's, feet first, then other points, then stops. InputError where a name is unknown.
std::vector<Unilateral> unilaterals_of(const Plant& plant);

/// A unilateral contact at a state.
struct ContactState {
  double gap;                  ///< negative: beyond [m or rad]
  double normal_rate;          ///< of the gap [m/s or rad/s]
  double tangential_rate;      ///< along the floor [m/s]; zero for a stop
  double normal_bias;          ///< acceleration at zero generalised acceleration [m/s^2 or rad/s^2]
  double tangential_bias;      ///< [m/s^2]
  Row normal{}, tangential{};  ///< d(rates)/dv
};

/// Where `mechanism` stands, at q and v.
void set_contact(const Mechanism& mechanism, const Unilateral& unilateral, double floor,
                 const double* q, const double* v, ContactState& out);

}  // namespace jaculus::simulation::detail
