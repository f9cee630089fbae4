#include "diagnosis/selection/search.h"

#include <algorithm>
#include <set>

#include "diagnosis/selection/fitted_models.h"

namespace jaculus::diagnosis {
namespace {

/// Candidates whose columns, at either strength, reproduce the signature of a fitted single.
Members indistinguishable_from(const Whitening& whitening, const ModelFit& none,
                               const ModelFit& single, const std::vector<Probe>& probes,
                               double below) {
  const Vector signature = none.fit.residual - single.fit.residual;
  const Matrix& nuisances = none.fit.jacobian;
  Members found;
  for (int c = 0; c < count_of(probes); ++c) {
    if (!probes[c].valid) continue;
    double energy = kInfinity;
    for (const Matrix* own : {&probes[c].small, &probes[c].full}) {
      Matrix all(signature.size(), own->cols() + nuisances.cols());
      all << *own, nuisances;
      energy = std::min(energy, unexplained_energy(whitening, single.fit.scales, signature, all));
    }
    if (0.5 * energy < below) found.push_back(c);
  }
  return found;
}

/// Fits whatever can't be told from the best single, best by screening first.
void fit_indistinguishable(const Settings& settings, const Whitening& whitening,
                           const std::vector<Probe>& probes, FittedModels& models) {
  const ModelFit* best = models.best(1);
  if (best == nullptr) return;

  const ModelFit none = models.none();
  Members others =
      indistinguishable_from(whitening, none, *best, probes, settings.indistinguishable_below);
  std::stable_sort(others.begin(), others.end(),
                   [&](int a, int b) { return probes[a].score > probes[b].score; });
  std::erase_if(others, [&](int c) { return models.find({c}) != nullptr; });
  if (count_of(others) > settings.indistinguishable_fitted)
    others.resize(settings.indistinguishable_fitted);
  models.extend(none, probes, others);
}

std::vector<Members> indistinguishable_sets(const Whitening& whitening, const FittedModels& models,
                                            const std::vector<Probe>& probes, double below) {
  std::vector<Members> sets(probes.size());
  for (const ModelFit& model : models.all()) {
    if (model.candidates.size() != 1 || !model.fit.valid) continue;
    const int own = model.candidates.front();
    Members others = indistinguishable_from(whitening, models.none(), model, probes, below);
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

/// Whether a model leaves forces that the plant lacks.
bool leaves_more(const Settings& settings, const ModelFit& model) {
  return model.fit.log_evidence - model.fit.log_complete >= settings.remainder_left;
}

/// Whether the best model of a size gains on the best smaller one.
bool gains(const Settings& settings, const FittedModels& models, int size) {
  const ModelFit *base = models.best(size), *before = models.best(size - 1);
  if (base == nullptr || before == nullptr) return false;
  const double gain = size > 1 ? settings.larger_gain : 0.0;
  return models.value(*base) >= models.value(*before) + gain;
}

/// Every set of the members of one of `roots` and one more candidate.
std::vector<Members> extended_by_one(const std::vector<Members>& roots, int candidates) {
  std::set<Members> sets;
  for (const Members& root : roots) {
    for (int c = 0; c < candidates; ++c) {
      if (std::binary_search(root.begin(), root.end(), c)) continue;
      Members set = root;
      set.insert(std::upper_bound(set.begin(), set.end(), c), c);
      sets.insert(set);
    }
  }
  return {sets.begin(), sets.end()};
}

/// Judges sets of one more effect than `roots` by linear algebra, fits the best, and makes the
/// better ones the next roots. Whether those gain is not asked: two may help only together.
void fit_best_sets(const Problem& problem, const Whitening& whitening,
                   const std::vector<Probe>& probes, FittedModels& models,
                   std::vector<Members>& roots) {
  const Settings& settings = problem.settings;
  std::vector<LinearSet> sets = linear_sets(problem, whitening, models.none().fit, probes,
                                            extended_by_one(roots, count_of(probes)));
  roots.clear();
  for (const LinearSet& set : sets)
    if (count_of(roots) < settings.kept_singles * settings.kept_pairs) roots.push_back(set.members);
  if (count_of(sets) > settings.kept_pairs) sets.resize(settings.kept_pairs);
  models.fit_sets(sets);
}

/// Whether the best set of a size leads one of less by so much that nothing else is sought.
bool leads_clearly(const Settings& settings, const FittedModels& models, const ModelFit& from,
                   int size) {
  const ModelFit* best = models.best(size);
  return best != nullptr && models.value(*best) - models.value(from) > settings.clear_lead;
}

/// Whether models of `size` effects are worth seeking: the best smaller one gains, and leaves
/// forces that the plant lacks.
bool worth_enlarging(const Settings& settings, const FittedModels& models, int size) {
  const ModelFit *base = models.best(size - 1), *before = models.best(size - 2);
  if (base == nullptr || before == nullptr) return false;
  const double gain = size > 2 ? settings.larger_gain : 0.0;
  return models.value(*base) >= models.value(*before) + gain &&
         base->fit.log_evidence - base->fit.log_complete >= settings.remainder_left;
}

void search_about_leaders(const Problem& problem, const SearchOptions& options,
                          FittedModels& models) {
  const Settings& settings = problem.settings;
  for (int size = 2; size <= options.largest; ++size) {
    if (!worth_enlarging(settings, models, size)) return;
    if (options.progress) options.progress(size == 2 ? "pairs of effects" : "triples of effects");

    // What one effect stands in for, a second one may tell apart.
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

void search_larger(const Problem& problem, const Whitening& whitening,
                   const std::vector<Probe>& probes, const SearchOptions& options,
                   FittedModels& models) {
  const Settings& settings = problem.settings;
  std::vector<Members> roots;
  for (int c = 0; c < count_of(probes); ++c) roots.push_back({c});
  if (!gains(settings, models, 1)) return;

  for (int size = 2; size <= options.largest; ++size) {
    if (models.best(size - 1) == nullptr) return;
    const ModelFit from = *models.best(size - 1);
    if (!leaves_more(settings, from)) return;
    if (options.progress) options.progress(size == 2 ? "pairs of effects" : "triples of effects");
    fit_best_sets(problem, whitening, probes, models, roots);

    // Slopes at none no longer hold where effects are strong: then about what leads.
    if (leads_clearly(settings, models, from, size) || !gains(settings, models, size - 1)) continue;
    std::set<Members> extended;
    for (const ModelFit& root : models.close_to(from, size == 2 ? settings.search_roots : 1)) {
      models.extend(root, models.probe(root), settings.kept_pairs);
      extended.insert(root.candidates);
    }
    const ModelFit* reached = models.best(size);
    if (reached == nullptr || models.value(*reached) < models.value(from)) continue;
    const ModelFit best = *reached;
    exchange(models, best, extended, settings.kept_pairs);
  }
}

/// The single that leads none clearly; null where none does.
const ModelFit* clear_leader(const Posterior& posterior, const Settings& settings) {
  const ModelFit* none = posterior.find({});
  const ModelFit* best = posterior.leading();
  if (none == nullptr || best == nullptr) return nullptr;
  return best->log_weight() - none->log_weight() > settings.clear_lead ? best : nullptr;
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
  fit_indistinguishable(problem.settings, comparison.whitening, out.probes, models);
  if (in_windows(problem))
    search_larger(problem, comparison.whitening, out.probes, options, models);
  else
    search_about_leaders(problem, options, models);

  out.indistinguishable = indistinguishable_sets(comparison.whitening, models, out.probes,
                                                 problem.settings.indistinguishable_below);
  out.models = models.all();
  out.predictions = models.predictions();
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
    Comparison about = comparison_about(problem, with_random_effects(problem, std::move(again)));

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
