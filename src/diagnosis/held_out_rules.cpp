#include "diagnosis/held_out_rules.h"

#include <algorithm>
#include <cstddef>

namespace jaculus {
namespace {

/// Log density of held-out data that an effect must be worth: less is a fault of the model of noise or start, not an effect.
constexpr double kWorth = 3.0, kWorthOfLittle = 20.0;  // the second where the gap is small
constexpr double kGap = 1.5;  // noise floors; below it the share of a gap that shrank means nothing
// Share by which the held-out error must fall; the second where the gap is small.
constexpr double kLeast = 0.1, kLeastOfLittle = 0.05;
constexpr double kShrink = 0.75;  // share of the gap that effects must take where they leave more than kGap
constexpr double kMuch = 3.0;     // noise floors that effects may not leave whatever they take
constexpr double kFormGap = 1.2;  // noise floors that the form of an effect may leave
constexpr double kFurther =
    0.6;  // of what a model leaves, below which further effects must bring it to be believed in full

/// The most probable model with effects, with or without something unknown.
const ModelFit* leading(const Selection& selection) {
  for (const ModelFit& model : selection.models)
    if (model.fit.valid && !model.candidates.empty()) return &model;
  return nullptr;
}

}  // namespace

const HeldOut& HeldOutGaps::of(const ModelFit& model) {
  const auto known = gaps_.find(model.candidates);
  if (known != gaps_.end()) return known->second;
  return gaps_.emplace(model.candidates, held_out(problem_, about_, none_, model.fit)).first->second;
}

bool asks_for_more(HeldOutGaps& gaps, const Selection& selection, const ModelFit& model) {
  const ModelFit* evident = most_evident(selection);
  if (evident->candidates.size() <= model.candidates.size()) return false;
  const HeldOut &own = gaps.of(model), &more = gaps.of(*evident);
  return own.valid && more.valid && own.after > kFormGap && more.after < kFurther * own.after;
}

bool heed_held_out(HeldOutGaps& gaps, Selection& selection) {
  const ModelFit* lead = leading(selection);
  if (lead == nullptr || !asks_for_more(gaps, selection, *lead)) return false;
  weigh(selection, 0.0);
  return true;
}

const ModelFit* prune(const Selection& selection, HeldOutGaps& gaps, const ModelFit* model) {
  while (model->candidates.size() > 1 && gaps.of(*model).valid) {
    const ModelFit* best = nullptr;
    for (const int dropped : model->candidates) {
      std::vector<int> rest = model->candidates;
      std::erase(rest, dropped);
      const ModelFit* less = find_model(selection, rest);
      if (less == nullptr || !gaps.of(*less).valid) continue;
      if (best == nullptr || gaps.of(*less).log_gain > gaps.of(*best).log_gain) best = less;
    }
    if (best == nullptr || gaps.of(*model).log_gain - gaps.of(*best).log_gain > kWorth) break;
    model = best;
  }
  return model;
}

void demand_prediction(Diagnosis& out) {
  const bool named = out.verdict == "effect" || out.verdict == "several" || out.verdict == "ambiguous";
  const bool small = out.gap.before < kGap;
  if (!out.gap.valid || out.verdict == "none" || (!named && !small)) return;
  const double most = (1.0 - (small ? kLeastOfLittle : kLeast)) * out.gap.before;
  const bool predicts = out.gap.log_gain > (small ? kWorthOfLittle : kWorth) && out.gap.after < most;
  const bool leaves =
      named && out.gap.after > kGap && (out.gap.after > kMuch || out.gap.shrink.value_or(1.0) < kShrink);
  if (predicts && !leaves) return;
  if (predicts)
    out.reasons.push_back(
        "the fitted effects leave too much of the gap: more than 3 noise floors, or 1.5 and a quarter of it");
  else if (small)
    out.reasons.push_back(
        "the fit prefers a model with effects, but the nominal one is within 1.5 noise floors of held-out data, and "
        "the fit "
        "is not better by 20 in their log density and 5 % in error: no gap is claimed");
  else
    out.reasons.push_back("the fitted effects predict held-out data no better than the nominal model does");
  out.verdict = small ? "none" : "unexplained";
  out.effects.clear();
}

}  // namespace jaculus
