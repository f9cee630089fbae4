#include "diagnosis/verdict/statement.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/selection/neighbouring_sets.h"
#include "diagnosis/validation/shares.h"
#include "diagnosis/verdict/calibration.h"
#include "diagnosis/verdict/found_effect.h"
#include "diagnosis/verdict/lacking_forces.h"
#include "diagnosis/verdict/rules.h"
#include "diagnosis/verdict/told_events.h"
#include "jaculus/effects/select.h"

namespace jaculus::diagnosis {
namespace {

constexpr int kRivals = 2;

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

/// Of effects against none, complete or lacking.
double log_odds_of_effects(const Posterior& posterior) {
  const double none = posterior.nothing_told() + posterior.unexplained;
  return std::log1p(-std::min(none, 1.0)) -
         std::log(std::max(none, std::numeric_limits<double>::min()));
}

/// Probability that a model lacks forces, given that its effects are at work.
double lacking_probability(const ModelFit& model, const Settings& settings) {
  const double odds = settings.prior_lacking / (1.0 - settings.prior_lacking);
  const double log_factor = model.log_evidence() - model.log_complete();
  return 1.0 / (1.0 + std::exp(-log_factor) / odds);
}

/// A model's row, without held-out error.
Ranked row_of(const Problem& problem, const ModelFit& model, double zero) {
  const std::vector<std::string> members = names_of(problem, model.candidates);
  const bool none = members.empty();
  const double evidence =
      none ? model.log_complete() : std::max(model.log_evidence(), model.log_complete());
  Ranked row{joined(members), evidence - zero, kNaN, none ? model.complete : model.probability(),
             members};
  row.parameters = values_of(problem, model);
  return row;
}

/// Effects that were not worth a fit, by what screening says of them.
void add_untold(const HeldOutGaps& gaps, double zero, std::vector<Ranked>& ranking) {
  const Posterior& posterior = gaps.posterior();
  const double none = posterior.find({})->log_complete();
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
  const double zero = posterior.find({})->log_evidence();
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

/// What a model leaves of trials that no fit saw without its members of a kind.
HeldOut gap_without(HeldOutGaps& gaps, const ModelFit& chosen, bool (Candidate::*kind)() const) {
  std::vector<int> members = chosen.candidates;
  std::erase_if(members, [&](int c) { return (gaps.problem().hypotheses.candidates[c].*kind)(); });
  if (members.size() == chosen.candidates.size()) return gaps.of(chosen);
  return gaps.of(members.empty() ? *gaps.posterior().find({}) : gaps.subset(chosen, members));
}

double most_probable(const std::vector<Established>& places) {
  double most = 0.0;
  for (const Established& place : places) most = std::max(most, place.probability);
  return most;
}

/// Why the verdict is what it is.
std::vector<std::string> rule_reasons(const Problem& problem, const VerdictRule& rule,
                                      Verdict verdict, const PartedProposal& told,
                                      const ModelFit& chosen, const HeldOut& gap) {
  std::vector<std::string> reasons;
  if (!names_effects(rule.verdict) || !told.beyond_effects()) {
    reasons.emplace_back(rule.reason);
    if (verdict == Verdict::unexplained && !chosen.candidates.empty())
      reasons.push_back(
          nearest_text(joined(told_names(problem, chosen.candidates)), gap, problem.settings));
    return reasons;
  }

  const auto more_probable = [&](const std::string& force) {
    reasons.push_back(fmt::format(
        "a {} is clearly more probable than effects of the catalogue in its place", force));
  };
  for (const Established& e : told.patterns)
    more_probable(problem.hypotheses.candidates[e.effect].effect->caption);
  for (const Established& e : told.events) {
    const std::string& name = problem.hypotheses.candidates[e.effect].name;
    more_probable(name + " in every trial");
    if (!e.others.empty())
      reasons.push_back(
          fmt::format("{} can't be told from {}", name, joined(told_names(problem, e.others))));
  }
  if (told.effects.empty() && rule.verdict == Verdict::partial)
    reasons.emplace_back("forces remain that neither these nor an effect explains");
  else
    reasons.emplace_back(rule.reason);
  return reasons;
}

void append(const std::vector<std::string>& more, std::vector<std::string>& reasons) {
  for (const std::string& reason : more)
    if (!reason.empty()) reasons.push_back(reason);
}

/// What a statement is made of.
struct Judged {
  const Problem& problem;
  const Whitening& whitening;
  const Posterior& posterior;
  HeldOutGaps& gaps;
  const Proposal& proposal;
  const PartedProposal& told;

  [[nodiscard]] const ModelFit& chosen() const { return proposal.chosen; }
  /// An effect of the chosen model, or one that may stand in for another.
  [[nodiscard]] FoundEffect found(int c, const std::vector<int>& others) const {
    FoundEffect effect = found_effect(problem, whitening, posterior, c, &chosen(), others);
    widen_by_rivals(problem, whitening, posterior, chosen(), told.effects, c, effect);
    return effect;
  }
};

/// Pushes or patterns, with what each explains.
std::vector<FoundEffect> found_forces(const Judged& judged, const std::vector<Established>& told) {
  std::vector<FoundEffect> forces;
  for (const Established& e : told) forces.push_back(judged.found(e.effect, {}));
  add_shares(judged.gaps, judged.chosen(), forces);
  return forces;
}

std::vector<ToldPush> found_pushes(const Judged& judged) {
  std::vector<ToldPush> pushes;
  for (FoundEffect& found : found_forces(judged, judged.told.events)) {
    const ForceEvent event = event_of(judged.problem, found);
    pushes.push_back({std::move(found), event});
  }
  return pushes;
}

/// Rivals have a row each.
std::vector<FoundEffect> found_effects(const Judged& judged, Verdict verdict) {
  std::vector<FoundEffect> effects;
  for (const Established& e : judged.told.effects)
    effects.push_back(judged.found(e.effect, e.others));
  if (verdict == Verdict::ambiguous)
    for (const int other : judged.told.effects.front().others)
      effects.push_back(judged.found(other, {}));
  add_shares(judged.gaps, judged.chosen(), effects);
  return effects;
}

std::vector<Ranked> ranking_of_effects(const Judged& judged) {
  std::vector<Ranked> ranking = ranking_of(judged.gaps, judged.chosen());
  return judged.problem.hypotheses.beyond_effects() ? ranked_by_effects(judged.problem, ranking)
                                                    : ranking;
}

/// What speaks against an effect, but for what is itself with parameters more.
std::vector<std::string> doubts_of(const Judged& judged, const Statement& statement,
                                   const std::vector<FoundEffect>& effects,
                                   std::vector<Ranked> ranking) {
  const Hypotheses& hypotheses = judged.problem.hypotheses;
  std::erase_if(ranking, [&](const Ranked& row) {
    if (judged.told.effects.empty() || row.members.size() != 1) return false;
    const int c = hypotheses.candidate(row.members.front());
    return c >= 0 && extends(hypotheses, c, judged.told.effects.front().effect);
  });
  return doubts(statement.verdict, statement.gap, effects, ranking, judged.problem.settings);
}

/// The models that a statement is about.
void add_models(const Judged& judged, const VerdictRule& rule, const Fit& stated, const Fit& none,
                Statement& out) {
  const ModelFit& chosen = judged.chosen();
  out.stated = {{}, stated.p};
  const bool once = names_effects(rule.verdict) && judged.told.effects.empty();
  out.none = once ? FittedModel{chosen.candidates, chosen.fit.p} : FittedModel{{}, none.p};
  out.model = {chosen.candidates, chosen.fit.p};
  for (const int c : chosen.candidates)
    out.theta.push_back(theta_with_tolerances(judged.problem, chosen.fit, c));
  out.tolerated = tolerated_by(judged.problem, chosen.fit);
}

}  // namespace

Statement state_verdict(const Problem& problem, const Selection& selection, bool one_trial) {
  const Settings& settings = problem.settings;
  const Whitening& whitening = selection.comparison.whitening;
  const Fit& none = selection.search.models.front().fit;
  const Posterior posterior = posterior_of(selection.search, settings);
  const Fit stated = as_stated(problem, whitening);
  HeldOutGaps gaps(problem, selection.comparison, posterior, stated, none);
  const Proposal proposal = propose(gaps);
  const ModelFit& chosen = proposal.chosen;
  const PartedProposal told = parted(problem, proposal);
  const Judged judged{problem, whitening, posterior, gaps, proposal, told};

  Statement out;
  out.posterior = posterior;
  out.gap = out.gap_by_effects = out.gap_with = gaps.of(chosen);
  out.lacking_probability = lacking_probability(chosen, settings);
  out.lacking = lacking_forces(problem, whitening, chosen.fit);
  const VerdictRule& rule =
      decide({one_trial, posterior.nothing_told(), posterior.unexplained, told.naming,
              count_of(proposal.effects), out.lacking_probability, out.gap,
              in_windows(problem) ? 0.0 : log_odds_of_effects(posterior)},
             settings);
  out.verdict = about_effects(rule.verdict, told);
  out.rule = rule.name;
  add_models(judged, rule, stated, none, out);

  if (names_effects(rule.verdict) && told.beyond_effects()) {
    out.gap = gap_without(gaps, chosen, &Candidate::is_pattern);
    out.gap_by_effects = gap_without(gaps, chosen, &Candidate::beyond_effects);
    out.lacking_probability = std::max(
        {out.lacking_probability, most_probable(told.patterns), most_probable(told.events)});
    out.patterns = found_forces(judged, told.patterns);
    out.pushes = found_pushes(judged);
  }
  std::vector<FoundEffect> effects;
  if (names_effects(out.verdict)) effects = found_effects(judged, out.verdict);
  if (out.verdict == Verdict::ambiguous) out.rivals = rivals_of(posterior);

  std::vector<Ranked> ranking = ranking_of_effects(judged);
  append(proposal.reasons, out.reasons);
  append(rule_reasons(problem, rule, out.verdict, told, chosen, out.gap), out.reasons);
  const std::vector<std::string> against = doubts_of(judged, out, effects, ranking);
  append(against, out.reasons);
  Calibrated calibrated =
      calibrate(out.verdict, {.event = !out.pushes.empty(), .doubted = !against.empty()},
                std::move(effects), std::move(ranking));
  out.effects = std::move(calibrated.effects);
  out.ranking = std::move(calibrated.ranking);
  return out;
}

}  // namespace jaculus::diagnosis
