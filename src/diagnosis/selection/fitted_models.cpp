#include "diagnosis/selection/fitted_models.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

namespace jaculus::diagnosis {

FittedModels::FittedModels(const Problem& problem, const Comparison& comparison,
                           const SearchResult* earlier)
    : problem_(problem), comparison_(comparison), earlier_(earlier) {
  fit({Job{{}, {problem.hypotheses.nominal()}}});
}

double FittedModels::value(const ModelFit& model) const { return model.log_weight(); }

const ModelFit* FittedModels::find(const Members& members) const {
  for (const ModelFit& model : models_)
    if (model.candidates == members) return &model;
  return nullptr;
}

const ModelFit* FittedModels::best(int size) const {
  const ModelFit* best = nullptr;
  for (const ModelFit& model : models_) {
    if (count_of(model.candidates) != size || !model.fit.valid) continue;
    if (best == nullptr || value(model) > value(*best)) best = &model;
  }
  return best;
}

std::vector<ModelFit> FittedModels::close_to(const ModelFit& from, int count) const {
  std::vector<ModelFit> close;
  for (const ModelFit& model : models_)
    if (model.candidates.size() == from.candidates.size() && model.fit.valid)
      close.push_back(model);

  std::stable_sort(close.begin(), close.end(),
                   [&](const ModelFit& a, const ModelFit& b) { return value(a) > value(b); });
  if (count_of(close) > count) close.resize(count);
  return close;
}

std::vector<Probe> FittedModels::probe(const ModelFit& base) {
  const bool about_none = base.candidates.empty();
  std::vector<Probe> probes = screen(problem_, comparison_.whitening, base.fit,
                                     about_none ? Screening::line_search : Screening::steps);
  for (const Probe& probe : probes) predictions_ += probe.predictions;
  return probes;
}

void FittedModels::extend(const ModelFit& base, const std::vector<Probe>& probes, int count) {
  Members order(probes.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return probes[a].score > probes[b].score; });

  const double least = base.candidates.empty() ? -kInfinity : problem_.settings.member_gain;
  std::erase_if(order, [&](int c) { return !probes[c].valid || probes[c].score < least; });
  if (count_of(order) > count) order.resize(count);
  extend(base, probes, order);
}

void FittedModels::extend(const ModelFit& base, const std::vector<Probe>& probes,
                          const Members& which) {
  std::vector<Job> jobs;
  for (const int c : which) {
    if (!probes[c].valid) continue;
    Job job;
    job.members = base.candidates;
    job.members.insert(std::upper_bound(job.members.begin(), job.members.end(), c), c);
    if (find(job.members) != nullptr) continue;

    job.starts = fit_starts(problem_, base.fit.p, c, probes[c]);
    if (const Fit* known = base.candidates.empty() ? fitted_earlier(c) : nullptr)
      job.starts.insert(job.starts.begin(), known->p);
    job.enough = base.fit.log_evidence + probes[c].score - problem_.settings.start_reached;
    jobs.push_back(job);
  }
  fit(jobs);
}

const Fit* FittedModels::fitted_earlier(int candidate) const {
  if (earlier_ == nullptr) return nullptr;
  for (const ModelFit& model : earlier_->models)
    if (model.fit.valid && model.candidates == Members{candidate}) return &model.fit;
  return nullptr;
}

void FittedModels::fit(const std::vector<Job>& jobs) {
  const std::size_t candidates = problem_.hypotheses.candidates.size();
  std::vector<ModelFit> fits(jobs.size());
  tbb::parallel_for(0, count_of(jobs), [&](int i) {
    ModelFit& model = fits[i];
    model.candidates = jobs[i].members;
    model.log_prior = log_prior(model.candidates.size(), candidates, problem_.settings);

    FitOptions options;
    options.enough = jobs[i].enough;
    if (!models_.empty()) options.scales = none().fit.scales;
    const std::vector<int> free = problem_.hypotheses.freed_by(model.candidates);
    model.fit = fit_model(problem_, comparison_.whitening, free, jobs[i].starts, options);
    if (model.candidates.size() == 1)
      model.fit = fit_around(problem_, comparison_.whitening, model.fit, options);
  });

  for (ModelFit& fit : fits) {
    predictions_ += fit.fit.predictions;
    models_.push_back(std::move(fit));
  }
}

}  // namespace jaculus::diagnosis
