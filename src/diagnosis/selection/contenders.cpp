#include "diagnosis/selection/contenders.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "diagnosis/noise/log_probability.h"

namespace jaculus::diagnosis {
namespace {

double most_of(const SpaceWeight& weight) { return std::max(weight.lacking, weight.complete); }

/// Places of the models that may tell the noise.
std::vector<int> contenders_of(const std::vector<ModelFit>& models, const Settings& settings) {
  const auto valid = [](const ModelFit& model) { return model.fit.valid; };
  const ModelFit* best = most_probable(models, valid);
  std::vector<int> places;
  for (int i = 0; i < count_of(models); ++i)
    if (valid(models[i]) && !models[i].fit.by_slopes() &&
        models[i].log_weight() >= best->log_weight() - settings.clear_lead)
      places.push_back(i);
  return places;
}

/// The space about a model as it was fitted; not valid where its noise can't be told.
std::optional<Comparison> space_about(const Problem& problem, const Comparison& comparison,
                                      const Fit& fit) {
  NoiseModel noise = estimate_noise(problem, fit.simulated, comparison.noise.alignments);
  if (!noise.valid()) return {};
  return comparison_about(problem, with_random_effects(problem, std::move(noise)));
}

/// A model in another space, from where it was fitted.
Fit fit_there(const Problem& problem, const Comparison& there, const Fit& fit) {
  FitOptions options;
  options.scales = fit.scales;
  options.with_forces = true;
  options.known_rows = fit.nuisance_rows;
  options.renew = false;
  return fit_near(problem, there.whitening, fit.free, fit.p, options);
}

/// Whether a model is fitted in the spaces of contenders. None is far from what it tells there, and
/// slopes from elsewhere don't take it to its optimum: it is if it may be the truth.
bool fitted_there(const ModelFit& model, bool contends) {
  return contends || (model.fit.valid && !model.fit.by_slopes() && !model.candidates.empty());
}

/// Weights of all models in one space; of those that were not fitted there as far behind what leads
/// as `here`.
std::vector<SpaceWeight> completed(const SpaceWeights& there,
                                   const std::vector<SpaceWeight>& here) {
  double best_there = -kInfinity, best_here = -kInfinity;
  for (const auto& own : there) best_there = std::max(best_there, own ? most_of(*own) : -kInfinity);
  for (const SpaceWeight& own : here) best_here = std::max(best_here, most_of(own));
  const double moved = best_there - best_here;
  std::vector<SpaceWeight> out;
  for (std::size_t i = 0; i < here.size(); ++i)
    out.push_back(
        there[i].value_or(SpaceWeight{here[i].lacking + moved, here[i].complete + moved}));
  return out;
}

double log_sum(const std::vector<SpaceWeight>& weights) {
  double sum = -kInfinity;
  for (const SpaceWeight& own : weights)
    sum = log_of_sum(sum, log_of_sum(own.lacking, own.complete));
  return sum;
}

/// The exact models in the spaces of the contenders, a space each: nothing where its noise can't be
/// told. `predictions`: counts those that it takes.
std::vector<SpaceWeights> weights_there(const Problem& problem, const Comparison& comparison,
                                        const std::vector<ModelFit>& models,
                                        const std::vector<int>& contenders, long& predictions) {
  const int spaces = count_of(contenders), all = count_of(models);
  std::vector<std::optional<Comparison>> about(contenders.size());
  tbb::parallel_for(0, spaces, [&](int j) {
    about[j] = space_about(problem, comparison, models[contenders[j]].fit);
  });

  std::vector<SpaceWeights> there(contenders.size(), SpaceWeights(models.size()));
  std::vector<long> counts(contenders.size() * models.size(), 0);
  tbb::parallel_for(0, spaces * all, [&](int k) {
    const int j = k / all, i = k % all;
    if (!about[j] || !fitted_there(models[i], index_of(contenders, i) >= 0)) return;
    const Fit fit = fit_there(problem, *about[j], models[i].fit);
    counts[k] = fit.predictions;
    if (fit.valid) there[j][i] = weight_of(models[i], fit, problem.settings);
  });
  for (const long count : counts) predictions += count;
  std::erase_if(there, [&](const SpaceWeights& own) {
    return std::any_of(contenders.begin(), contenders.end(), [&](int i) { return !own[i]; });
  });
  return there;
}

/// The same models without the slopes of rows that other spaces needed: some megabytes each.
std::vector<ModelFit> without_rows(std::vector<ModelFit> models) {
  for (ModelFit& model : models) model.fit.nuisance_rows = {};
  return models;
}

}  // namespace

std::vector<SpaceWeight> over_spaces(const std::vector<SpaceWeight>& here,
                                     const std::vector<SpaceWeights>& there) {
  if (there.empty()) return here;
  std::vector<SpaceWeight> sums(here.size());
  for (const SpaceWeights& space : there) {
    const std::vector<SpaceWeight> own = completed(space, here);
    const double norm = log_sum(own);
    for (std::size_t i = 0; i < here.size(); ++i) {
      sums[i].lacking = log_of_sum(sums[i].lacking, own[i].lacking - norm);
      sums[i].complete = log_of_sum(sums[i].complete, own[i].complete - norm);
    }
  }

  const double norm = log_sum(here) - std::log(static_cast<double>(there.size()));
  for (SpaceWeight& own : sums) own = {own.lacking + norm, own.complete + norm};
  return sums;
}

std::vector<ModelFit> pooled(const Problem& problem, const Comparison& comparison,
                             std::vector<ModelFit> models, long& predictions) {
  if (in_windows(problem)) return models;
  const std::vector<int> contenders = contenders_of(models, problem.settings);
  if (contenders.size() < 2) return without_rows(std::move(models));

  std::vector<SpaceWeight> here;
  for (const ModelFit& model : models)
    here.push_back(weight_of(model, model.fit, problem.settings));
  const std::vector<SpaceWeight> all =
      over_spaces(here, weights_there(problem, comparison, models, contenders, predictions));
  for (std::size_t i = 0; i < models.size(); ++i) {
    if (std::isfinite(here[i].lacking)) models[i].moved = all[i].lacking - here[i].lacking;
    if (std::isfinite(here[i].complete))
      models[i].moved_complete = all[i].complete - here[i].complete;
  }
  return without_rows(std::move(models));
}

}  // namespace jaculus::diagnosis
