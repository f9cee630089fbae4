#include "diagnosis/selection/search.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "diagnosis/selection/fitted_models.h"
#include "diagnosis/selection/structure.h"

namespace jaculus::diagnosis {
namespace {

double structure_of(const Problem& problem, const Comparison& comparison, const ModelFit& model) {
  return structure_evidence(problem, comparison.noise, comparison.whitening, model.fit);
}

/// Candidates whose columns, at either strength, reproduce the signature of a fitted single.
Members indistinguishable_from(const ModelFit& none, const ModelFit& single,
                               const std::vector<Probe>& probes, double below) {
  const Vector signature = none.fit.residual - single.fit.residual;
  const Matrix& nuisances = none.fit.jacobian;
  Members found;
  for (int c = 0; c < count_of(probes); ++c) {
    if (!probes[c].valid) continue;
    double energy = kInfinity;
    for (const Matrix* own : {&probes[c].small, &probes[c].full}) {
      Matrix all(signature.size(), own->cols() + nuisances.cols());
      all << *own, nuisances;
      energy = std::min(energy, unexplained_energy(signature, all));
    }
    if (0.5 * energy < below) found.push_back(c);
  }
  return found;
}

/// Fits whatever can't be told from the best single, best by screening first.
void fit_indistinguishable(const Settings& settings, const std::vector<Probe>& probes,
                           FittedModels& models) {
  const ModelFit* best = models.best(1);
  if (best == nullptr) return;

  const ModelFit none = models.none();
  Members others = indistinguishable_from(none, *best, probes, settings.indistinguishable_below);
  std::stable_sort(others.begin(), others.end(),
                   [&](int a, int b) { return probes[a].score > probes[b].score; });
  std::erase_if(others, [&](int c) { return models.find({c}) != nullptr; });
  if (count_of(others) > settings.indistinguishable_fitted)
    others.resize(settings.indistinguishable_fitted);
  models.extend(none, probes, others);
}

std::vector<Members> indistinguishable_sets(const FittedModels& models,
                                            const std::vector<Probe>& probes, double below) {
  std::vector<Members> sets(probes.size());
  for (const ModelFit& model : models.all()) {
    if (model.candidates.size() != 1 || !model.fit.valid) continue;
    const int own = model.candidates.front();
    Members others = indistinguishable_from(models.none(), model, probes, below);
    std::erase(others, own);
    others.insert(others.begin(), own);
    sets[own] = others;
  }
  return sets;
}

/// Backwards from the best set, and one for one: each member dropped, what is left fitted, and
/// extended anew where it was not.
void exchange(FittedModels& models, const ModelFit& best, const std::set<Members>& extended,
              int kept) {
  for (const int dropped : best.candidates) {
    Members rest = best.candidates;
    std::erase(rest, dropped);
    if (models.find(rest) == nullptr) {
      Members root = rest;
      root.pop_back();
      const ModelFit* fitted = models.find(root);
      if (fitted == nullptr) continue;
      const ModelFit copy = *fitted;
      models.extend(copy, models.probe(copy), Members{rest.back()});
    }

    const ModelFit* smaller = models.find(rest);
    if (smaller == nullptr || !smaller->fit.valid || extended.contains(rest)) continue;
    const ModelFit copy = *smaller;
    models.extend(copy, models.probe(copy), kept);
  }
}

/// Whether models of `size` effects are worth seeking: the best smaller one gains, and leaves
/// structure.
bool worth_enlarging(const Problem& problem, const Comparison& comparison,
                     const FittedModels& models, int size) {
  const Settings& settings = problem.settings;
  const ModelFit *base = models.best(size - 1), *before = models.best(size - 2);
  if (base == nullptr || before == nullptr) return false;
  const double gain = size > 2 ? settings.larger_gain : 0.0;
  if (models.value(*base) < models.value(*before) + gain) return false;

  const double left = structure_of(problem, comparison, *base);
  if (left < settings.structure_left) return false;
  // A set that takes little off what its best member leaves is not on the way to an explanation.
  return size == 2 ||
         left <= settings.triples_worthwhile * structure_of(problem, comparison, *before);
}

void search_larger(const Problem& problem, const Comparison& comparison,
                   const SearchOptions& options, FittedModels& models) {
  const Settings& settings = problem.settings;
  for (int size = 2; size <= options.largest; ++size) {
    if (!worth_enlarging(problem, comparison, models, size)) return;
    if (options.progress) options.progress(size == 2 ? "pairs of effects" : "triples of effects");

    // What the form of an effect may hide, a second effect may tell apart.
    const ModelFit from = *models.best(size - 1);
    std::set<Members> extended;
    for (const ModelFit& root : models.close_to(from, size == 2 ? settings.search_roots : 1)) {
      models.extend(root, models.probe(root), settings.kept_pairs);
      extended.insert(root.candidates);
    }

    const ModelFit* reached = models.best(size);
    if (reached == nullptr || models.value(*reached) < models.value(from)) return;
    const ModelFit best = *reached;
    exchange(models, best, extended, settings.kept_pairs);
  }
}

/// Structure in what `none` leaves, and the models that lead with or without the form of effects
/// counted.
void test_structure(const Problem& problem, const Comparison& comparison,
                    std::vector<ModelFit>& models) {
  const double none = models.front().fit.log_evidence;
  std::vector<int> order(models.size());
  std::iota(order.begin(), order.end(), 0);
  std::set<int> chosen;
  for (const double form : {problem.settings.form_member, 0.0}) {
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
      return log_weight(models[a], none, form) > log_weight(models[b], none, form);
    });
    for (int i = 0; i < count_of(order); ++i)
      if (i < problem.settings.structure_tested || models[order[i]].candidates.empty())
        chosen.insert(order[i]);
  }

  const std::vector<int> tested(chosen.begin(), chosen.end());
  tbb::parallel_for(0, count_of(tested), [&](int i) {
    ModelFit& model = models[tested[i]];
    if (model.fit.valid) model.structure = structure_of(problem, comparison, model);
  });
}

/// The single that leads none clearly; null where none does.
const ModelFit* clear_leader(const Posterior& posterior, const Settings& settings) {
  const ModelFit* none = posterior.find({});
  const ModelFit* best = posterior.most_evident();
  if (none == nullptr || best == nullptr) return nullptr;
  const double lead = best->fit.log_evidence - none->fit.log_evidence;
  return lead > settings.clear_lead ? best : nullptr;
}

}  // namespace

SearchResult search_models(const Problem& problem, const Comparison& comparison,
                           const SearchOptions& options) {
  FittedModels models(problem, comparison, options.earlier);
  SearchResult out;
  if (!models.none().fit.valid) return out;

  const ModelFit none = models.none();
  if (options.progress) options.progress("screening");
  out.probes = models.probe(none);
  if (options.progress) options.progress("single effects");
  models.extend(none, out.probes, problem.settings.kept_singles);
  fit_indistinguishable(problem.settings, out.probes, models);
  search_larger(problem, comparison, options, models);

  out.indistinguishable =
      indistinguishable_sets(models, out.probes, problem.settings.indistinguishable_below);
  out.models = models.all();
  out.predictions = models.predictions();
  test_structure(problem, comparison, out.models);
  return out;
}

Selection select_models(const Problem& problem, Comparison comparison,
                        const std::function<void(const std::string&)>& progress) {
  const SearchResult singles = search_models(problem, comparison, {1, nullptr, progress});
  if (singles.models.empty()) return {std::move(comparison), singles};
  const Posterior posterior = posterior_of(singles, problem.settings);
  if (posterior.none > problem.settings.likely) return {std::move(comparison), singles};

  if (const ModelFit* leader = clear_leader(posterior, problem.settings))
    comparison = relinearise(problem, std::move(comparison), leader->fit).comparison;
  const SearchOptions options{problem.settings.largest_model, &singles, progress};
  SearchResult search = search_models(problem, comparison, options);
  search.predictions += singles.predictions;
  return {std::move(comparison), std::move(search)};
}

Relinearised relinearise(const Problem& problem, Comparison comparison, Fit fit) {
  for (int round = 0; round < problem.settings.relinearisations; ++round) {
    NoiseModel again = estimate_noise(problem, fit.p, comparison.noise.alignments);
    if (!again.valid()) break;
    Comparison about =
        comparison_about(problem, with_discrepancy_of(comparison.noise, std::move(again)));

    // A fit goes with the comparison that it was made in: both are taken, or neither.
    const Fit next = fit_model(problem, about.whitening, fit.free, {fit.p});
    if (!next.valid) break;
    comparison = std::move(about);
    const Vector moved =
        problem.hypotheses.scaled(fit.free, next.p) - problem.hypotheses.scaled(fit.free, fit.p);
    fit = next;
    if (moved.cwiseAbs().maxCoeff() < problem.settings.relinearised_within) break;
  }
  return {std::move(comparison), std::move(fit)};
}

}  // namespace jaculus::diagnosis
