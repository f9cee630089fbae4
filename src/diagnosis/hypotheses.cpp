// The flat list of parameters: effects of the catalogue, unknown gains, start offsets.

#include "jaculus/diagnosis/hypotheses.h"

#include <algorithm>
#include <cstddef>

namespace jaculus {

Vector Candidate::theta(const Vector& p) const {
  Vector own(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t k = 0; k < parameters.size(); ++k) own[static_cast<Eigen::Index>(k)] = p[parameters[k]];
  return own;
}

Vector Hypotheses::nominal() const {
  Vector p(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t i = 0; i < parameters.size(); ++i) p[static_cast<Eigen::Index>(i)] = parameters[i].nominal;
  return p;
}

Vector Hypotheses::scaled(const std::vector<int>& free, const Vector& p) const {
  Vector u(static_cast<Eigen::Index>(free.size()));
  for (std::size_t i = 0; i < free.size(); ++i) {
    const FreeParameter& own = parameters[static_cast<std::size_t>(free[i])];
    u[static_cast<Eigen::Index>(i)] =
        std::clamp((p[free[i]] - own.nominal) / own.scale, (own.bounds.lower - own.nominal) / own.scale,
                   (own.bounds.upper - own.nominal) / own.scale);
  }
  return u;
}

Vector Hypotheses::unscaled(const std::vector<int>& free, const Vector& u, Vector p) const {
  for (std::size_t i = 0; i < free.size(); ++i) {
    const FreeParameter& own = parameters[static_cast<std::size_t>(free[i])];
    p[free[i]] =
        std::clamp(own.nominal + own.scale * u[static_cast<Eigen::Index>(i)], own.bounds.lower, own.bounds.upper);
  }
  return p;
}

std::vector<int> Hypotheses::freed_by(const std::vector<int>& members) const {
  std::vector<int> free;
  for (const int c : members) {
    const std::vector<int>& own = candidates[static_cast<std::size_t>(c)].parameters;
    free.insert(free.end(), own.begin(), own.end());
  }
  free.insert(free.end(), nuisances.begin(), nuisances.end());
  return free;
}

int Hypotheses::candidate(const std::string& name) const {
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (candidates[i].name == name) return static_cast<int>(i);
  return -1;
}

}  // namespace jaculus
