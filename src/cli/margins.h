#pragma once
// Margins of replays under an experiment's uncertainties: simulate --perturb.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "jaculus/simulation/experiment.h"

namespace jaculus::cli {

/// Of replays, the first of which is nominal.
nlohmann::ordered_json perturb_json(const std::vector<simulation::Replay>& all);
std::string perturb_text(const nlohmann::ordered_json& json);

}  // namespace jaculus::cli
