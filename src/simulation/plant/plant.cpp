#include "jaculus/simulation/plant.h"

namespace jaculus::simulation {

Plant nominal_plant(const model::PlanarModel& model) {
  Plant plant;
  plant.model = model;
  plant.ground.friction = model.friction;
  return plant;
}

}  // namespace jaculus::simulation
