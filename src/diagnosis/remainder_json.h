#pragma once
// What a diagnosis leaves, as diagnosis.json has it.

#include <nlohmann/json.hpp>

#include "jaculus/diagnosis/diagnosis.h"

namespace jaculus::diagnosis {

/// The entry `remainder`: share of the gap, whether it is established that something is left, the
/// places with what their forces follow, and events.
nlohmann::ordered_json remainder_json(const Diagnosis& d);

}  // namespace jaculus::diagnosis
