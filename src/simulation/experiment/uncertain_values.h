#pragma once
// The model values that an experiment's `uncertainties` name.

#include <string>
#include <vector>

#include "jaculus/core/error.h"
#include "jaculus/model/values.h"

namespace jaculus::simulation {

/// Those of `all`, the values of `robot`, that a pattern names by path or alias; "*" stands for one
/// part between dots. InputError at `place` where it names none.
std::vector<model::ModelValue> values_named(const std::string& pattern,
                                            const std::vector<model::ModelValue>& all,
                                            const std::string& robot, const InputPlace& place);

}  // namespace jaculus::simulation
