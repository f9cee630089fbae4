#include "diagnosis/validation/held_out.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "diagnosis/forward/sensitivities.h"
#include "diagnosis/selection/known_slopes.h"
#include "diagnosis/validation/fit_to_others.h"
#include "diagnosis/validation/fold_interval.h"

namespace jaculus::diagnosis {
namespace {

/// Slopes of all rows by the free parameters of a fit, a prior scale each: a parameter and a
/// dataset each. Nothing where the simulation fails next to the fit.
std::optional<std::vector<std::vector<Vector>>> slopes_of(const Problem& problem,
                                                          const Whitening& whitening,
                                                          const Fit& fit) {
  std::vector<std::vector<Vector>> slopes(fit.free.size());
  std::vector<char> valid(fit.free.size(), 0);
  tbb::parallel_for(0, count_of(fit.free), [&](int i) {
    const double scale = problem.hypotheses.parameters[fit.free[i]].scale;
    const double step = difference_step(fit.jacobian.col(i).norm(), problem.settings);
    auto moved = difference(problem, whitening.alignments, fit.simulated, fit.rows, fit.free[i],
                            step * scale);
    if (!moved) return;
    for (Vector& own : moved->rows) own *= scale / moved->step;
    slopes[i] = std::move(moved->rows);
    valid[i] = 1;
  });
  if (std::find(valid.begin(), valid.end(), 0) != valid.end()) return {};
  return slopes;
}

/// Slopes B of each dataset as B S^(1/2), S = (J^T J + I)^-1 by the rows of a fold.
std::vector<Matrix> open_rows_of(const Problem& problem, const Whitening& fold,
                                 const std::vector<std::vector<Vector>>& slopes) {
  const Matrix J = -fold.columns(slopes);
  Matrix told = J.transpose() * J;
  told.diagonal().array() += 1.0;
  const Eigen::LLT<Matrix> root(told);

  std::vector<Matrix> open;
  for (int d = 0; d < count_of(problem.observations.datasets); ++d) {
    Matrix raw(problem.observations.datasets[d].rows(), J.cols());
    for (Eigen::Index i = 0; i < J.cols(); ++i) raw.col(i) = slopes[i][d];
    open.emplace_back(root.matrixL().solve(raw.transpose()).transpose());
  }
  return open;
}

/// Rows of all segments by a model refitted to a fold; nothing where it can't be simulated.
std::optional<std::vector<Vector>> refitted_rows(const Problem& problem,
                                                 const Comparison& comparison,
                                                 const Whitening& fold, const SegmentMask& mask,
                                                 const Fit& fit) {
  // Windows of a logged input restart, so that slopes hold for another dataset as well.
  if (count_of(mask) > 1 && !in_windows(problem) && !fit.free.empty()) {
    const auto p = fit_to_others(problem, comparison.whitening, fold, mask, fit);
    if (!p) return {};
    const PredictionSet there = predict_all(problem, *p);
    if (!there.valid) return {};
    return rows_of(problem, fold.alignments, there);
  }

  const Matrix J = fit.jacobian(rows_of_part(comparison.whitening, fold), Eigen::all);
  const RandomWeights weights(fold.random, fit.scales);
  NearFit there =
      fit_by_known_slopes(problem, fold, weights, fit.free, J, fit.p, problem.settings.refit_steps);
  if (!there.valid) return {};
  return std::move(there.rows);
}

/// Errors of the segments that a fold leaves out, by the model refitted to the others; nothing
/// where the fold has no rows or can't be simulated. `open`: a dataset each; null: nothing is.
std::optional<Errors> judge_fold(const Problem& problem, const Comparison& comparison,
                                 const SegmentMask& mask, const Fit& fit,
                                 const std::vector<Matrix>* open) {
  const Whitening fold = whitening_of(problem, comparison.noise, mask);
  if (fold.rows == 0) return {};
  const auto rows = refitted_rows(problem, comparison, fold, mask, fit);
  if (!rows) return {};

  Errors errors(problem);
  for (int d = 0; d < count_of(mask); ++d) {
    const ObservedDataset& observed = problem.observations.datasets[d];
    const auto trained = static_cast<double>(std::count(mask[d].begin(), mask[d].end(), true));
    const bool alone = observed.measured_input || trained == 0.0;
    const Judge judge{
        observed,         comparison.noise.datasets[d], comparison.whitening.datasets[d],
        problem.settings, alone ? kInfinity : trained,  open != nullptr ? &(*open)[d] : nullptr};
    const Vector residual = measured_rows(observed, comparison.noise.alignments[d]) - (*rows)[d];
    for (int s = 0; s < count_of(mask[d]); ++s)
      if (!mask[d][s]) judge.judge(d, s, residual, errors);
  }
  return errors;
}

/// A fit of some of a fit's free parameters, gains last: slopes that are there serve until they are
/// renewed.
FitOptions known_options(const Problem& problem, const Fit& fit, const std::vector<int>& free) {
  const auto gains = count_of(problem.hypotheses.gains);
  Matrix slopes(fit.jacobian.rows(), count_of(free));
  for (int k = 0; k < count_of(free); ++k)
    slopes.col(k) = fit.jacobian.col(index_of(fit.free, free[k]));
  FitOptions options;
  options.scales = fit.scales;
  options.known = slopes.rightCols(gains);
  // Under a plan a valley is narrow, and the larger set's slopes are of another one.
  if (in_windows(problem)) options.effect_slopes = slopes.leftCols(slopes.cols() - gains);
  return options;
}

double shrink_of(double before, double after) { return 1.0 - (after - 1.0) / (before - 1.0); }

/// Student's t over the folds about `shrink`.
Bounds shrink_interval(const std::vector<FoldGap>& folds, double shrink, double least_gap) {
  std::vector<double> shrinks;
  for (const FoldGap& fold : folds)
    if (fold.before > least_gap && std::isfinite(fold.after))
      shrinks.push_back(shrink_of(fold.before, fold.after));
  return fold_interval(shrinks, shrink);
}

/// Errors of a channel in its unit, a horizon each.
std::vector<HorizonGap> in_units(const Settings& settings, const Errors& before,
                                 const Errors& after, int dataset, int channel) {
  const std::vector<double> horizons = horizons_of(settings);
  std::vector<HorizonGap> gaps;
  for (std::size_t h = 0; h < horizons.size(); ++h) {
    const UnitSums& none = before.units[h][dataset][channel];
    const UnitSums& model = after.units[h][dataset][channel];
    if (none.count == 0.0) continue;
    gaps.push_back({horizons[h], none.reach, std::sqrt(none.squares / none.count),
                    std::sqrt(model.squares / model.count), std::sqrt(none.variance / none.count)});
  }
  return gaps;
}

/// Root mean squares by channel, named by its dataset too where there are several.
std::map<std::string, ChannelShrink> by_channel(const Problem& problem, const Errors& before,
                                                const Errors& after) {
  std::map<std::string, ChannelShrink> channels;
  const bool several = before.squares.size() > 1;
  for (int d = 0; d < count_of(before.squares); ++d) {
    const ObservedDataset& observed = problem.observations.datasets[d];
    const std::string prefix = several ? observed.name() + "." : "";
    for (int c = 0; c < count_of(observed.channels); ++c) {
      const double count = before.counts[d][c];
      if (count == 0.0) continue;
      const Channel& channel = observed.channels[c];
      channels[prefix + channel.stream + "." + channel.name] = {
          std::sqrt(before.squares[d][c] / count),
          std::sqrt(after.squares[d][c] / count),
          several ? observed.name() : "",
          channel.name,
          channel.unit,
          in_units(problem.settings, before, after, d, c)};
    }
  }
  return channels;
}

}  // namespace

OpenRows open_rows(const Problem& problem, const Comparison& comparison, const Folds& folds,
                   const Fit& none) {
  if (problem.observations.datasets.size() < 2 || !none.valid || none.free.empty()) return {};
  const auto slopes = slopes_of(problem, comparison.whitening, none);
  if (!slopes) return {};
  OpenRows open;
  for (const SegmentMask& mask : folds.masks)
    open.push_back(open_rows_of(problem, whitening_of(problem, comparison.noise, mask), *slopes));
  return open;
}

JudgedFit judge_fit(const Problem& problem, const Comparison& comparison, const Folds& folds,
                    const Fit& fit, const OpenRows& open) {
  JudgedFit judged{std::vector<std::optional<Errors>>(folds.masks.size())};
  if (!fit.valid) return judged;
  tbb::parallel_for(0, count_of(judged.folds), [&](int f) {
    judged.folds[f] =
        judge_fold(problem, comparison, folds.masks[f], fit, open.empty() ? nullptr : &open[f]);
  });
  return judged;
}

HeldOut held_out(const Problem& problem, const Folds& folds, const JudgedFit& stated,
                 const JudgedFit& none, const JudgedFit& model) {
  HeldOut out;
  out.over = folds.over;
  Errors before(problem), adjusted(problem), after(problem);
  for (std::size_t f = 0; f < folds.masks.size(); ++f) {
    out.by_fold.push_back({});
    if (!stated.folds[f] || !none.folds[f] || !model.folds[f]) continue;
    out.by_fold.back() = {stated.folds[f]->overall(), model.folds[f]->overall()};
    ++out.folds;
    before.add(*stated.folds[f]);
    adjusted.add(*none.folds[f]);
    after.add(*model.folds[f]);
  }
  if (out.folds == 0) return out;

  out.valid = true;
  out.before = before.overall();
  out.adjusted = adjusted.overall();
  out.after = after.overall();
  out.log_gain = after.log_density - adjusted.log_density;
  if (out.before >= problem.settings.plain_gap) {
    out.shrink = shrink_of(out.before, out.after);
    out.ci95 = shrink_interval(out.by_fold, *out.shrink, problem.settings.gap_of_fold);
  }
  out.channels = by_channel(problem, before, after);
  return out;
}

Fit as_stated(const Problem& problem, const Whitening& whitening) {
  const Vector nominal = problem.hypotheses.nominal();
  Fit fit = fit_model(problem, whitening, problem.hypotheses.gains,
                      problem.hypotheses.gain_starts(nominal));
  return fit.valid ? fit : evaluate_model(problem, whitening, nominal);
}

bool no_worse(double after, double before, const Settings& settings) {
  return after <= (1.0 + settings.least_improvement_small_gap) * before;
}

HeldOutGaps::HeldOutGaps(const Problem& problem, const Comparison& comparison,
                         const Posterior& posterior, const Fit& stated, const Fit& none)
    : problem_(problem),
      comparison_(comparison),
      posterior_(posterior),
      folds_(folds_of(problem.observations, problem.settings)),
      open_(open_rows(problem, comparison, folds_, none)),
      stated_(judge_fit(problem, comparison, folds_, stated, open_)),
      none_(judge_fit(problem, comparison, folds_, none, open_)) {}

const ModelFit& HeldOutGaps::subset(const ModelFit& model, const std::vector<int>& members) {
  return members == model.candidates ? model : held(model, members);
}

const ModelFit& HeldOutGaps::held(const ModelFit& model, const std::vector<int>& members) {
  const auto known = subsets_.find(members);
  if (known != subsets_.end()) return known->second;

  const Hypotheses& hypotheses = problem_.hypotheses;
  ModelFit less;
  less.candidates = members;
  Vector p = model.fit.p;
  for (const int c : model.candidates) {
    if (std::binary_search(members.begin(), members.end(), c)) continue;
    for (const int i : hypotheses.candidates[c].parameters) p[i] = hypotheses.parameters[i].nominal;
  }
  std::vector<int> free = hypotheses.parameters_of(members);
  free.insert(free.end(), hypotheses.gains.begin(), hypotheses.gains.end());
  less.fit = fit_model(problem_, comparison_.whitening, free, {p},
                       known_options(problem_, model.fit, free));
  less.log_prior = log_prior(members.size(), hypotheses.candidates.size(), problem_.settings);
  return subsets_.emplace(members, std::move(less)).first->second;
}

const ModelFit& HeldOutGaps::fitted(const ModelFit& held) {
  const ModelFit* searched = posterior_.find(held.candidates);
  if (searched != nullptr && !searched->fit.by_slopes()) return *searched;
  const auto known = fitted_.find(held.candidates);
  if (known != fitted_.end()) return known->second;

  // By slopes alone a set is misjudged by more than what tells two apart.
  const ModelFit& before = searched != nullptr ? *searched : held;
  ModelFit model = before;
  std::vector<Vector> starts = {held.fit.p};
  if (searched != nullptr) starts.push_back(searched->fit.p);
  FitOptions options;
  options.scales = held.fit.scales;
  model.fit = fit_model(problem_, comparison_.whitening,
                        problem_.hypotheses.freed_by(held.candidates), starts, options);
  if (!model.fit.valid) model = before;
  return fitted_.emplace(held.candidates, std::move(model)).first->second;
}

const HeldOut& HeldOutGaps::of(const ModelFit& model) {
  const Key key{model.candidates, model.fit.free};
  const auto known = gaps_.find(key);
  if (known != gaps_.end()) return known->second;
  const bool none = model.candidates.empty() && model.fit.free == problem_.hypotheses.nuisances();
  const JudgedFit own = none ? none_ : judge_fit(problem_, comparison_, folds_, model.fit, open_);
  return gaps_.emplace(key, held_out(problem_, folds_, stated_, none_, own)).first->second;
}

}  // namespace jaculus::diagnosis
