#include "diagnosis/selection/posterior.h"

#include <algorithm>
#include <cmath>

namespace jaculus::diagnosis {
namespace {

double explained(const ModelFit& model, double none) {
  return std::max(0.0, model.fit.log_evidence - none);
}

const ModelFit* find_in(const std::vector<ModelFit>& models, const std::vector<int>& candidates) {
  for (const ModelFit& model : models)
    if (model.candidates == candidates && model.fit.valid) return &model;
  return nullptr;
}

}  // namespace

const ModelFit* Posterior::find(const std::vector<int>& candidates) const {
  return find_in(models, candidates);
}

const ModelFit* Posterior::most_evident() const {
  const ModelFit* best = nullptr;
  const auto value = [](const ModelFit& m) { return m.log_prior + m.fit.log_evidence; };
  for (const ModelFit& model : models)
    if (model.fit.valid && (best == nullptr || value(model) > value(*best))) best = &model;
  return best;
}

const ModelFit* Posterior::leading() const {
  for (const ModelFit& model : models)
    if (model.fit.valid && !model.candidates.empty()) return &model;
  return nullptr;
}

double log_prior(std::size_t members, std::size_t candidates, const Settings& settings) {
  const auto n = static_cast<double>(candidates);
  if (members == 0) return std::log(settings.prior_none);
  if (members == 1) return std::log(settings.prior_single / n);
  if (members == 2) return std::log(settings.prior_pair / std::max(1.0, n * (n - 1.0) / 2.0));
  return std::log(settings.prior_triple / std::max(1.0, n * (n - 1.0) * (n - 2.0) / 6.0));
}

double log_weight(const ModelFit& model, double none, double form_member) {
  if (!model.fit.valid) return -kInfinity;
  const double further =
      model.candidates.empty() ? 0.0 : static_cast<double>(model.candidates.size() - 1);
  return model.log_prior + model.fit.log_evidence - form_member * further * explained(model, none);
}

Posterior posterior_of(const SearchResult& search, const Settings& settings) {
  Posterior out;
  out.models = search.models;
  out.indistinguishable = search.indistinguishable;
  out.inclusion.assign(search.probes.size(), 0.0);

  const ModelFit* without = find_in(out.models, {});
  const double none = without == nullptr ? 0.0 : without->fit.log_evidence;
  const auto known = [&](const ModelFit& m) { return log_weight(m, none, settings.form_member); };
  const auto unknown = [&](const ModelFit& m) {
    return known(m) + std::log(settings.prior_unknown) + m.structure -
           settings.form_left * explained(m, none);
  };

  double largest = -kInfinity, sum = 0.0;
  for (const ModelFit& m : out.models) largest = std::max({largest, known(m), unknown(m)});
  for (ModelFit& m : out.models) {
    m.probability = std::exp(known(m) - largest);
    m.unknown_probability = std::exp(unknown(m) - largest);
    sum += m.probability + m.unknown_probability;
  }

  for (ModelFit& m : out.models) {
    m.probability /= sum;
    m.unknown_probability /= sum;
    out.unexplained += m.unknown_probability;
    if (m.candidates.empty()) out.none += m.probability;
    for (const int c : m.candidates) out.inclusion[c] += m.probability;
  }
  std::stable_sort(out.models.begin(), out.models.end(), [](const ModelFit& a, const ModelFit& b) {
    return std::max(a.probability, a.unknown_probability) >
           std::max(b.probability, b.unknown_probability);
  });
  return out;
}

}  // namespace jaculus::diagnosis
