// Models that lead, fitted again with tolerances simulated.

#include <Eigen/QR>
#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <set>

#include "diagnosis/selection/fitted_models.h"
#include "diagnosis/selection/known_slopes.h"

namespace jaculus::diagnosis {
namespace {

/// What simulating changed of the largest of some models that `members` contains, the most of those
/// as large; nothing where it contains none.
std::optional<double> moved_alike(const Members& members, const std::map<Members, double>& moved) {
  std::optional<double> alike;
  std::size_t most = 0;
  for (const auto& [within, change] : moved) {
    if (within.size() < most ||
        !std::includes(members.begin(), members.end(), within.begin(), within.end()))
      continue;
    alike = within.size() > most ? change : std::max(change, alike.value_or(change));
    most = within.size();
  }
  return alike;
}

/// Options of a fit that sets out with the slopes of some rows, where these are known.
FitOptions by_rows(FitOptions options, const RowSlopes& rows) {
  if (rows.columns.empty()) return options;
  options.known = {};
  options.known_rows = rows;
  return options;
}

}  // namespace

void FittedModels::refine(const std::optional<Vector>& none_in_own, const Members& led) {
  if (problem_.hypotheses.tolerances.empty() || linear_.slopes.cols() == 0) return;
  probed_.clear();  // they were about fits that change
  std::set<Members> refined = {Members{}};
  std::map<Members, double> moved;  // what simulating changed, of those with effects
  const double best_by_slopes = value(*leading());
  std::vector<Vector> own;
  if (none_in_own) own.push_back(*none_in_own);
  refine(models_.front(), own);
  for (int count = 0;; ++count) {
    if (count >= problem_.settings.refined && refined.contains(leading()->candidates)) break;
    const bool widely = count < problem_.settings.refined;
    ModelFit* next = next_to_refine(refined, moved, best_by_slopes, widely);
    if (next == nullptr) break;
    const double before = value(*next);
    refine(*next);
    if (!next->fit.by_slopes()) moved[next->candidates] = value(*next) - before;
    refined.insert(next->candidates);
  }

  if (problem_.hypotheses.beyond_effects()) refine_effects_alone(led, refined);
  refine_within(*leading(), refined);
  // Windows start from what was measured, so that no landing makes valleys there.
  if (!in_windows(problem_)) share_valleys(refined);
}

ModelFit* FittedModels::next_to_refine(const std::set<Members>& refined,
                                       const std::map<Members, double>& moved,
                                       double best_by_slopes, bool widely) {
  const Settings& settings = problem_.settings;
  const double best = value(*leading());
  return most_probable(models_, [&](const ModelFit& model) {
    if (!model.fit.valid || refined.contains(model.candidates)) return false;
    if (&model == leading()) return true;
    const std::optional<double> alike = moved_alike(model.candidates, moved);
    // Slopes misjudge a model by more than what tells two apart, but alike what it contains; what
    // contains none is compared with others as slopes have them, unless the best of these fell.
    const double least = best - settings.indistinguishable_below;
    return value(model) + alike.value_or(0.0) >= least ||
           (widely && !alike &&
            value(model) >= std::min(best, best_by_slopes) - settings.clear_lead);
  });
}

void FittedModels::refine_once(const Members& members, std::set<Members>& refined) {
  for (ModelFit& model : models_)
    if (model.candidates == members && model.fit.valid && refined.insert(members).second)
      refine(model);
}

void FittedModels::refine_effects_alone(const Members& led, std::set<Members>& refined) {
  refine_once(led, refined);
  for (int count = 0; count < problem_.settings.refined; ++count) {
    ModelFit* best = most_probable(models_, [&](const ModelFit& model) {
      return model.fit.valid && !problem_.hypotheses.beyond_effects(model.candidates);
    });
    if (best == nullptr || !refined.insert(best->candidates).second) return;
    refine(*best);
  }
}

void FittedModels::refine_within(const ModelFit& larger, std::set<Members>& refined) {
  const Members all = larger.candidates;
  for (const int dropped : all) refine_once(without_one(all, dropped), refined);
}

void FittedModels::share_valleys(const std::set<Members>& refined) {
  std::vector<ModelFit*> models;
  for (ModelFit& model : models_)
    if (model.fit.valid && refined.contains(model.candidates)) models.push_back(&model);
  // A larger model's evidence where another one last set out from it: from there again is no news.
  std::map<std::pair<const ModelFit*, const ModelFit*>, double> from;
  for (int round = 0; round < problem_.settings.search_rounds; ++round) {
    bool moved = false;
    for (ModelFit* model : models) {
      std::vector<Vector> starts;
      for (const ModelFit* other : models)
        starts.push_back(problem_.hypotheses.with_nuisances_of(model->fit.p, other->fit.p));
      const double before = model->fit.log_evidence;
      model->fit = fit_from_lower(problem_, comparison_.whitening, std::move(model->fit), starts,
                                  exact_options(*model));
      for (const ModelFit* other : models) {
        double& last = from.try_emplace({other, model}, -kInfinity).first->second;
        if (other->fit.log_evidence > last) fit_within(*other, *model);
        last = other->fit.log_evidence;
      }
      moved = moved || model->fit.log_evidence > before + problem_.settings.scales_settled;
    }
    if (!moved) return;
  }
}

void FittedModels::fit_within(const ModelFit& larger, ModelFit& model) {
  const bool within = std::includes(larger.candidates.begin(), larger.candidates.end(),
                                    model.candidates.begin(), model.candidates.end());
  if (!within || larger.candidates == model.candidates ||
      larger.fit.log_evidence < model.fit.log_evidence + problem_.settings.scales_settled)
    return;
  Members more;
  std::set_difference(larger.candidates.begin(), larger.candidates.end(), model.candidates.begin(),
                      model.candidates.end(), std::back_inserter(more));
  Fit best;
  for (const Vector& start : {optimum_without(problem_, comparison_.whitening, larger.fit, more),
                              problem_.hypotheses.without_effects(larger.fit.p, more)}) {
    Fit fit = fit_by_known(model, start, larger.fit.nuisance_rows);
    // In its own valley the model's own slopes lead it where it is.
    if (fit.valid && !model.fit.nuisance_rows.columns.empty())
      fit = fit_by_known(model, fit.p, model.fit.nuisance_rows);
    if (fit.valid && (!best.valid || fit.log_evidence > best.log_evidence)) best = std::move(fit);
  }
  const double least = model.fit.log_evidence + problem_.settings.scales_settled;
  if (!best.valid || best.log_evidence < least) return;

  best = fit_near(problem_, comparison_.whitening, best.free, best.p,
                  by_rows(exact_options(model), best.nuisance_rows));
  predictions_ += best.predictions;
  if (best.valid && best.log_evidence > model.fit.log_evidence) model.fit = std::move(best);
}

Fit FittedModels::fit_by_known(const ModelFit& model, const Vector& start, const RowSlopes& rows) {
  FitOptions options = by_rows(exact_options(model), rows);
  options.renew = false;
  Fit fit = fit_near(problem_, comparison_.whitening,
                     problem_.hypotheses.freed_by(model.candidates), start, options);
  predictions_ += fit.predictions;
  return fit;
}

FitOptions FittedModels::exact_options(const ModelFit& model) const {
  FitOptions options;
  options.scales = model.fit.scales;
  options.with_forces = true;
  options.known = linear_.slopes;
  options.known_rows = linear_.rows;
  options.keep_rows = !in_windows(problem_);
  // Not under a plan: there a valley is narrow, and effects are few beside eighty tolerances.
  if (in_windows(problem_))
    options.effect_slopes =
        model.fit.jacobian.leftCols(count_of(problem_.hypotheses.parameters_of(model.candidates)));
  return options;
}

Vector FittedModels::by_tolerances(const ModelFit& lead, const ModelFit& model) const {
  const Hypotheses& hypotheses = problem_.hypotheses;
  Vector p = hypotheses.with_nuisances_of(model.fit.p, lead.fit.p);
  if (!problem_.tolerance_part) return p;
  for (const int c : lead.candidates) {
    if (std::binary_search(model.candidates.begin(), model.candidates.end(), c)) continue;
    const Vector moved = hypotheses.candidates[c].theta(lead.fit.p - hypotheses.nominal());
    const Vector t =
        problem_.tolerance_part(c, lead.fit.p).completeOrthogonalDecomposition().solve(moved);
    for (int j = 0; j < count_of(hypotheses.tolerances); ++j) {
      const int i = hypotheses.tolerances[j];
      p[i] = hypotheses.parameters[i].moved(p[i], t[j]);
    }
  }
  return p;
}

void FittedModels::refine(ModelFit& model, std::vector<Vector> starts) {
  const ModelFit& lead = leading() == &model ? none() : *leading();
  for (const Vector& p :
       {model.fit.p, model.fit.simulated,
        problem_.hypotheses.with_nuisances_of(model.fit.p, lead.fit.p), by_tolerances(lead, model)})
    if (std::find(starts.begin(), starts.end(), p) == starts.end()) starts.push_back(p);

  FitOptions options = exact_options(model);
  options.enough = model.fit.log_evidence;
  const std::vector<int> free = problem_.hypotheses.freed_by(model.candidates);
  Fit exact = fit_model(problem_, comparison_.whitening, free, starts, options);
  predictions_ += exact.predictions;
  exact.predictions += model.fit.predictions;
  if (exact.valid && (model.fit.by_slopes() || exact.log_evidence > model.fit.log_evidence))
    model.fit = std::move(exact);
}

}  // namespace jaculus::diagnosis
