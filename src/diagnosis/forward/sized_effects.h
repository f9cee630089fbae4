#pragma once
// Candidate effects as the robots of these data have them.

#include <map>
#include <string>
#include <vector>

#include "diagnosis/data/observations.h"
#include "jaculus/effects/effect.h"
#include "jaculus/simulation/plant.h"

namespace jaculus::diagnosis {

/// Of some effects those that a dataset can show, with priors, bounds and units of the first robot
/// that can have them, and of each joint alone where several share one (Effect::sized). Typical
/// rates of joints are those of the data where a logged input drives them: root mean square of the
/// windows' starts.
std::vector<effects::Effect> sized_effects(const std::vector<ObservedDataset>& datasets,
                                           const std::vector<const effects::Effect*>& effects);

/// Dry friction of a plant's joints holds them below the rates that the data's are slow beside
/// (effects::rest_rate).
struct RestRates {
  std::map<std::string, double> rates;  ///< of joints with a motor [rad/s, m/s where it slides]
  void apply(simulation::Plant& plant) const;
};
RestRates rest_rates(const ObservedDataset& observed);

}  // namespace jaculus::diagnosis
