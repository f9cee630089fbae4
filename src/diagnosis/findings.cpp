#include "diagnosis/findings.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "diagnosis/calibration.h"
#include "diagnosis/held_out_rules.h"
#include "jaculus/effects/select.h"

namespace jaculus {
namespace {

constexpr double kSure = 0.8;        // probability from which an effect is stated
constexpr double kLikely = 0.5;      // of none or of something unknown, or of a rival that forbids a statement
constexpr double kListed = 0.05;     // share of the effects' probability from which a rival is listed
constexpr double kRanked = 1e-3;     // probability of sets worth a line
constexpr double kFormError = 0.02;  // deviation of a parameter by its effect's form, of its departure from nominal
constexpr double kNormal95 = 1.96;
constexpr std::size_t kHeldOut = 4;  // models whose held-out error is computed

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::vector<std::string> names_of(const DiagnosisProblem& problem, const std::vector<int>& candidates) {
  std::vector<std::string> names;
  for (const int c : candidates) names.push_back(problem.hypotheses.candidates[at(c)].name);
  return names;
}

std::string joined(const std::vector<std::string>& names) {
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, " + "));
}

/// Most probable model that frees a candidate.
const ModelFit* best_with(const Selection& selection, int candidate) {
  const ModelFit* best = nullptr;
  for (const ModelFit& m : selection.models) {
    const bool has = std::find(m.candidates.begin(), m.candidates.end(), candidate) != m.candidates.end();
    if (has && m.fit.valid && (best == nullptr || m.probability > best->probability)) best = &m;
  }
  return best;
}

FoundParameter shown(const Candidate& candidate, std::size_t k, double value, const Bounds& ci) {
  if (candidate.effect == nullptr) return {"parameter", "-", value, ci};
  const EffectParameter& p = candidate.effect->parameters[k];
  FoundParameter found{p.name, p.unit, value, ci};
  if (p.shown_as.empty()) return found;
  found.name = p.shown_name;
  found.unit = p.shown_unit;
  found.value = shown_value(p, value);
  const double a = shown_value(p, ci.lower), b = shown_value(p, ci.upper);
  found.ci95 = {std::min(a, b), std::max(a, b)};
  return found;
}

/// An interval by noise, widened by what an effect's form on hardware may differ from the plant's: a share of the parameter's departure
/// from nominal (testbed, seed 303: half of the estimates are within 1 %, four fifths within 3 %).
Bounds with_form_error(const FreeParameter& parameter, double value, const Bounds& ci) {
  const double form = kNormal95 * kFormError * std::abs(value - parameter.nominal);
  return {std::max(parameter.bounds.lower, value - std::hypot(value - ci.lower, form)),
          std::min(parameter.bounds.upper, value + std::hypot(ci.upper - value, form))};
}

FoundEffect found_effect(const DiagnosisProblem& problem, const EvidenceSpace& space, const Selection& selection,
                         int c) {
  const Candidate& candidate = problem.hypotheses.candidates[at(c)];
  FoundEffect found{
      candidate.name, candidate.effect != nullptr ? candidate.effect->caption : "", selection.involved[at(c)], {}, {}};
  for (const int other : selection.equivalent[at(c)])
    if (other != c) found.like.push_back(problem.hypotheses.candidates[at(other)].name);
  const ModelFit* model = best_with(selection, c);
  if (model == nullptr) return found;
  for (std::size_t k = 0; k < candidate.parameters.size(); ++k) {
    const int p = candidate.parameters[k];
    const double value = model->fit.p[p];
    const Bounds ci = interval95(problem, space, model->fit, p);
    found.parameters.push_back(
        shown(candidate, k, value, with_form_error(problem.hypotheses.parameters[at(p)], value, ci)));
  }
  return found;
}

/// Candidates to state, most probable first, and the verdict.
std::vector<int> decide(const Selection& selection, std::string& verdict) {
  std::vector<int> order;
  for (std::size_t c = 0; c < selection.involved.size(); ++c) order.push_back(static_cast<int>(c));
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return selection.involved[at(a)] > selection.involved[at(b)]; });
  if (selection.unexplained > kLikely) {
    verdict = "unexplained";
    return {};
  }
  if (selection.none > kLikely) {
    verdict = "none";
    return {};
  }
  const double mass = 1.0 - selection.none - selection.unexplained;
  std::vector<int> sure, listed;
  bool rival = false;
  for (const int c : order) {
    const double p = selection.involved[at(c)];
    if (p >= kSure) sure.push_back(c);
    if (p >= kListed * mass) listed.push_back(c);
    rival = rival || (p >= kLikely && p < kSure);
  }
  if (!sure.empty() && !rival) {
    verdict = sure.size() == 1 ? "effect" : "several";
    return sure;
  }
  verdict = listed.size() == 1 ? "effect" : "ambiguous";
  return listed;
}

/// Of an ambiguous verdict what is sure, where held-out data don't ask for what is not: the others may merely bend to its form.
bool keep_sure(const Selection& selection, HeldOutGaps& gaps, std::vector<int>& stated, std::string& verdict) {
  std::vector<int> sure = stated;
  std::erase_if(sure, [&](int c) { return selection.involved[at(c)] < kSure; });
  std::sort(sure.begin(), sure.end());
  const ModelFit* alone = sure.empty() ? nullptr : find_model(selection, sure);
  if (alone == nullptr || !gaps.of(*alone).valid || asks_for_more(gaps, selection, *alone)) return false;
  stated = sure;
  verdict = sure.size() == 1 ? "effect" : "several";
  return true;
}

/// Every model worth a row, `chosen` however improbable: what is stated stands in the ranking.
void rank(const DiagnosisProblem& problem, const Selection& selection, const ModelFit* chosen, HeldOutGaps& gaps,
          Diagnosis& out) {
  const double zero = find_model(selection, {})->fit.log_evidence;
  std::size_t judged = 0;
  for (const ModelFit& model : selection.models) {
    const bool improbable = model.candidates.size() > 1 && model.probability < kRanked && &model != chosen;
    if (!model.fit.valid || improbable) continue;
    const std::vector<std::string> members = names_of(problem, model.candidates);
    Ranked row{joined(members), model.fit.log_evidence - zero, kNaN, model.probability, members};
    if (judged < kHeldOut || model.candidates.empty() || &model == chosen) {
      row.held_out_error = gaps.of(model).after;
      ++judged;
    }
    out.ranking.push_back(row);
  }
  double log_unknown = -kInfinity;
  for (const ModelFit& model : selection.models)
    log_unknown = std::max(log_unknown, model.fit.log_evidence - zero + model.structure);
  out.ranking.push_back({"unexplained", log_unknown, kNaN, selection.unexplained, {}});
  std::stable_sort(out.ranking.begin(), out.ranking.end(),
                   [](const Ranked& a, const Ranked& b) { return a.probability > b.probability; });
}

/// The model whose after-gap is stated: of what the verdict names, else the most evident one.
const ModelFit* chosen_model(const Selection& selection, const std::vector<int>& stated, const std::string& verdict) {
  if (verdict == "none") return find_model(selection, {});
  if (verdict == "effect" || verdict == "several") {
    std::vector<int> sorted = stated;
    std::sort(sorted.begin(), sorted.end());
    if (const ModelFit* model = find_model(selection, sorted)) return model;
  }
  return most_evident(selection);
}

/// Of a set what `prune` keeps, which is then stated.
const ModelFit* state_pruned(const Selection& selection, HeldOutGaps& gaps, const ModelFit* chosen,
                             std::vector<int>& stated, Diagnosis& out) {
  const ModelFit* kept = prune(selection, gaps, chosen);
  if (kept != chosen) out.reasons.push_back("left out what held-out data are predicted as well without");
  std::erase_if(stated, [&](int c) {
    return std::find(kept->candidates.begin(), kept->candidates.end(), c) == kept->candidates.end();
  });
  if (stated.size() == 1) out.verdict = "effect";
  return kept;
}

}  // namespace

void state_findings(const DiagnosisProblem& problem, const Linearisation& about, const EvidenceSpace& space,
                    Selection selection, Diagnosis& out) {
  if (find_model(selection, {}) == nullptr) return;
  HeldOutGaps gaps(problem, about, find_model(selection, {})->fit);
  if (heed_held_out(gaps, selection))
    out.reasons.push_back(
        "held-out data ask for more effects than log evidence, which allows for the form of the first, would");
  std::vector<int> stated = decide(selection, out.verdict);
  if (out.verdict == "ambiguous" && keep_sure(selection, gaps, stated, out.verdict))
    out.reasons.push_back("more effects fit better, but which is not clear, and held-out data don't ask for them");
  const ModelFit* none = find_model(selection, {});
  const ModelFit* chosen = chosen_model(selection, stated, out.verdict);
  if (out.verdict == "several") chosen = state_pruned(selection, gaps, chosen, stated, out);
  rank(problem, selection, chosen, gaps, out);
  for (const int c : stated) out.effects.push_back(found_effect(problem, space, selection, c));
  out.p = chosen->fit.p;
  out.p_none = none->fit.p;
  out.chosen = chosen->candidates;
  out.gap = gaps.of(*chosen);
  demand_prediction(out);
  for (const ModelFit& model : selection.models)
    if (out.verdict == "ambiguous" && out.rivals.size() < 2 && !model.candidates.empty() && model.fit.valid)
      out.rivals.push_back({model.candidates, model.fit.p});
  if (out.verdict == "unexplained" && !chosen->candidates.empty()) {
    out.reasons.push_back("the nearest of the catalogue, which leaves structure beyond noise: " +
                          joined(names_of(problem, chosen->candidates)));
  }
  calibrate(out);
}

}  // namespace jaculus
