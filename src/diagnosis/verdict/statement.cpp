#include "diagnosis/verdict/statement.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/noise/quantiles.h"
#include "diagnosis/selection/neighbouring_sets.h"
#include "diagnosis/validation/shares.h"
#include "diagnosis/verdict/calibration.h"
#include "diagnosis/verdict/lacking_forces.h"
#include "diagnosis/verdict/rules.h"
#include "diagnosis/verdict/told_events.h"
#include "jaculus/effects/select.h"

namespace jaculus::diagnosis {
namespace {

constexpr int kRivals = 2;
constexpr double kBoundRounding = 1e-9;  // of a prior scale

std::vector<std::string> names_of(const Problem& problem, const std::vector<int>& candidates) {
  std::vector<std::string> names;
  for (const int c : candidates) names.push_back(problem.hypotheses.candidates[c].name);
  return names;
}

/// As users read them: forces that are no effects by what they do.
std::vector<std::string> told_names(const Problem& problem, const std::vector<int>& candidates) {
  std::vector<std::string> names;
  for (const int c : candidates) names.push_back(told_name(problem.hypotheses.candidates[c]));
  return names;
}

std::string joined(const std::vector<std::string>& names) {
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, " + "));
}

/// Most probable model that frees a candidate; null where none does.
const ModelFit* best_with(const Posterior& posterior, int candidate) {
  const ModelFit* best = nullptr;
  for (const ModelFit& m : posterior.models) {
    const bool has = std::binary_search(m.candidates.begin(), m.candidates.end(), candidate);
    if (has && m.fit.valid && (best == nullptr || m.probability() > best->probability())) best = &m;
  }
  return best;
}

/// A parameter in the terms in which users read it.
FoundParameter shown(const Candidate& candidate, int k, double value, const Bounds& ci) {
  if (candidate.effect == nullptr) return {"parameter", "-", value, ci};
  const effects::EffectParameter& p = candidate.effect->parameters[k];
  if (!p.reciprocal) return {p.name, p.unit, value, ci};
  const double a = shown_value(p, ci.lower), b = shown_value(p, ci.upper);
  return {p.shown_name(), p.shown_unit(), shown_value(p, value), {std::min(a, b), std::max(a, b)}};
}

/// An interval by noise, widened by what an effect's form on hardware may differ from the plant's:
/// a share of the parameter's departure from nominal.
Bounds with_form_error(const FreeParameter& parameter, double value, const Bounds& ci,
                       double share) {
  const double form = quantiles::kTwoSided95Rounded * share * std::abs(value - parameter.nominal);
  return {std::max(parameter.bounds.lower, value - std::hypot(value - ci.lower, form)),
          std::min(parameter.bounds.upper, value + std::hypot(ci.upper - value, form))};
}

/// Whether a fit stopped where a parameter's range ends, short of what the data ask for. Nominal
/// is no such end: there the effect does nothing.
bool at_bound(const FreeParameter& parameter, double value) {
  const double rounding = kBoundRounding * parameter.scale;
  if (std::abs(value - parameter.nominal) <= rounding) return false;
  return value <= parameter.bounds.lower + rounding || value >= parameter.bounds.upper - rounding;
}

/// An effect as `model` fitted it, or the most probable model that has it.
FoundEffect found_effect(const Problem& problem, const Whitening& whitening,
                         const Posterior& posterior, int c, const ModelFit* model,
                         const std::vector<int>& others) {
  const Candidate& candidate = problem.hypotheses.candidates[c];
  FoundEffect found;
  found.name = candidate.name;
  if (candidate.effect != nullptr) found.caption = candidate.effect->caption;
  found.probability = posterior.inclusion[c];
  std::vector<int> like = others;
  // What a single effect does about none says nothing of its place beside others.
  if (model->candidates.size() == 1) {
    const std::vector<int>& alone = posterior.indistinguishable[c];
    like.insert(like.end(), alone.begin(), alone.end());
  }
  for (const int other : like) {
    const std::string& name = problem.hypotheses.candidates[other].name;
    const bool effect = !problem.hypotheses.candidates[other].beyond_effects();
    if (other == c || !effect || extends(problem.hypotheses, other, c)) continue;
    if (index_of(found.indistinguishable, name) < 0) found.indistinguishable.push_back(name);
  }

  if (!std::binary_search(model->candidates.begin(), model->candidates.end(), c))
    model = best_with(posterior, c);
  if (model == nullptr) return found;

  const std::vector<Estimate> own = with_tolerances(problem, whitening, model->fit, c);
  for (int k = 0; k < count_of(own); ++k) {
    const FreeParameter& parameter = problem.hypotheses.parameters[candidate.parameters[k]];
    const Bounds ci =
        with_form_error(parameter, own[k].value, own[k].ci95, problem.settings.form_error);
    found.parameters.push_back(shown(candidate, k, own[k].value, ci));
    found.parameters.back().at_bound = at_bound(parameter, model->fit.p[candidate.parameters[k]]);
  }
  return found;
}

/// Widens the intervals of an effect by those it has where a rival stands in another member's
/// place: which of the two it is can't be told, so that either value may be right.
void widen_by_rivals(const Problem& problem, const Whitening& whitening, const Posterior& posterior,
                     const ModelFit& chosen, const std::vector<Established>& named, int c,
                     FoundEffect& effect) {
  if (index_of(chosen.candidates, c) < 0) return;
  for (const Established& other : named) {
    if (other.effect == c) continue;
    for (const int rival : other.others) {
      const ModelFit* model = posterior.find(exchanged(chosen.candidates, other.effect, rival));
      if (model == nullptr || !model->fit.valid) continue;
      const FoundEffect there = found_effect(problem, whitening, posterior, c, model, {});
      for (std::size_t k = 0; k < effect.parameters.size(); ++k) {
        Bounds& own = effect.parameters[k].ci95;
        const Bounds& more = there.parameters[k].ci95;
        own = {std::min(own.lower, more.lower), std::max(own.upper, more.upper)};
      }
    }
  }
}

/// Values of a model's effects, as users read them.
std::vector<FoundParameter> values_of(const Problem& problem, const ModelFit& model) {
  std::vector<FoundParameter> values;
  for (const int c : model.candidates) {
    const Candidate& candidate = problem.hypotheses.candidates[c];
    const Vector theta = theta_with_tolerances(problem, model.fit, c);
    for (int k = 0; k < theta.size(); ++k) {
      FoundParameter value = shown(candidate, k, theta[k], {kNaN, kNaN});
      value.name = candidate.name + "." + value.name;
      values.push_back(value);
    }
  }
  return values;
}

/// Tolerances by which a fit is a deviation off its files or more, and surely off them.
std::vector<Tolerated> tolerated_by(const Problem& problem, const Fit& fit) {
  std::vector<Tolerated> found;
  for (const int i : problem.hypotheses.tolerances) {
    const int place = index_of(fit.free, i);
    if (place < 0) continue;
    const FreeParameter& own = problem.hypotheses.parameters[i];
    const double half = quantiles::kTwoSided95 * std::sqrt(fit.covariance(place, place));
    if (std::abs(fit.p[i]) < std::max(1.0, half)) continue;
    found.push_back({own.name,
                     fit.p[i],
                     {std::max(own.bounds.lower, fit.p[i] - half),
                      std::min(own.bounds.upper, fit.p[i] + half)}});
  }
  std::stable_sort(found.begin(), found.end(), [](const Tolerated& a, const Tolerated& b) {
    return std::abs(a.value) > std::abs(b.value);
  });
  return found;
}

/// Of effects against none, complete or lacking.
double log_odds_of_effects(const Posterior& posterior) {
  const double none = posterior.nothing_told() + posterior.unexplained;
  return std::log1p(-std::min(none, 1.0)) -
         std::log(std::max(none, std::numeric_limits<double>::min()));
}

/// Probability that a model lacks forces, given that its effects are at work.
double lacking_probability(const ModelFit& model, const Settings& settings) {
  const double odds = settings.prior_lacking / (1.0 - settings.prior_lacking);
  const double log_factor = model.fit.log_evidence - model.fit.log_complete;
  return 1.0 / (1.0 + std::exp(-log_factor) / odds);
}

/// A model's row, without held-out error.
Ranked row_of(const Problem& problem, const ModelFit& model, double zero) {
  const std::vector<std::string> members = names_of(problem, model.candidates);
  const bool none = members.empty();
  const double evidence =
      none ? model.fit.log_complete : std::max(model.fit.log_evidence, model.fit.log_complete);
  Ranked row{joined(members), evidence - zero, kNaN, none ? model.complete : model.probability(),
             members};
  row.parameters = values_of(problem, model);
  return row;
}

/// Effects that were not worth a fit, by what screening says of them.
void add_untold(const HeldOutGaps& gaps, double zero, std::vector<Ranked>& ranking) {
  const Posterior& posterior = gaps.posterior();
  const double none = posterior.find({})->fit.log_complete;
  for (int c = 0; c < count_of(posterior.untold); ++c) {
    if (posterior.untold[c] == 0.0) continue;
    const std::string& name = gaps.problem().hypotheses.candidates[c].name;
    ranking.push_back({name, none + posterior.scores[c] - zero, kNaN, posterior.untold[c], {name}});
  }
}

/// Every model worth a row, `chosen` however improbable: what is reported stands in the ranking. A
/// set that held-out data made of a larger one has that one's probability.
std::vector<Ranked> ranking_of(HeldOutGaps& gaps, const ModelFit& chosen) {
  const Problem& problem = gaps.problem();
  const Posterior& posterior = gaps.posterior();
  const Settings& settings = gaps.settings();
  const double zero = posterior.find({})->fit.log_evidence;
  std::vector<Ranked> ranking;
  int judged = 0;
  for (const ModelFit& model : posterior.models) {
    const bool is_chosen = model.candidates == chosen.candidates;
    const bool improbable = model.candidates.size() > 1 && model.probability() < settings.ranked;
    if (!model.fit.valid || (improbable && !is_chosen)) continue;

    ranking.push_back(row_of(problem, model, zero));
    if (judged < settings.ranked_held_out || model.candidates.empty() || is_chosen) {
      ranking.back().held_out_error = gaps.of(model).after;
      ++judged;
    }
  }
  if (posterior.find(chosen.candidates) == nullptr) {
    ranking.push_back(row_of(problem, chosen, zero));
    ranking.back().held_out_error = gaps.of(chosen).after;
    ranking.back().probability = posterior.leading()->probability();
  }

  add_untold(gaps, zero, ranking);
  ranking.push_back({to_text(Verdict::unexplained), 0.0, kNaN, posterior.unexplained, {}});
  std::stable_sort(ranking.begin(), ranking.end(),
                   [](const Ranked& a, const Ranked& b) { return a.probability > b.probability; });
  return ranking;
}

std::vector<FittedModel> rivals_of(const Posterior& posterior) {
  std::vector<FittedModel> rivals;
  for (const ModelFit& model : posterior.models)
    if (count_of(rivals) < kRivals && !model.candidates.empty() && model.fit.valid)
      rivals.push_back({model.candidates, model.fit.p});
  return rivals;
}

/// Gives the effects their shares of the held-out gap's energy: members of the chosen model within
/// it, rivals alone.
void add_shares(HeldOutGaps& gaps, const ModelFit& chosen, std::vector<FoundEffect>& effects) {
  const auto members = shares_of(gaps, chosen);
  for (FoundEffect& effect : effects) {
    const int c = gaps.problem().hypotheses.candidate(effect.name);
    const int place = index_of(chosen.candidates, c);
    if (place >= 0) {
      effect.share = members[place];
    } else if (const ModelFit* rival = gaps.posterior().find({c})) {
      effect.share = shares_of(gaps, *rival).front();
      if (effect.share) {
        const EffectShare own = *effect.share;
        effect.share = EffectShare{.alone = own.alone, .tolerances = own.tolerances};
      }
    }
  }
}

/// What a model's effects make of it without its patterns; none where it has no effects.
const ModelFit& by_effects(HeldOutGaps& gaps, const ModelFit& chosen) {
  std::vector<int> effects = chosen.candidates;
  std::erase_if(effects,
                [&](int c) { return gaps.problem().hypotheses.candidates[c].is_pattern(); });
  return effects.empty() ? *gaps.posterior().find({}) : gaps.subset(chosen, effects);
}

double most_probable(const std::vector<Established>& places) {
  double most = 0.0;
  for (const Established& place : places) most = std::max(most, place.probability);
  return most;
}

/// Why the verdict is what it is.
std::vector<std::string> rule_reasons(const Problem& problem, const VerdictRule& rule,
                                      Verdict verdict, const PartedProposal& told,
                                      const ModelFit& chosen) {
  std::vector<std::string> reasons;
  const bool events = names_effects(rule.verdict) && !told.events.empty();
  const bool patterns = names_effects(rule.verdict) && !told.patterns.empty();
  for (const Established& e : told.patterns)
    if (patterns)
      reasons.push_back(
          fmt::format("a {} is clearly more probable than effects of the catalogue in "
                      "its place",
                      problem.hypotheses.candidates[e.effect].effect->caption));
  if (events && verdict == Verdict::unexplained && !patterns)
    reasons.emplace_back("forces remain that neither what acted once nor an effect explains");
  else
    reasons.emplace_back(rule.reason);
  if (verdict == Verdict::unexplained && !events && !patterns && !chosen.candidates.empty())
    reasons.push_back("the nearest that was found, which leaves structure beyond noise: " +
                      joined(told_names(problem, chosen.candidates)));
  for (const Established& e : told.events)
    if (events && !e.others.empty())
      reasons.push_back(fmt::format("{} can't be told from {}",
                                    problem.hypotheses.candidates[e.effect].name,
                                    joined(told_names(problem, e.others))));
  return reasons;
}

void append(const std::vector<std::string>& more, std::vector<std::string>& reasons) {
  for (const std::string& reason : more)
    if (!reason.empty()) reasons.push_back(reason);
}

}  // namespace

Statement state_verdict(const Problem& problem, const Selection& selection, bool one_trial) {
  const Settings& settings = problem.settings;
  const Fit& none = selection.search.models.front().fit;
  const Posterior posterior = posterior_of(selection.search, settings);
  const Fit stated = as_stated(problem, selection.comparison.whitening);
  HeldOutGaps gaps(problem, selection.comparison, posterior, stated, none);
  const Proposal proposal = propose(gaps);
  const ModelFit& chosen = proposal.chosen;
  const PartedProposal told = parted(problem, proposal);

  Statement out;
  out.gap = gaps.of(chosen);
  const double lacking = lacking_probability(chosen, settings);
  out.lacking_probability = lacking;
  out.lacking = lacking_forces(problem, selection.comparison.whitening, chosen.fit);
  const VerdictRule& rule = decide({one_trial, posterior.nothing_told(), posterior.unexplained,
                                    told.naming, count_of(proposal.effects), lacking, out.gap,
                                    in_windows(problem) ? 0.0 : log_odds_of_effects(posterior)},
                                   settings);
  out.verdict = about_effects(rule.verdict, told);
  out.rule = rule.name;
  const bool patterns = names_effects(rule.verdict) && !told.patterns.empty();
  out.gap_with = out.gap;
  if (patterns) {
    out.gap = gaps.of(by_effects(gaps, chosen));
    out.lacking_probability = std::max(lacking, most_probable(told.patterns));
  }
  out.stated = {{}, stated.p};
  const bool once = names_effects(rule.verdict) && told.effects.empty();
  out.none = once ? FittedModel{chosen.candidates, chosen.fit.p} : FittedModel{{}, none.p};
  out.model = {chosen.candidates, chosen.fit.p};
  for (const int c : chosen.candidates)
    out.theta.push_back(theta_with_tolerances(problem, chosen.fit, c));
  out.tolerated = tolerated_by(problem, chosen.fit);

  append(proposal.reasons, out.reasons);
  append(rule_reasons(problem, rule, out.verdict, told, chosen), out.reasons);

  const Whitening& whitening = selection.comparison.whitening;
  const auto found = [&](int c, const std::vector<int>& others) {
    FoundEffect effect = found_effect(problem, whitening, posterior, c, &chosen, others);
    widen_by_rivals(problem, whitening, posterior, chosen, told.effects, c, effect);
    return effect;
  };
  std::vector<FoundEffect> effects;
  if (names_effects(rule.verdict))
    for (const Established& e : told.events)
      out.events.push_back(event_of(problem, e.effect, found(e.effect, {})));
  if (patterns) {
    for (const Established& e : told.patterns) out.patterns.push_back(found(e.effect, {}));
    add_shares(gaps, chosen, out.patterns);
  }
  if (names_effects(out.verdict)) {
    for (const Established& e : told.effects) effects.push_back(found(e.effect, e.others));
    // Rivals have a row each.
    if (out.verdict == Verdict::ambiguous)
      for (const int other : told.effects.front().others) effects.push_back(found(other, {}));
    add_shares(gaps, chosen, effects);
  }
  if (out.verdict == Verdict::ambiguous) out.rivals = rivals_of(posterior);
  std::vector<Ranked> ranking = ranking_of(gaps, chosen);
  if (problem.hypotheses.beyond_effects()) ranking = ranked_by_effects(problem, ranking);
  std::vector<Ranked> others = ranking;
  std::erase_if(others, [&](const Ranked& row) {
    if (told.effects.empty() || row.members.size() != 1) return false;
    const int c = problem.hypotheses.candidate(row.members.front());
    return c >= 0 && extends(problem.hypotheses, c, told.effects.front().effect);
  });
  append(doubts(out.verdict, out.gap, effects, others, settings), out.reasons);
  Calibrated calibrated =
      calibrate(out.verdict, !out.events.empty(), std::move(effects), std::move(ranking));
  out.effects = std::move(calibrated.effects);
  out.ranking = std::move(calibrated.ranking);
  out.posterior = posterior;
  return out;
}

}  // namespace jaculus::diagnosis
