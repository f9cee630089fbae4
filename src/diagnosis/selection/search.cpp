#include "diagnosis/selection/search.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>

#include "diagnosis/selection/contenders.h"
#include "diagnosis/selection/fitted_models.h"
#include "diagnosis/selection/indistinguishable.h"
#include "diagnosis/selection/moves.h"
#include "diagnosis/selection/neighbouring_sets.h"

namespace jaculus::diagnosis {
namespace {

/// Backwards from the best set, and one for one: each member dropped, what is left fitted, and
/// extended anew where it was not.
void exchange(FittedModels& models, const ModelFit& best, const std::set<Members>& extended,
              int kept) {
  for (const int dropped : best.candidates) {
    const Members rest = without_one(best.candidates, dropped);
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

/// Moves from the leading model to a better one, by one or two effects more, one exchanged, one
/// that joints share given to each of them or one with fewer parameters, until none leads. Slopes
/// hold near a fit only, so each move is judged about what leads there.
void search_from_leader(const Problem& problem, const Whitening& whitening,
                        const std::vector<Probe>& about_none, const SearchOptions& options,
                        FittedModels& models) {
  std::set<Members> left;
  const int rounds = options.rounds.value_or(problem.settings.search_rounds);
  for (int round = 0; round < rounds; ++round) {
    const ModelFit leader = *models.leading();
    if (!left.insert(leader.candidates).second) return;
    if (options.progress)
      options.progress(fmt::format("sets beside {} effects", leader.candidates.size()));
    const Surroundings near{problem, whitening, leader,
                            leader.candidates.empty() ? about_none : models.probe(leader)};
    if (enlarge(near, options.largest, models)) continue;
    exchange_members(near, models);
    part_members(near, options.largest, models);
  }
}

/// Whether models of `size` effects are worth seeking: the best smaller one gains, and leaves more.
bool worth_enlarging(const Problem& problem, const FittedModels& models, int size) {
  const ModelFit *base = models.best(size - 1), *before = models.best(size - 2);
  if (base == nullptr || before == nullptr) return false;
  const double gain = size > 2 ? problem.settings.larger_gain : 0.0;
  return models.value(*base) >= models.value(*before) + gain && leaves_more(problem, base->fit);
}

void search_about_leaders(const Problem& problem, const Whitening& whitening,
                          const SearchOptions& options, FittedModels& models) {
  const Settings& settings = problem.settings;
  for (int size = 2; size <= options.largest; ++size) {
    if (!worth_enlarging(problem, models, size)) return;
    if (options.progress) options.progress(size == 2 ? "pairs of effects" : "triples of effects");

    // What one effect stands in for, a second one may tell apart; and two that are there may each
    // stand behind a third that does a part of both.
    const ModelFit from = *models.best(size - 1);
    std::set<Members> extended;
    for (const ModelFit& root : models.close_to(from, size == 2 ? settings.pair_roots : 1)) {
      const bool foremost = std::ssize(extended) < settings.search_roots;
      if (!foremost && models.value(root) < models.value(from) - settings.clear_lead) break;
      const Surroundings near{problem, whitening, root, models.probe(root)};
      if (!foremost) {
        models.extend(root, near.probes, settings.kept_rivals);
        continue;
      }
      const std::vector<LinearSet> two = two_at_once(near, options.largest, models);
      models.extend(root, near.probes, settings.kept_pairs);
      models.fit_sets(root, two, near.probes);
      extended.insert(root.candidates);
    }

    const ModelFit* reached = models.best(size);
    if (reached == nullptr || models.value(*reached) < models.value(from)) return;
    const ModelFit best = *reached;
    exchange(models, best, extended, settings.kept_pairs);
  }
}

/// The set that leads none clearly; null where none does.
const ModelFit* clear_leader(const Posterior& posterior, const Settings& settings) {
  const ModelFit* none = posterior.find({});
  const ModelFit* best = posterior.leading();
  if (none == nullptr || best == nullptr) return nullptr;
  return best->log_weight() - none->log_weight() > settings.clear_lead ? best : nullptr;
}

/// The best models of a search, as many as are fitted in one move.
std::vector<ModelFit> best_models(const SearchResult& search, const Settings& settings) {
  std::vector<ModelFit> models;
  for (const ModelFit* model : most_probable_first(search.models))
    if (count_of(models) < settings.kept_singles) models.push_back(*model);
  return models;
}

/// Leaves out the models that the best one of a search leads clearly, but for none and the next
/// few: on more windows it would lead them by more.
void leave_out_led_models(const Settings& settings, SearchResult& search) {
  std::vector<double> weights;
  for (const ModelFit& model : search.models) weights.push_back(model.log_weight());
  std::sort(weights.begin(), weights.end(), std::greater<>());
  const auto next = std::min<std::size_t>(settings.kept_rivals, weights.size() - 1);
  const double least = std::min(weights[next], weights.front() - settings.clear_lead);
  std::erase_if(search.models, [&](const ModelFit& model) {
    return !model.candidates.empty() && model.log_weight() < least;
  });
}

/// The best single of a search, if it led none, and those that led and can't be told from it. A
/// space about a strong effect may not show it to screening, which looks from none: there noise is
/// told by what the effect leaves, and a step of the effect alone leaves the reach of slopes.
std::vector<ModelFit> rivals_that_led(const SearchResult& search, const Problem& problem) {
  const double none = search.models.front().log_weight();
  double best = none;
  std::vector<ModelFit> rivals;
  for (const ModelFit& model : search.models) {
    if (model.candidates.size() != 1 || model.log_weight() <= none) continue;
    best = std::max(best, model.log_weight());
    rivals.push_back(model);
  }

  const double least = best - problem.settings.indistinguishable_below;
  std::erase_if(rivals, [&](const ModelFit& model) { return model.log_weight() < least; });
  return rivals;
}

/// Whether events or patterns are candidates and no set with one comes near what leads, as far as
/// fits by slopes tell: tolerances that are simulated move evidence by tens of nats. Such a search
/// serves to establish these; what leads without them is known from the search before.
bool beyond_reach(const Problem& problem, const FittedModels& models) {
  const Hypotheses& hypotheses = problem.hypotheses;
  const double least = models.value(*models.leading()) - problem.settings.far_behind;
  for (const ModelFit& model : models.all())
    if (model.fit.valid && models.value(model) >= least &&
        hypotheses.beyond_effects(model.candidates))
      return false;
  return hypotheses.beyond_effects();
}

/// The space about what tolerances fit without any effect, where they leave nothing more: within a
/// window they may move a light joint by degrees, farther than slopes at the files' values reach,
/// and effects would stand in for what such slopes miss.
Comparison about_tolerances(const Problem& problem, Comparison comparison) {
  auto about = relinearise_about_none(problem, comparison, short_fit());
  return !about || leaves_more(problem, about->fit) ? comparison : std::move(about->comparison);
}

}  // namespace

SearchResult search_models(const Problem& problem, const Comparison& comparison,
                           const SearchOptions& options) {
  FittedModels models(problem, comparison, options.earlier, options.same_space);
  SearchResult out;
  if (!models.none().fit.valid) return out;

  const ModelFit none = models.none();
  if (options.progress) options.progress("screening");
  out.probes = models.probe(none);
  const RandomEffects& random = comparison.whitening.random;
  if (in_windows(problem)) {
    if (options.earlier != nullptr)
      models.fit_again(best_models(*options.earlier, problem.settings));
    search_from_leader(problem, comparison.whitening, out.probes, options, models);
  } else {
    if (options.progress) options.progress("single effects");
    models.extend(none, out.probes, problem.settings.kept_singles);
    if (options.earlier != nullptr) models.fit_again(rivals_that_led(*options.earlier, problem));
    models.fit_again(options.known);
    if (!options.known.empty()) models.seek_beyond_effects();
    fit_indistinguishable(problem.settings, random, out.probes, models);
    search_about_leaders(problem, comparison.whitening, options, models);
    if (options.largest > 1)
      search_from_leader(problem, comparison.whitening, out.probes, options, models);
  }

  if (problem.hypotheses.beyond_effects()) models.fit_without_forces();
  const Members led = options.known.empty() ? Members{} : options.known.front().candidates;
  if (options.earlier != nullptr && !beyond_reach(problem, models))
    models.refine(options.none, led);
  out.indistinguishable =
      indistinguishable_sets(random, models, out.probes, problem.settings.indistinguishable_below);
  out.nuisance_rows = models.nuisance_rows();
  out.predictions = models.predictions();
  const bool last = options.earlier != nullptr;
  out.models = last ? pooled(problem, comparison, models.all(), out.predictions) : models.all();
  return out;
}

Selection select_models(const Problem& problem, Comparison comparison,
                        const std::function<void(const std::string&)>& progress,
                        std::vector<ModelFit> known) {
  if (in_windows(problem) && !problem.hypotheses.tolerances.empty())
    comparison = about_tolerances(problem, std::move(comparison));
  const int first = in_windows(problem) ? problem.settings.largest_set : 1;
  const SearchResult singles =
      search_models(problem, comparison, {first, nullptr, false, {}, {}, {}, progress});
  if (singles.models.empty()) return {std::move(comparison), singles};
  const Posterior posterior = posterior_of(singles, problem.settings);
  const bool fixed = problem.hypotheses.tolerances.empty();
  if (posterior.nothing_told() > problem.settings.likely && fixed)
    return {std::move(comparison), singles};

  const ModelFit* leader = clear_leader(posterior, problem.settings);
  const bool same_space = leader == nullptr && fixed;
  if (same_space && in_windows(problem))
    return {std::move(comparison), singles};  // sought in full already
  std::optional<Relinearised> about_none;
  std::optional<Vector> none;
  if (!same_space) {
    ToldAnew told = told_anew(problem, comparison, singles.models.front().fit, leader,
                              problem.settings.relinearisations, singles.nuisance_rows);
    comparison = std::move(told.comparison);
    if (told.about_none) none = told.about_none->fit.p;
    // For the scan of pushes, which are sought under a plan alone.
    if (!in_windows(problem)) about_none = std::move(told.about_none);
  }
  const int largest =
      in_windows(problem) ? problem.settings.largest_set : problem.settings.largest_model;
  const SearchOptions options{largest, &singles, same_space, {}, none, std::move(known), progress};
  SearchResult search = search_models(problem, comparison, options);
  search.predictions += singles.predictions;
  return {std::move(comparison), std::move(search), std::move(about_none)};
}

Selection select_models_from(const Problem& problem, Comparison comparison, SearchResult part,
                             const std::function<void(const std::string&)>& progress) {
  const auto fitted = [&](const Fit& fit) {
    return fit_model(problem, comparison.whitening, fit.free, {fit.p}, short_fit());
  };
  const Fit none = fitted(part.models.front().fit);
  const Posterior posterior = posterior_of(part, problem.settings);
  std::optional<ModelFit> leader;
  if (const ModelFit* own = clear_leader(posterior, problem.settings)) {
    leader = *own;
    leader->fit = fitted(own->fit);
  }
  if (!none.valid || (leader && !leader->fit.valid))
    return select_models(problem, std::move(comparison), progress);
  // The part's search told noise anew already; once more, about all windows.
  ToldAnew told = told_anew(problem, comparison, none, leader ? &*leader : nullptr, 1);
  comparison = std::move(told.comparison);
  leave_out_led_models(problem.settings, part);
  const Settings& settings = problem.settings;
  SearchOptions options{
      settings.largest_set, &part, false, settings.rounds_after_part, {}, {}, progress};
  if (told.about_none) options.none = told.about_none->fit.p;
  SearchResult search = search_models(problem, comparison, options);
  search.predictions += part.predictions;
  return {std::move(comparison), std::move(search)};
}

}  // namespace jaculus::diagnosis
