#include "diagnosis/selection/indistinguishable.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

#include "diagnosis/noise/columns.h"

namespace jaculus::diagnosis {
namespace {

/// A candidate's columns at one strength, and their products with the nuisances.
struct Probed {
  Columns own;
  Across nuisances;
};

/// Columns of every candidate at the two strengths, none where its probe is not valid, beside the
/// nuisances of the model without effects.
struct ProbedColumns {
  Columns nuisances;
  std::vector<std::vector<Probed>> candidates;
};

ProbedColumns columns_of_probes(const RandomEffects& random, const ModelFit& none,
                                const std::vector<Probe>& probes) {
  ProbedColumns probed{columns_of(random, none.fit.jacobian), {}};
  probed.candidates.resize(probes.size());
  tbb::parallel_for(0, count_of(probes), [&](int c) {
    if (!probes[c].valid) return;
    for (const Matrix* own : {&probes[c].small, &probes[c].full})
      probed.candidates[c].push_back(
          {columns_of(random, *own), products_between(random, probed.nuisances.X, *own)});
  });
  return probed;
}

/// Log evidence of every candidate alone: as fitted, else as screening has it.
std::vector<double> evidence_alone(const FittedModels& models, const std::vector<Probe>& probes) {
  std::vector<double> evidence;
  for (int c = 0; c < count_of(probes); ++c) {
    const ModelFit* fitted = models.find({c});
    const bool known = fitted != nullptr && fitted->fit.valid;
    evidence.push_back(known ? fitted->fit.log_evidence
                             : models.none().fit.log_evidence + probes[c].score);
  }
  return evidence;
}

/// Candidates whose columns, at either strength, reproduce the signature of a fitted single. A
/// signature that the nuisances reproduce by themselves says nothing of candidates: then those that
/// are as probable.
Members indistinguishable_from(const RandomEffects& random, const ModelFit& none,
                               const ModelFit& single, const ProbedColumns& probed,
                               const std::vector<double>& evidence, double below) {
  const Columns& nuisances = probed.nuisances;
  const Columns signature = columns_of(random, none.fit.residual - single.fit.residual);
  const Across across = products_between(random, signature.X, nuisances.X);
  const auto energy_beside = [&](const Across& others, const Products& own) {
    return unexplained_energy(random, single.fit.scales,
                              side_by_side(signature.products, others, own), nuisances.X.cols());
  };
  std::vector<double> energy(probed.candidates.size(), kInfinity);
  tbb::parallel_for(0, count_of(energy), [&](int c) {
    for (const Probed& p : probed.candidates[c])
      energy[c] = std::min(
          energy[c], energy_beside(across.with(products_between(random, signature.X, p.own.X)),
                                   side_by_side(nuisances.products, p.nuisances, p.own.products)));
  });

  const double alone = energy_beside(across, nuisances.products);
  const double least = 0.5 * alone < below ? single.fit.log_evidence - below : -kInfinity;
  Members found;
  for (int c = 0; c < count_of(energy); ++c)
    if (0.5 * energy[c] < below && evidence[c] >= least) found.push_back(c);
  return found;
}

}  // namespace

void fit_indistinguishable(const Settings& settings, const RandomEffects& random,
                           const std::vector<Probe>& probes, FittedModels& models) {
  const ModelFit* best = models.best(1);
  const ModelFit none = models.none();
  if (best == nullptr || models.value(*best) < models.value(none)) return;

  Members others =
      indistinguishable_from(random, none, *best, columns_of_probes(random, none, probes),
                             evidence_alone(models, probes), settings.indistinguishable_below);
  std::stable_sort(others.begin(), others.end(),
                   [&](int a, int b) { return probes[a].score > probes[b].score; });
  std::erase_if(others, [&](int c) { return models.find({c}) != nullptr; });
  if (count_of(others) > settings.indistinguishable_fitted)
    others.resize(settings.indistinguishable_fitted);
  models.extend(none, probes, others);
}

std::vector<Members> indistinguishable_sets(const RandomEffects& random, const FittedModels& models,
                                            const std::vector<Probe>& probes, double below) {
  const std::vector<double> evidence = evidence_alone(models, probes);
  const ProbedColumns probed = columns_of_probes(random, models.none(), probes);
  std::vector<Members> sets(probes.size());
  for (const ModelFit& model : models.all()) {
    if (model.candidates.size() != 1 || !model.fit.valid) continue;
    const int own = model.candidates.front();
    Members others = indistinguishable_from(random, models.none(), model, probed, evidence, below);
    std::erase(others, own);
    others.insert(others.begin(), own);
    sets[own] = others;
  }
  return sets;
}

}  // namespace jaculus::diagnosis
