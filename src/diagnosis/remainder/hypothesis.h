#pragma once
// A description as a hypothesis: a file of an effect (jaculus-effect/1, effects/user_effect.h)
// whose formula is what the missing force was found to follow.
//
// At nominal the effect is nothing; scales, the deviations of the prior, are the sizes found, so
// that a diagnosis judges it as it judges what a user would have written. Periods and the places of
// springs are nominal where they were found. What no formula can read (accelerations, logged
// channels) makes no hypothesis: rotors and inertias are in the catalogue.

#include <string>
#include <vector>

#include "jaculus/diagnosis/remainder.h"
#include "jaculus/model/planar.h"

namespace jaculus::diagnosis {

/// Texts of files, the largest part of what is missing first, at most three.
std::vector<std::string> hypotheses_of(const Remainder& remainder, const model::PlanarModel& robot);

}  // namespace jaculus::diagnosis
