// The flat list of parameters: effects of the catalogue, unknown gains and clocks, start offsets.

#include "diagnosis/forward/hypotheses.h"

#include <algorithm>
#include <cstddef>

namespace jaculus::diagnosis {

Vector Candidate::theta(const Vector& p) const {
  Vector own(count_of(parameters));
  for (std::size_t k = 0; k < parameters.size(); ++k) own[k] = p[parameters[k]];
  return own;
}

bool Candidate::is_event() const { return effect != nullptr && effect->event; }

bool Candidate::is_pattern() const { return effect != nullptr && effect->pattern; }

std::string told_name(const Candidate& candidate) {
  return candidate.is_pattern() ? candidate.effect->caption : candidate.name;
}

Vector Hypotheses::nominal() const {
  Vector p(count_of(parameters));
  for (std::size_t i = 0; i < parameters.size(); ++i) p[i] = parameters[i].nominal;
  return p;
}

Vector Hypotheses::scaled(const std::vector<int>& free, const Vector& p) const {
  Vector u(count_of(free));
  for (std::size_t i = 0; i < free.size(); ++i) {
    const FreeParameter& own = parameters[free[i]];
    const Bounds range = own.scaled_bounds();
    u[i] = std::clamp((p[free[i]] - own.nominal) / own.scale, range.lower, range.upper);
  }
  return u;
}

Vector Hypotheses::unscaled(const std::vector<int>& free, const Vector& u, Vector p) const {
  for (std::size_t i = 0; i < free.size(); ++i) {
    const FreeParameter& own = parameters[free[i]];
    p[free[i]] = std::clamp(own.nominal + own.scale * u[i], own.bounds.lower, own.bounds.upper);
  }
  return p;
}

std::vector<Vector> Hypotheses::gain_starts(const Vector& p) const {
  std::vector<Vector> starts = {p};
  for (const int i : gains) {
    const FreeParameter& own = parameters[i];
    for (const double move : {-own.scale, own.scale}) {
      if (!own.bounds.contains(p[i] + move)) continue;
      starts.push_back(p);
      starts.back()[i] += move;
    }
  }
  return starts;
}

bool Hypotheses::has_event(const std::vector<int>& members) const {
  return std::any_of(members.begin(), members.end(),
                     [&](int c) { return candidates[c].is_event(); });
}

bool Hypotheses::beyond_effects(const std::vector<int>& members) const {
  return std::any_of(members.begin(), members.end(),
                     [&](int c) { return candidates[c].beyond_effects(); });
}

bool Hypotheses::beyond_effects() const {
  return std::any_of(candidates.begin(), candidates.end(),
                     [](const Candidate& candidate) { return candidate.beyond_effects(); });
}

std::vector<effects::Effect> Hypotheses::effects_of(const std::vector<int>& members) const {
  std::vector<effects::Effect> effects;
  for (const int c : members)
    if (candidates[c].effect != nullptr) effects.push_back(*candidates[c].effect);
  return effects;
}

std::vector<int> Hypotheses::nuisances() const {
  std::vector<int> all = gains;
  all.insert(all.end(), tolerances.begin(), tolerances.end());
  return all;
}

std::vector<int> Hypotheses::parameters_of(const std::vector<int>& members) const {
  std::vector<int> all;
  for (const int c : members) {
    const std::vector<int>& own = candidates[c].parameters;
    all.insert(all.end(), own.begin(), own.end());
  }
  return all;
}

std::vector<int> Hypotheses::freed_by(const std::vector<int>& members) const {
  std::vector<int> free = parameters_of(members);
  const std::vector<int> fitted = nuisances();
  free.insert(free.end(), fitted.begin(), fitted.end());
  return free;
}

Vector Hypotheses::with_nuisances_of(Vector p, const Vector& other) const {
  for (const int i : nuisances()) p[i] = other[i];
  return p;
}

Vector Hypotheses::without_effects(Vector p, const std::vector<int>& members) const {
  for (const int i : parameters_of(members)) p[i] = parameters[i].nominal;
  return p;
}

int Hypotheses::candidate(const std::string& name) const {
  for (int i = 0; i < count_of(candidates); ++i)
    if (candidates[i].name == name) return i;
  return -1;
}

}  // namespace jaculus::diagnosis
