#include "diagnosis/validation/acceptance.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "diagnosis/selection/neighbouring_sets.h"
#include "diagnosis/validation/shares.h"

namespace jaculus::diagnosis {
namespace {

/// The set without one member.
const ModelFit& without_member(HeldOutGaps& gaps, const ModelFit& model, int dropped) {
  return gaps.subset(model, without_one(model.candidates, dropped));
}

/// Whether a set leaves so much less of the held-out gap than a smaller one that the difference is
/// worth a name.
bool needed(const HeldOut& with, const HeldOut& without, const Settings& settings) {
  const auto left = [](const HeldOut& gap) { return std::max(0.0, gap.after * gap.after - 1.0); };
  return with.after < (1.0 - settings.least_improvement) * without.after &&
         left(without) >= settings.named_beside * left(with);
}

/// Whether a set is so much more probable than a smaller one, each with tolerances of its own, that
/// held-out data need not be predicted better with it, but no worse: tolerances may take the place
/// of a member at a price that held-out data don't ask. Under a plan alone: under a logged input
/// tolerances are few, and evidence asks for delays that move nothing.
bool more_probable(HeldOutGaps& gaps, const ModelFit& model, const ModelFit& smaller) {
  if (in_windows(gaps.problem())) return false;
  const Settings& settings = gaps.settings();
  const ModelFit &with = gaps.fitted(model), &without = gaps.fitted(smaller);
  return with.log_weight_there() - without.log_weight_there() >= settings.strong_odds &&
         no_worse(gaps.of(with).after, gaps.of(without).after, settings);
}

/// Whether a condition that no fit saw is predicted better without a member, and all together no
/// worse.
bool harms_a_condition(const HeldOut& with, const HeldOut& without, const Settings& settings) {
  if (without.after > with.after) return false;
  for (std::size_t f = 0; f < with.by_fold.size(); ++f)
    if (without.by_fold[f].after < (1.0 - settings.least_improvement) * with.by_fold[f].after)
      return true;
  return false;
}

/// What a member explains at most, where too many are there for all of their orders.
double largest_share(const EffectShare& share) {
  return std::isfinite(share.shapley) ? share.shapley : std::max(share.alone, share.last);
}

/// Times a share of the gap as stated that it is of what tolerances leave of it, where that is a
/// plain gap; else 1. A rig whose encoders are off by what its builder allows may gape thirty
/// floors: a play that makes the two that are left one is not nothing.
double of_what_tolerances_leave(const HeldOut& gap, const Settings& settings) {
  const double base = std::min(gap.before, gap.adjusted);
  return base >= settings.plain_gap && base > 1.0 ? energy_left(base, gap.before) : 1.0;
}

}  // namespace

ModelFit without_idle_members(HeldOutGaps& gaps, ModelFit model) {
  // What is left out together must be idle together, so each smaller set is set beside the first:
  // with its tolerances where they are, as theirs stay.
  const ModelFit first = model;
  const HeldOut all = gaps.of(gaps.held(model, model.candidates)), stated = gaps.of(model);
  // Where datasets judge one another, a smaller set must predict them by tolerances of its own too:
  // with those of the larger one it has a part of what that one explains.
  const auto idle = [&](const ModelFit* less) {
    return !needed(all, gaps.of(*less), gaps.settings()) && !more_probable(gaps, first, *less) &&
           !(stated.over == "conditions" &&
             needed(stated, gaps.of(gaps.fitted(*less)), gaps.settings()));
  };
  while (model.candidates.size() > 1 && gaps.of(model).valid) {
    std::vector<const ModelFit*> smaller;
    for (const int dropped : model.candidates) {
      const ModelFit& less = without_member(gaps, model, dropped);
      if (less.fit.valid && gaps.of(less).valid) smaller.push_back(&less);
    }
    std::stable_sort(smaller.begin(), smaller.end(), [&](const ModelFit* a, const ModelFit* b) {
      return gaps.of(*a).after < gaps.of(*b).after;
    });
    const auto best = std::find_if(smaller.begin(), smaller.end(), idle);
    if (best == smaller.end()) break;
    model = **best;
  }
  return model;
}

ModelFit without_harmful_members(HeldOutGaps& gaps, ModelFit model) {
  if (gaps.of(model).over != "conditions") return model;
  while (model.candidates.size() > 1 && gaps.of(model).valid) {
    // Tolerances stay in the smaller sets, so they do in this one. What would be stated has
    // tolerances of its own: harm must show by these too.
    const HeldOut all = gaps.of(gaps.held(model, model.candidates));
    const HeldOut stated = gaps.of(gaps.fitted(model));
    std::optional<ModelFit> best;
    for (const int dropped : model.candidates) {
      const ModelFit& less = without_member(gaps, model, dropped);
      if (!less.fit.valid || !gaps.of(less).valid ||
          !harms_a_condition(all, gaps.of(less), gaps.settings()) ||
          !harms_a_condition(stated, gaps.of(gaps.fitted(less)), gaps.settings()))
        continue;
      if (!best || gaps.of(less).after < gaps.of(*best).after) best = less;
    }
    if (!best) break;
    model = std::move(*best);
  }
  return model;
}

ModelFit without_members_of_no_share(HeldOutGaps& gaps, ModelFit model) {
  const ModelFit first = model;
  while (model.candidates.size() > 1) {
    const auto shares = shares_of(gaps, model);
    const double times = of_what_tolerances_leave(gaps.of(model), gaps.settings());
    std::vector<std::pair<double, int>> small;  // shares and members, the least first
    for (int i = 0; i < count_of(shares); ++i) {
      if (!shares[i]) continue;
      const double share = times * largest_share(*shares[i]);
      if (share < gaps.settings().remainder_share) small.emplace_back(share, model.candidates[i]);
    }
    std::sort(small.begin(), small.end());

    const auto may_go = [&](const std::pair<double, int>& own) {
      const ModelFit& less = without_member(gaps, model, own.second);
      return less.fit.valid && !more_probable(gaps, first, less);
    };
    const auto least = std::find_if(small.begin(), small.end(), may_go);
    if (least == small.end()) break;
    model = without_member(gaps, model, least->second);
  }
  return model;
}

}  // namespace jaculus::diagnosis
