// The flat list of parameters: effects of the catalogue, unknown gains, start offsets.

#include "jaculus/diagnosis/hypotheses.h"

#include <cstddef>

namespace jaculus {

Vector Hypotheses::nominal() const {
  Vector p(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i) p[static_cast<Eigen::Index>(i)] = parameters[i].nominal;
  return p;
}

int Hypotheses::candidate(const std::string& name) const {
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (candidates[i].name == name) return static_cast<int>(i);
  return -1;
}

}  // namespace jaculus
