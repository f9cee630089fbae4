#include "diagnosis/forward/sized_effects.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "effects/scope.h"

namespace jaculus::diagnosis {

using effects::Effect;

namespace {

/// Rates of driven joints in data that a logged input drives: of the windows' starts, rms.
effects::JointRates joint_rates(const ObservedDataset& observed) {
  effects::JointRates rates;
  if (!observed.measured_input) return rates;
  for (int i = 0; i < observed.model.size(); ++i) {
    double sum = 0.0;
    for (const Segment& segment : observed.segments) sum += segment.start_v[i] * segment.start_v[i];
    rates[observed.model.coordinates[i].name] =
        std::sqrt(sum / static_cast<double>(observed.segments.size()));
  }
  return rates;
}

}  // namespace

std::vector<Effect> sized_effects(const std::vector<ObservedDataset>& datasets,
                                  const std::vector<const Effect*>& effects) {
  std::vector<Effect> out;
  for (const Effect* effect : effects) {
    const auto applies = [&](const ObservedDataset& d) {
      return effect->applies(d.model) && !(effect->of_plan && d.measured_input);
    };
    const auto first = std::find_if(datasets.begin(), datasets.end(), applies);
    if (first == datasets.end()) continue;
    for (Effect& own : effects::sized_for(*effect, first->model, joint_rates(*first)))
      out.push_back(std::move(own));
  }
  return out;
}

void RestRates::apply(simulation::Plant& plant) const {
  for (simulation::JointFriction& friction : plant.friction)
    if (const auto own = rates.find(friction.joint); own != rates.end())
      friction.smoothing_rate = own->second;
}

RestRates rest_rates(const ObservedDataset& observed) {
  const effects::JointRates shown = joint_rates(observed);
  RestRates rest;
  for (const model::PlanarMotor& motor : observed.model.motors)
    rest.rates[motor.joint] = effects::rest_rate(observed.model, motor.joint, shown);
  return rest;
}

}  // namespace jaculus::diagnosis
