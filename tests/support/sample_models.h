#pragma once
// Small planar robots built in code, so that tests of the dynamics need no files.

#include <ostream>
#include <string>
#include <vector>

#include "jaculus/model/planar.h"

namespace jaculus::test_support {

struct NamedModel {
  std::string name;
  model::PlanarModel model;
};

inline std::ostream& operator<<(std::ostream& out, const NamedModel& m) { return out << m.name; }

/// Pendulum, slider with a rod, and a floating body with a five-bar leg, a prismatic leg and a tail
/// in the wind.
std::vector<NamedModel> sample_models();

}  // namespace jaculus::test_support
