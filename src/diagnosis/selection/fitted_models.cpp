#include "diagnosis/selection/fitted_models.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace jaculus::diagnosis {

namespace {

/// From a model that this one contains, with the forces that it lacks: where plain least squares
/// lead away.
Fit fit_beside(const Problem& problem, const Whitening& whitening, const Fit& base,
               const std::vector<int>& free, FitOptions options) {
  options.scales = base.scales;
  options.with_forces = true;
  return fit_model(problem, whitening, free, {base.p}, options);
}

/// Log evidence gained at which a start has reached what screening promised, by slopes at none or a
/// step of one parameter: under a plan, where valleys are narrow, nearly all of it. Where nothing
/// was promised any start will do.
double promised(const Problem& problem, double score) {
  const Settings& settings = problem.settings;
  if (in_windows(problem)) return settings.start_reached * score;
  const double most = score - settings.bare_mention;
  if (most < 0.0) return -kInfinity;
  return std::min(most, settings.start_reached_under_plan * score);
}

Fit better(const Fit& a, const Fit& b) {
  Fit best = b.valid && (!a.valid || b.log_evidence > a.log_evidence) ? b : a;
  best.predictions = a.predictions + b.predictions;
  return best;
}

}  // namespace

FittedModels::FittedModels(const Problem& problem, const Comparison& comparison,
                           const SearchResult* earlier, bool same_space)
    : problem_(problem),
      comparison_(comparison),
      earlier_(earlier),
      same_space_(earlier != nullptr && same_space) {
  const Whitening& whitening = comparison.whitening;
  const Vector& p = comparison.noise.p;
  linear_ = earlier != nullptr ? linear_nuisances(problem, whitening, p, earlier->nuisance_rows)
                               : linear_nuisances(problem, whitening, p);
  predictions_ += linear_.predictions;
  if (same_space_) {
    models_ = earlier_->models;
    return;
  }
  // Nuisances from where the noise was told; noise may be about a model with effects.
  const Hypotheses& hypotheses = problem.hypotheses;
  fit({Job{{},
           hypotheses.gain_starts(
               hypotheses.with_nuisances_of(hypotheses.nominal(), comparison.noise.p))}});
}

bool FittedModels::to_fit(const Members& members) const {
  const bool sought =
      !beyond_effects_only_ || members.size() < 2 || problem_.hypotheses.beyond_effects(members);
  return sought && find(members) == nullptr;
}

double FittedModels::value(const ModelFit& model) const { return model.log_weight(); }

const ModelFit* FittedModels::find(const Members& members) const {
  for (const ModelFit& model : models_)
    if (model.candidates == members) return &model;
  return nullptr;
}

const ModelFit* FittedModels::best(int size) const {
  return most_probable(models_, [size](const ModelFit& model) {
    return count_of(model.candidates) == size && model.fit.valid;
  });
}

const ModelFit* FittedModels::leading() const {
  return most_probable(models_, [](const ModelFit& model) { return model.fit.valid; });
}

std::vector<ModelFit> FittedModels::close_to(const ModelFit& from, int count) const {
  std::vector<ModelFit> close;
  for (const ModelFit* model : most_probable_first(models_))
    if (count_of(close) < count && model->candidates.size() == from.candidates.size() &&
        model->fit.valid)
      close.push_back(*model);
  return close;
}

const std::vector<Probe>& FittedModels::probe(const ModelFit& base) {
  if (base.candidates.empty() && same_space_) return earlier_->probes;
  if (const auto known = probed_.find(base.candidates); known != probed_.end())
    return known->second;
  const bool again = earlier_ != nullptr && in_windows(problem_);
  const bool search = base.candidates.empty() && !again;
  // In the same space: what is linear by another noise and other tolerances may be so no more.
  const auto about_none = probed_.find({});
  const std::vector<Probe>* before = about_none != probed_.end() ? &about_none->second
                                     : same_space_               ? &earlier_->probes
                                                                 : nullptr;
  std::vector<Probe> probes = screen(problem_, comparison_.whitening, base.fit,
                                     search ? Screening::line_search : Screening::steps, before);
  for (std::size_t c = 0; c < probes.size(); ++c) {
    predictions_ += probes[c].predictions;
    if (!base.candidates.empty() || !again) continue;

    // Steps that were searched for stay good starts where the noise is told anew.
    // Not what another number of rows gained.
    const Probe& before = earlier_->probes[c];
    probes[c].step = before.step;
    if (before.small.rows() != comparison_.whitening.rows) continue;
    probes[c].score = std::max(probes[c].score, before.score);
    if (probes[c].valid || !before.valid) continue;
    probes[c].valid = true;
    probes[c].small = before.small;
    probes[c].full = before.full;
  }
  return probed_[base.candidates] = std::move(probes);
}

void FittedModels::extend(const ModelFit& base, const std::vector<Probe>& probes, int count) {
  Members order(probes.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return probes[a].score > probes[b].score; });

  // No step of a line search that helps: nothing to fit.
  const Settings& settings = problem_.settings;
  double best = 0.0;
  for (const Probe& probe : probes) best = std::max(best, probe.valid ? probe.score : 0.0);
  const double asked = base.candidates.empty() ? 0.0 : settings.member_gain;
  const double worth = std::max(asked, settings.worth_fitting * best);
  const double by_slopes = base.candidates.empty() ? 0.0 : settings.member_gain;
  const double least = in_windows(problem_) ? worth : by_slopes;
  std::erase_if(order, [&](int c) {
    return !probes[c].valid || probes[c].score <= least || !to_fit(with_member(base.candidates, c));
  });
  if (count_of(order) > count) order.resize(count);
  extend(base, probes, order);
}

void FittedModels::extend(const ModelFit& base, const std::vector<Probe>& probes,
                          const Members& which) {
  std::vector<Job> jobs;
  for (const int c : which) {
    if (!probes[c].valid) continue;
    Job job;
    job.members = with_member(base.candidates, c);
    if (!to_fit(job.members)) continue;

    job.starts = fit_starts(problem_, base.fit.p, c, probes[c]);
    if (const Fit* known = base.candidates.empty() ? fitted_earlier(c) : nullptr)
      job.starts.insert(job.starts.begin(), known->p);
    job.base = base.fit;
    job.enough = base.fit.log_evidence + promised(problem_, probes[c].score);
    jobs.push_back(job);
  }
  fit(jobs);
}

const Fit& FittedModels::contained_in(const Members& members) const {
  const ModelFit* best = &none();
  for (const int dropped : members) {
    const ModelFit* fitted = find(without_one(members, dropped));
    if (fitted != nullptr && fitted->fit.valid && value(*fitted) > value(*best)) best = fitted;
  }
  return best->fit;
}

void FittedModels::fit_sets(const ModelFit& about, const std::vector<LinearSet>& sets,
                            const std::vector<Probe>& probes) {
  std::vector<Job> jobs;
  for (const LinearSet& set : sets) {
    if (!to_fit(set.members)) continue;
    Job job{set.members, {}, contained_in(set.members)};
    job.starts = starts_of(about, set, probes);
    job.enough = job.base.log_evidence + problem_.settings.member_gain;
    if (!in_windows(problem_)) {
      const double gain = promised(problem_, set.log_evidence - about.fit.log_evidence);
      job.enough = std::max(job.enough, about.fit.log_evidence + gain);
      job.estimate = set.p;
    }
    // Deviations near none are those of its whole misfit, and under a plan slopes reach no farther
    // than to a start: plain least squares first.
    if (!about.candidates.empty() && in_windows(problem_)) {
      job.scales = set.scales;
      job.effect_slopes = slopes_about(about, set.members, probes);
    }
    jobs.push_back(job);
  }
  fit(jobs);
}

Matrix FittedModels::slopes_about(const ModelFit& about, const Members& set,
                                  const std::vector<Probe>& probes) const {
  const std::vector<int> parameters = problem_.hypotheses.parameters_of(set);
  Matrix slopes(comparison_.whitening.rows, count_of(parameters));
  Eigen::Index k = 0;
  for (const int c : set) {
    const std::vector<int>& own = problem_.hypotheses.candidates[c].parameters;
    for (int i = 0; i < count_of(own); ++i, ++k) {
      const int place = index_of(about.fit.free, own[i]);
      if (place < 0 && !probes[c].valid) return {};
      if (place >= 0)
        slopes.col(k) = about.fit.jacobian.col(place);
      else
        slopes.col(k) = -probes[c].better().col(i);
    }
  }
  return slopes;
}

std::vector<Vector> FittedModels::starts_of(const ModelFit& about, const LinearSet& set,
                                            const std::vector<Probe>& probes) const {
  Vector estimated = problem_.hypotheses.without_effects(about.fit.p, about.candidates);
  for (const int i : problem_.hypotheses.parameters_of(set.members)) estimated[i] = set.p[i];

  // Where a step was searched for, slopes may not say what a strong effect does.
  std::vector<Vector> starts = {estimated};
  for (const int c : set.members) {
    if (!probes[c].valid || std::isnan(probes[c].step)) continue;
    const int first = problem_.hypotheses.candidates[c].parameters.front();
    starts.push_back(estimated);
    starts.back()[first] =
        about.fit.p[first] + probes[c].step * problem_.hypotheses.parameters[first].scale;
  }
  return starts;
}

void FittedModels::fit_again(const std::vector<ModelFit>& earlier) {
  std::vector<Job> jobs;
  for (const ModelFit& model : earlier) {
    const auto same = [&](const Job& job) { return job.members == model.candidates; };
    if (!model.fit.valid || find(model.candidates) != nullptr ||
        std::any_of(jobs.begin(), jobs.end(), same))
      continue;
    Job job{model.candidates, {model.fit.p}};
    if (in_windows(problem_)) job.scales = model.fit.scales;
    jobs.push_back(job);
  }
  fit(jobs);
}

void FittedModels::fit_without_forces() {
  const double least = value(*leading()) - problem_.settings.clear_lead;
  const Hypotheses& hypotheses = problem_.hypotheses;
  std::vector<ModelFit> parts;
  for (const ModelFit& model : models_) {
    if (!model.fit.valid || value(model) < least) continue;
    ModelFit part;
    Members forces;
    for (const int c : model.candidates)
      (hypotheses.candidates[c].beyond_effects() ? forces : part.candidates).push_back(c);
    if (forces.empty() || part.candidates.empty()) continue;
    part.fit.valid = true;
    part.fit.p = hypotheses.without_effects(model.fit.p, forces);
    parts.push_back(std::move(part));
  }
  fit_again(parts);
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

    const Whitening& whitening = comparison_.whitening;
    const Fit& base = jobs[i].base;
    FitOptions options;
    options.enough = jobs[i].enough;
    options.by_slopes = &linear_;
    if (!models_.empty()) {
      options.scales = none().fit.scales;
      options.rounds = 1;
      options.scale_steps = problem_.settings.set_scale_steps;
    }
    if (jobs[i].scales.size() > 0) {
      options.scales = jobs[i].scales;
      options.with_forces = true;
      options.rounds = 1;
      options.effect_slopes = jobs[i].effect_slopes;
      if (options.effect_slopes.cols() == 0) options.iterations = problem_.settings.move_iterations;
    }
    const std::vector<int> free = problem_.hypotheses.freed_by(model.candidates);
    model.fit = fit_model(problem_, whitening, free, jobs[i].starts, options);
    const double least =
        base.valid ? base.log_evidence - problem_.settings.gone_astray : -kInfinity;
    if (in_windows(problem_) && !options.with_forces && model.fit.valid &&
        model.fit.log_evidence < least)
      model.fit = better(model.fit, fit_beside(problem_, whitening, base, free, options));
    // Below plain least squares misfits may have another valley than the one that slopes promise.
    const bool short_of_it = !model.fit.valid || model.fit.log_evidence < options.enough;
    if (jobs[i].estimate.size() > 0 && short_of_it)
      model.fit = better(model.fit, fit_near(problem_, whitening, free, jobs[i].estimate, options));
    if (model.candidates.size() == 1 && !options.with_forces)
      model.fit = fit_around(problem_, comparison_.whitening, model.fit, options);
  });

  for (ModelFit& fit : fits) {
    predictions_ += fit.fit.predictions;
    models_.push_back(std::move(fit));
  }
}

}  // namespace jaculus::diagnosis
