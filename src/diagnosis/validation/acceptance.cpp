#include "diagnosis/validation/acceptance.h"

#include <algorithm>
#include <optional>

#include "diagnosis/validation/subset_fit.h"

namespace jaculus::diagnosis {
namespace {

/// The set without one member.
ModelFit without_member(const Problem& problem, const Comparison& comparison,
                        const Posterior& posterior, const ModelFit& model, int dropped) {
  std::vector<int> members = model.candidates;
  std::erase(members, dropped);
  return fitted_subset(problem, comparison, posterior, model, members);
}

/// Whether a set leaves so much less of the held-out gap than a smaller one that the difference is
/// worth a name.
bool needed(const HeldOut& with, const HeldOut& without, const Settings& settings) {
  const auto left = [](const HeldOut& gap) { return std::max(0.0, gap.after * gap.after - 1.0); };
  return with.after < (1.0 - settings.least_improvement) * without.after &&
         left(without) >= settings.named_beside * left(with);
}

}  // namespace

ModelFit without_idle_members(const Problem& problem, const Comparison& comparison,
                              const Posterior& posterior, HeldOutGaps& gaps, ModelFit model) {
  while (model.candidates.size() > 1 && gaps.of(model).valid) {
    std::optional<ModelFit> best;
    for (const int dropped : model.candidates) {
      ModelFit less = without_member(problem, comparison, posterior, model, dropped);
      if (!less.fit.valid || !gaps.of(less).valid) continue;
      if (!best || gaps.of(less).after < gaps.of(*best).after) best = std::move(less);
    }

    if (!best || needed(gaps.of(model), gaps.of(*best), problem.settings)) break;
    model = std::move(*best);
  }
  return model;
}

}  // namespace jaculus::diagnosis
