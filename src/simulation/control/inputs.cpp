#include "simulation/control/inputs.h"

#include <fmt/format.h>

#include <algorithm>

#include "jaculus/core/error.h"

namespace jaculus::simulation::detail {

Inputs::Inputs(const Plant& plant, const Controller& controller)
    : plant_(plant), controller_(plant, controller), quantity_(controller.quantity) {
  for (const Push& push : plant.pushes)
    if (!push.joint.empty() && plant.model.body_of_joint(push.joint) < 0)
      throw InputError(fmt::format("push: the robot has no joint '{}'", push.joint));
}

double Inputs::next_change(double t) const {
  double next = controller_.next_change(t);
  for (const Push& push : plant_.pushes)
    for (const double at : {push.start, push.start + push.duration})
      if (at > t) next = std::min(next, at);
  return next;
}

void Inputs::update(double t, const double* position, const double* velocity) {
  controller_.update(t, position, velocity);
  if (!controller_.waiting()) hold_.clear();

  acting_.clear();
  for (const Push& push : plant_.pushes)
    if (t >= push.start && t < push.start + push.duration) acting_.push_back(&push);
}

}  // namespace jaculus::simulation::detail
