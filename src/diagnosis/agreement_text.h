#pragma once
// An agreement as JSON and as printed lines.

#include <nlohmann/json.hpp>
#include <string>

#include "jaculus/diagnosis/agreement.h"

namespace jaculus::diagnosis {

/// {"unknowns": {name: {...}}, "sets": [...], "energy_explained": {channel: {...}}}, SI.
nlohmann::ordered_json agreement_json(const Agreement& agreement);
/// A line for the unknowns, one a dataset, one for all; empty without any.
std::string agreement_text(const Agreement& agreement);

}  // namespace jaculus::diagnosis
