#include "jaculus/simulation/plant.h"

#include <cmath>
#include <numbers>

namespace jaculus::simulation {

double Push::share_at(double t) const {
  return half_sine ? std::sin(std::numbers::pi * (t - start) / duration) : 1.0;
}

Plant nominal_plant(const model::PlanarModel& model) {
  Plant plant;
  plant.model = model;
  plant.ground.friction = model.friction;
  return plant;
}

}  // namespace jaculus::simulation
