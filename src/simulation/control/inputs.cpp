#include "simulation/control/inputs.h"

#include <algorithm>

namespace jaculus::simulation::detail {

Inputs::Inputs(const Plant& plant, const Controller& controller)
    : plant_(plant), controller_(plant, controller), quantity_(controller.quantity) {}

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
