#include "diagnosis/verdict/found_effect.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/noise/quantiles.h"
#include "diagnosis/selection/neighbouring_sets.h"
#include "jaculus/effects/select.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kBoundRounding = 1e-9;  // of a prior scale

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

}  // namespace

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
    FoundParameter& last = found.parameters.back();
    last.at_bound = at_bound(parameter, model->fit.p[candidate.parameters[k]]);
    last.cut_by_range =
        !last.at_bound && (at_bound(parameter, ci.lower) || at_bound(parameter, ci.upper));
  }
  return found;
}

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
        const FoundParameter& rivals = there.parameters[k];
        const Bounds& more = rivals.ci95;
        const bool wider = more.lower < own.lower || more.upper > own.upper;
        effect.parameters[k].cut_by_range |= wider && (rivals.at_bound || rivals.cut_by_range);
        own = {std::min(own.lower, more.lower), std::max(own.upper, more.upper)};
      }
    }
  }
}

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

}  // namespace jaculus::diagnosis
