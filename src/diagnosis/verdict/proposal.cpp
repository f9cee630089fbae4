#include "diagnosis/verdict/proposal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "diagnosis/noise/quantiles.h"
#include "diagnosis/selection/neighbouring_sets.h"

namespace jaculus::diagnosis {
namespace {

bool contains(const std::vector<int>& sorted, int value) {
  return std::binary_search(sorted.begin(), sorted.end(), value);
}

/// Two fitted sets that differ in one member.
struct Exchange {
  const ModelFit* with;   ///< has the member
  const ModelFit* other;  ///< has another in its place
  int by;                 ///< that other
};

/// What was fitted in the place of a member: of this model, and of those that are nearly as
/// probable, for the same two may stand in for one another beside other effects as well.
std::vector<Exchange> exchanges_of(const Posterior& posterior, const ModelFit& model, int member,
                                   const Settings& settings) {
  std::vector<Exchange> found;
  for (const ModelFit& m : posterior.models) {
    const bool listed = m.probability() >= settings.listed * model.probability();
    if (!listed || !m.fit.valid || !contains(m.candidates, member)) continue;
    for (int c = 0; c < count_of(posterior.inclusion); ++c) {
      if (contains(m.candidates, c) || contains(model.candidates, c)) continue;
      const ModelFit* other = posterior.find(exchanged(m.candidates, member, c));
      if (other != nullptr && other->probability() >= settings.listed * m.probability())
        found.push_back({&m, other, c});
    }
  }
  return found;
}

/// The place of one member of a model: who may fill it, and how probable it is that one does.
Established place_of(const Posterior& posterior, const ModelFit& model, int member,
                     const Settings& settings) {
  Established place{member, {}, 0.0};
  for (const Exchange& exchange : exchanges_of(posterior, model, member, settings))
    if (index_of(place.others, exchange.by) < 0) place.others.push_back(exchange.by);
  std::stable_sort(place.others.begin(), place.others.end(),
                   [&](int a, int b) { return posterior.inclusion[a] > posterior.inclusion[b]; });

  std::vector<int> filling = place.others;
  filling.push_back(member);
  for (const ModelFit& m : posterior.models) {
    const auto fills = [&](int c) { return contains(m.candidates, c); };
    if (std::any_of(filling.begin(), filling.end(), fills)) place.probability += m.probability();
  }
  return place;
}

/// Those that may stand in for a member and predict held-out data as well as it does.
std::vector<int> predicting(HeldOutGaps& gaps, const ModelFit& model, const Established& place) {
  const Settings& settings = gaps.settings();
  const std::vector<Exchange> exchanges =
      exchanges_of(gaps.posterior(), model, place.effect, settings);
  std::vector<int> kept;
  for (const int other : place.others) {
    const auto as_well = [&](const Exchange& exchange) {
      if (exchange.by != other) return false;
      const HeldOut own = gaps.of(*exchange.with), gap = gaps.of(*exchange.other);
      return !own.valid || !gap.valid ||
             gap.after * (1.0 - settings.least_improvement) <= own.after;
    };
    if (std::any_of(exchanges.begin(), exchanges.end(), as_well)) kept.push_back(other);
  }
  return kept;
}

/// Whether the data tell none of the parameters that a candidate has beside its first.
bool tells_first_alone(const Hypotheses& hypotheses, const ModelFit& model, int candidate) {
  const Candidate& own = hypotheses.candidates[candidate];
  for (std::size_t k = 1; k < own.parameters.size(); ++k) {
    const FreeParameter& more = hypotheses.parameters[own.parameters[k]];
    const int place = index_of(model.fit.free, own.parameters[k]);
    const double deviation = more.scale * std::sqrt(model.fit.covariance(place, place));
    if (std::abs(model.fit.p[own.parameters[k]] - more.nominal) >
        quantiles::kTwoSided95 * deviation)
      return false;
  }
  return true;
}

/// Whether a stand-in is the member itself with parameters more, of which the data tell none: dry
/// friction that may differ by direction, and doesn't.
bool says_no_more(const HeldOutGaps& gaps, const ModelFit& model, int member, int other) {
  const Hypotheses& hypotheses = gaps.problem().hypotheses;
  if (!extends(hypotheses, other, member)) return false;
  const ModelFit* with = gaps.posterior().find(exchanged(model.candidates, member, other));
  return with != nullptr && tells_first_alone(hypotheses, *with, other);
}

/// The most probable model with the simpler effect in place of one of which the data tell no more,
/// where it is about as probable and held-out data are predicted as well; null where there is none.
const ModelFit* simpler_model(HeldOutGaps& gaps, const ModelFit& model) {
  const Settings& settings = gaps.settings();
  const Hypotheses& hypotheses = gaps.problem().hypotheses;
  const ModelFit* best = nullptr;
  for (const Members& members : plainer_sets(hypotheses, model.candidates)) {
    const ModelFit* other = gaps.posterior().find(members);
    if (other == nullptr || other->probability() < settings.listed * model.probability()) continue;
    if (best != nullptr && other->probability() <= best->probability()) continue;
    const int richer = *std::find_if(model.candidates.begin(), model.candidates.end(),
                                     [&](int c) { return !contains(members, c); });
    if (tells_first_alone(hypotheses, model, richer) &&
        no_worse(gaps.of(*other).after, gaps.of(model).after, settings))
      best = other;
  }
  return best;
}

/// The model with the simpler effect in place of each of which the data tell no more: evidence
/// hardly sets the two apart, for what nothing tells costs nothing, so that noise would choose the
/// name.
const ModelFit* with_simpler_members(HeldOutGaps& gaps, const ModelFit* model) {
  while (const ModelFit* simpler = simpler_model(gaps, *model)) model = simpler;
  return model;
}

/// Everything that reaches a share of what effects explain, most probable first, as one place.
Established any_listed(const Posterior& posterior, const Settings& settings) {
  const double by_effects = 1.0 - posterior.nothing_told() - posterior.unexplained;
  std::vector<int> order(posterior.inclusion.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return posterior.inclusion[a] > posterior.inclusion[b]; });
  Established place{order.front(), {}, by_effects};
  for (const int c : order)
    if (c != place.effect && posterior.inclusion[c] >= settings.listed * by_effects)
      place.others.push_back(c);
  return place;
}

std::vector<int> members_of(const std::vector<Established>& effects) {
  std::vector<int> members;
  for (const Established& e : effects) members.push_back(e.effect);
  std::sort(members.begin(), members.end());
  return members;
}

/// Share of the best set's probability from which held-out data may decide for another one.
/// Evidence counts what the trials of a dataset repeat, be it the robot or that day; where datasets
/// judge one another, it decides by a clear lead only.
double left_to_held_out(HeldOutGaps& gaps, const ModelFit& best) {
  const Settings& settings = gaps.settings();
  return gaps.of(best).over == "conditions" ? std::exp(-settings.clear_lead) : settings.listed;
}

/// What held-out data leave of a set's members, with tolerances of its own.
ModelFit kept_of(HeldOutGaps& gaps, const ModelFit& model) {
  const ModelFit harmless = without_harmful_members(gaps, model);
  const ModelFit kept = without_members_of_no_share(gaps, without_idle_members(gaps, harmless));
  return kept.candidates == model.candidates ? kept : gaps.fitted(kept);
}

/// The most probable set, or one that evidence hardly sets apart from it and that predicts held-out
/// data better by settings.least_improvement. Where datasets judge one another they alone decide
/// between these, by what would be stated of each: a set may predict well by a member that is
/// dropped later.
const ModelFit* best_predicting(HeldOutGaps& gaps) {
  const ModelFit* best = gaps.posterior().leading();
  const bool conditions = gaps.of(*best).over == "conditions";
  const double least = left_to_held_out(gaps, *best) * best->probability();
  const double better = conditions ? 1.0 : 1.0 - gaps.settings().least_improvement;
  const auto gap_of = [&](const ModelFit& model) {
    return gaps.of(conditions ? kept_of(gaps, model) : model);
  };
  HeldOut present = gap_of(*best);
  for (const ModelFit& model : gaps.posterior().models) {
    if (model.candidates.empty() || !model.fit.valid || model.probability() < least) continue;
    const HeldOut own = gap_of(model);
    if (!own.valid || !present.valid || own.folds < present.folds ||
        !(own.after < better * present.after))
      continue;
    best = &model;
    present = own;
  }
  return best;
}

Naming naming_of(const std::vector<Established>& effects) {
  if (effects.empty()) return Naming::nothing;
  const bool alone = effects.size() == 1;
  return alone && !effects.front().others.empty() ? Naming::rivals : Naming::sure;
}

Proposal name_effects(const Posterior& posterior, const ModelFit& leading,
                      const Settings& settings) {
  Proposal proposal;
  for (const int member : leading.candidates) {
    const Established place = place_of(posterior, leading, member, settings);
    if (place.probability >= settings.likely) proposal.effects.push_back(place);
  }
  std::stable_sort(
      proposal.effects.begin(), proposal.effects.end(),
      [](const Established& a, const Established& b) { return a.probability > b.probability; });

  if (proposal.effects.empty()) proposal.effects = {any_listed(posterior, settings)};
  return proposal;
}

}  // namespace

Proposal propose(HeldOutGaps& gaps) {
  const Posterior& posterior = gaps.posterior();
  const Settings& settings = gaps.settings();
  const ModelFit* leading = posterior.leading();
  if (posterior.nothing_told() > settings.likely || leading == nullptr)
    return {Naming::nothing, {}, *posterior.find({}), {}};
  if (posterior.unexplained > settings.likely) return {Naming::nothing, {}, *leading, {}};

  leading = with_simpler_members(gaps, best_predicting(gaps));
  Proposal proposal = name_effects(posterior, *leading, settings);
  const ModelFit harmless = without_harmful_members(gaps, *leading);
  const ModelFit kept = kept_of(gaps, *leading);
  for (const int c : leading->candidates) {
    if (contains(kept.candidates, c)) continue;
    const char* why = contains(harmless.candidates, c)
                          ? "held-out data are predicted as well without it, or it explains "
                            "nothing of their gap"
                          : "a dataset that no fit saw is predicted better without it";
    proposal.reasons.push_back(fmt::format("{} would raise the evidence, but {}",
                                           told_name(gaps.problem().hypotheses.candidates[c]),
                                           why));
  }

  std::erase_if(proposal.effects, [&](const Established& e) {
    return contains(leading->candidates, e.effect) && !contains(kept.candidates, e.effect);
  });
  for (Established& e : proposal.effects)
    if (contains(leading->candidates, e.effect)) {
      e.others = predicting(gaps, *leading, e);
      std::erase_if(e.others,
                    [&](int other) { return says_no_more(gaps, *leading, e.effect, other); });
    }
  const ModelFit* named = posterior.find(members_of(proposal.effects));
  const bool all = members_of(proposal.effects) == kept.candidates;
  proposal.chosen = all || named == nullptr ? kept : *named;
  proposal.naming = naming_of(proposal.effects);
  return proposal;
}

}  // namespace jaculus::diagnosis
