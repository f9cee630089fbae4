#include "diagnosis/verdict/statement.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/noise/quantiles.h"
#include "diagnosis/verdict/calibration.h"
#include "diagnosis/verdict/rules.h"
#include "jaculus/effects/select.h"

namespace jaculus::diagnosis {
namespace {

constexpr int kRivals = 2;

std::vector<std::string> names_of(const Problem& problem, const std::vector<int>& candidates) {
  std::vector<std::string> names;
  for (const int c : candidates) names.push_back(problem.hypotheses.candidates[c].name);
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
    if (has && m.fit.valid && (best == nullptr || m.probability > best->probability)) best = &m;
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

FoundEffect found_effect(const Problem& problem, const Whitening& whitening,
                         const Posterior& posterior, int c) {
  const Candidate& candidate = problem.hypotheses.candidates[c];
  FoundEffect found;
  found.name = candidate.name;
  if (candidate.effect != nullptr) found.caption = candidate.effect->caption;
  found.probability = posterior.inclusion[c];
  for (const int other : posterior.indistinguishable[c])
    if (other != c) found.indistinguishable.push_back(problem.hypotheses.candidates[other].name);

  const ModelFit* model = best_with(posterior, c);
  if (model == nullptr) return found;
  for (int k = 0; k < count_of(candidate.parameters); ++k) {
    const int i = candidate.parameters[k];
    const FreeParameter& parameter = problem.hypotheses.parameters[i];
    const double value = model->fit.p[i];
    const Bounds noise = interval95(problem, whitening, model->fit, i);
    const Bounds ci = with_form_error(parameter, value, noise, problem.settings.form_error);
    found.parameters.push_back(shown(candidate, k, value, ci));
  }
  return found;
}

/// Every model worth a row, `chosen` however improbable: what is reported stands in the ranking.
std::vector<Ranked> ranking_of(const Problem& problem, const Posterior& posterior,
                               const ModelFit* chosen, HeldOutGaps& gaps) {
  const Settings& settings = problem.settings;
  const double zero = posterior.find({})->fit.log_evidence;
  std::vector<Ranked> ranking;
  int judged = 0;
  double log_unknown = -kInfinity;
  for (const ModelFit& model : posterior.models) {
    const double log_evidence = model.fit.log_evidence - zero;
    log_unknown = std::max(log_unknown, log_evidence + model.structure);
    const bool improbable = model.candidates.size() > 1 && model.probability < settings.ranked;
    if (!model.fit.valid || (improbable && &model != chosen)) continue;

    const std::vector<std::string> members = names_of(problem, model.candidates);
    Ranked row{joined(members), log_evidence, kNaN, model.probability, members};
    if (judged < settings.ranked_held_out || members.empty() || &model == chosen) {
      row.held_out_error = gaps.of(model).after;
      ++judged;
    }
    ranking.push_back(row);
  }

  ranking.push_back({to_text(Verdict::unexplained), log_unknown, kNaN, posterior.unexplained, {}});
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

void append(const std::vector<std::string>& more, std::vector<std::string>& reasons) {
  for (const std::string& reason : more)
    if (!reason.empty()) reasons.push_back(reason);
}

}  // namespace

Statement state_verdict(const Problem& problem, const Selection& selection, bool one_trial) {
  const Settings& settings = problem.settings;
  const Fit& none = selection.search.models.front().fit;
  HeldOutGaps gaps(problem, selection.comparison, none);
  const AcceptedPosterior accepted = accepted_posterior(selection.search, gaps, settings);
  const Posterior& posterior = accepted.posterior;
  const Proposal proposal = propose(posterior, gaps, settings);
  const ModelFit& chosen = *proposal.chosen;

  Statement out;
  out.gap = gaps.of(chosen);
  const VerdictRule& rule = decide({one_trial, posterior.none, posterior.unexplained,
                                    proposal.naming, count_of(proposal.effects), out.gap},
                                   settings);
  out.verdict = rule.verdict;
  out.rule = rule.name;
  out.none = {{}, none.p};
  out.model = {chosen.candidates, chosen.fit.p};

  if (accepted.without_form)
    append(
        {"held-out data ask for more effects than log evidence, which allows for the form of the "
         "first, would"},
        out.reasons);
  append(proposal.reasons, out.reasons);
  append({rule.reason}, out.reasons);
  if (out.verdict == Verdict::unexplained && !chosen.candidates.empty())
    append({"the nearest of the catalogue, which leaves structure beyond noise: " +
            joined(names_of(problem, chosen.candidates))},
           out.reasons);

  std::vector<FoundEffect> effects;
  if (names_effects(out.verdict))
    for (const int c : proposal.effects)
      effects.push_back(found_effect(problem, selection.comparison.whitening, posterior, c));
  if (out.verdict == Verdict::ambiguous) out.rivals = rivals_of(posterior);
  std::vector<Ranked> ranking = ranking_of(problem, posterior, proposal.chosen, gaps);
  const std::vector<std::string> doubted = doubts(out.verdict, out.gap, effects, ranking, settings);
  append(doubted, out.reasons);
  Calibrated calibrated =
      calibrate(out.verdict, !doubted.empty(), std::move(effects), std::move(ranking));
  out.effects = std::move(calibrated.effects);
  out.ranking = std::move(calibrated.ranking);
  out.posterior = accepted.posterior;
  return out;
}

}  // namespace jaculus::diagnosis
