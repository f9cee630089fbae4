#pragma once
// Moves of a search from a fitted model to sets next to it (neighbouring_sets.h): judged by linear
// algebra about it (linear_sets.h), the best of them fitted.

#include <vector>

#include "diagnosis/selection/fitted_models.h"

namespace jaculus::diagnosis {

/// A fitted model and the candidates as they look from there.
struct Surroundings {
  const Problem& problem;
  const Whitening& whitening;
  ModelFit about;
  const std::vector<Probe>& probes;

  /// Some sets by linear algebra, the most probable first, the foremost where they are many.
  [[nodiscard]] std::vector<LinearSet> judged(std::vector<Members> sets) const;
  /// The most probable of some sets, those that are sought and were not fitted yet.
  [[nodiscard]] std::vector<LinearSet> best_of(std::vector<Members> sets,
                                               const FittedModels& models, int count) const;
  /// Log prior x evidence by that algebra.
  [[nodiscard]] double weight(double log_evidence, const Members& members) const;
};

/// Fits what by linear algebra leads among sets larger than the leading model, the first two and
/// then the others unless one of those leads clearly; whether one of them leads now.
bool enlarge(const Surroundings& near, int largest, FittedModels& models);

/// Sets of two effects more that by linear algebra lead every set of one more: neither may help
/// without the other. Those that are sought and were not fitted yet.
std::vector<LinearSet> two_at_once(const Surroundings& near, int largest,
                                   const FittedModels& models);

/// Fits sets of the leading model's size with one member exchanged: what stands in for it, unless
/// slopes leave it far behind.
void exchange_members(const Surroundings& near, FittedModels& models);

/// Fits sets in which each joint has its own value of what joints share in the leading model, or
/// all the same in place of their own, or a member has fewer parameters.
void part_members(const Surroundings& near, int largest, FittedModels& models);

}  // namespace jaculus::diagnosis
