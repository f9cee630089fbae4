#include "jaculus/simulation/plant.h"

namespace jaculus {

Plant nominal_plant(const PlanarModel& model) {
  Plant plant;
  plant.model = model;
  plant.ground.friction = model.friction;
  return plant;
}

}  // namespace jaculus
