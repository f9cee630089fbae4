#include "diagnosis/selection/posterior.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "diagnosis/noise/log_probability.h"

namespace jaculus::diagnosis {
double ModelFit::log_weight() const {
  if (!fit.valid) return -kInfinity;
  return log_prior + std::max(log_evidence(), log_complete());
}

double ModelFit::log_weight_there() const {
  return fit.valid ? log_prior + std::max(fit.log_evidence, fit.log_complete) : -kInfinity;
}

SpaceWeight weight_of(const ModelFit& model, const Fit& fit, const Settings& settings) {
  SpaceWeight weight;
  if (!fit.valid) return weight;
  weight.complete = model.log_prior + std::log1p(-settings.prior_lacking) + fit.log_complete;
  if (fit.scales.size() > 0)
    weight.lacking = model.log_prior + std::log(settings.prior_lacking) + fit.log_evidence;
  return weight;
}

std::vector<const ModelFit*> most_probable_first(const std::vector<ModelFit>& models) {
  std::vector<const ModelFit*> sorted;
  for (const ModelFit& model : models) sorted.push_back(&model);
  std::stable_sort(sorted.begin(), sorted.end(), [](const ModelFit* a, const ModelFit* b) {
    return a->log_weight() > b->log_weight();
  });
  return sorted;
}

const ModelFit* Posterior::find(const std::vector<int>& candidates) const {
  for (const ModelFit& model : models)
    if (model.candidates == candidates && model.fit.valid) return &model;
  return nullptr;
}

const ModelFit* Posterior::leading() const {
  for (const ModelFit& model : models)
    if (model.fit.valid && !model.candidates.empty()) return &model;
  return nullptr;
}

double Posterior::nothing_told() const {
  return std::accumulate(untold.begin(), untold.end(), none);
}

namespace {

/// log weight of every candidate alone that was not fitted so, by the linear evidence that
/// screening about none found; -infinity of the others, of those that these data don't show, and of
/// those that promised more than a bare mention: not fitted, or without a valid fit, they are
/// nothing that is too small to be told.
std::vector<double> untold_weights(const SearchResult& search, double none_complete,
                                   const Settings& settings) {
  const std::size_t n = search.probes.size();
  const double prior = log_prior(1, n, settings) - log_prior(0, n, settings);
  std::vector<double> weights;
  for (const Probe& probe : search.probes) {
    const bool small = probe.valid && probe.score <= settings.bare_mention;
    weights.push_back(small ? none_complete + prior + probe.score : -kInfinity);
  }
  for (const ModelFit& m : search.models)
    if (m.candidates.size() == 1 && m.fit.valid) weights[m.candidates.front()] = -kInfinity;
  return weights;
}

}  // namespace

double log_prior(std::size_t members, std::size_t candidates, const Settings& settings) {
  const double shared[] = {settings.prior_none, settings.prior_single, settings.prior_pair,
                           settings.prior_triple};
  const auto n = static_cast<double>(candidates), k = static_cast<double>(members);
  const std::size_t known = std::min<std::size_t>(members, 3);
  // Each effect beyond three costs what the third did.
  const double size = std::log(shared[known]) +
                      static_cast<double>(members - known) * std::log(shared[3] / shared[2]);
  const double sets = std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0);
  return size - std::max(0.0, sets);
}

Posterior posterior_of(const SearchResult& search, const Settings& settings) {
  Posterior out;
  out.models = search.models;
  out.indistinguishable = search.indistinguishable;
  out.inclusion.assign(search.probes.size(), 0.0);
  for (const Probe& probe : search.probes) out.scores.push_back(probe.score);

  double all = -kInfinity;
  for (ModelFit& m : out.models) {
    const SpaceWeight weight = weight_of(m, m.fit, settings);
    m.complete = weight.complete + m.moved_complete;
    m.lacking = weight.lacking + m.moved;
    all = log_of_sum(all, log_of_sum(m.complete, m.lacking));
  }
  out.untold = untold_weights(search, out.models.front().complete, settings);
  for (const double weight : out.untold) all = log_of_sum(all, weight);
  for (double& weight : out.untold) weight = std::exp(weight - all);

  for (ModelFit& m : out.models) {
    m.complete = std::exp(m.complete - all);
    m.lacking = std::exp(m.lacking - all);
    if (m.candidates.empty()) {
      out.none += m.complete;
      out.unexplained += m.lacking;
    }
    for (const int c : m.candidates) out.inclusion[c] += m.probability();
  }
  std::stable_sort(out.models.begin(), out.models.end(), [](const ModelFit& a, const ModelFit& b) {
    return a.probability() > b.probability();
  });
  return out;
}

}  // namespace jaculus::diagnosis
