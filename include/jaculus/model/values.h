#pragma once
// The numbers of a model by the paths that overrides use.

#include <string>
#include <vector>

#include "jaculus/model/planar.h"

namespace jaculus::model {

/// A number of a model that an override may name.
struct ModelValue {
  std::string path;    ///< "bodies.base.mass"
  std::string alias;   ///< a shorter path of the same, "base.mass"; may be empty
  double value = 0.0;  ///< SI
};

/// All of them that are finite, in the order of override_paths(). Vectors, ranges and kinds are not
/// among them.
std::vector<ModelValue> model_values(const PlanarModel& model);

}  // namespace jaculus::model
