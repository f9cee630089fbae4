#pragma once
// What stands in the way of a problem without a plan.

#include <string>

#include "jaculus/model/planar.h"
#include "jaculus/solver/elastic.h"

namespace jaculus::solver {

/// The limits that bind, strongest first, in one sentence: of which motors or feet, in which
/// phases, at what value, and how far the least infeasible point passes them. Empty where the
/// conflict is not known. `model`: what was planned with.
std::string binding_sentence(const Conflict& conflict, const model::PlanarModel& model);

}  // namespace jaculus::solver
