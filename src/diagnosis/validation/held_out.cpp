#include "diagnosis/validation/held_out.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "diagnosis/forward/sensitivities.h"
#include "diagnosis/noise/random_weights.h"
#include "diagnosis/validation/fold_interval.h"
#include "diagnosis/validation/folds.h"
#include "diagnosis/validation/judge.h"

namespace jaculus::diagnosis {
namespace {

/// A fitted model with its rows' slopes: what all folds share.
struct Tangent {
  const Fit& fit;
  std::vector<std::vector<Vector>> slopes;  ///< d(rows)/du, a free parameter and a dataset each
};

/// Nothing where the simulation fails next to the fit.
std::optional<Tangent> tangent_of(const Problem& problem, const Whitening& whitening,
                                  const Fit& fit) {
  Tangent tangent{fit, {}};
  for (int i = 0; i < count_of(fit.free); ++i) {
    const double scale = problem.hypotheses.parameters[fit.free[i]].scale;
    const double step = difference_step(fit.jacobian.col(i).norm(), problem.settings);
    auto moved =
        difference(problem, whitening.alignments, fit.p, fit.rows, fit.free[i], step * scale);
    if (!moved) return {};
    for (Vector& own : moved->rows) own *= scale / moved->step;
    tangent.slopes.push_back(std::move(moved->rows));
  }
  return tangent;
}

/// Gauss-Newton on the rows of a fold with the slopes of the whole, from where the whole was
/// fitted: folds differ little. Returns the predicted rows at the best point reached.
std::vector<Vector> refitted_rows(const Problem& problem, const Whitening& fold,
                                  const Tangent& tangent) {
  const std::vector<int>& free = tangent.fit.free;
  const Eigen::Index size = count_of(free);
  std::vector<Vector> best = tangent.fit.rows, rows = best;
  if (size == 0) return best;

  Matrix J(fold.rows, size);
  for (Eigen::Index i = 0; i < size; ++i) J.col(i) = -fold.apply(tangent.slopes[i]);
  const RandomEffects beside = beside_columns(fold.random, J);
  const RandomWeights weights(beside, tangent.fit.scales);
  const Matrix root = weights.stacked(J);
  const Eigen::LLT<Matrix> curvature(root.transpose() * root + Matrix::Identity(size, size));
  Vector p = tangent.fit.p;
  double least = kInfinity;
  for (int step = 0;; ++step) {
    Vector u = problem.hypotheses.scaled(free, p);
    const Vector r = weights.stacked(fold.residual(rows));
    const double cost = r.squaredNorm() + u.squaredNorm();
    if (cost < least) best = rows;
    if (cost >= least || step == problem.settings.refit_steps) return best;

    least = cost;
    u -= curvature.solve(root.transpose() * r + u);
    p = problem.hypotheses.unscaled(free, u, p);
    const PredictionSet there = predict_all(problem, p);
    if (!there.valid) return best;
    rows = rows_of(problem, fold.alignments, there);
  }
}

struct FoldErrors {
  bool valid = false;
  Errors before, after;
};

FoldErrors judge_fold(const Problem& problem, const Comparison& comparison, const SegmentMask& mask,
                      const Tangent& none, const Tangent& model,
                      const std::vector<Vector>& granted) {
  FoldErrors result{false, Errors(problem), Errors(problem)};
  const Whitening fold = whitening_of(problem, comparison.noise, mask);
  if (fold.rows == 0) return result;

  for (const auto& [tangent, errors] :
       {std::pair(&none, &result.before), std::pair(&model, &result.after)}) {
    const std::vector<Vector> predicted = refitted_rows(problem, fold, *tangent);
    for (int d = 0; d < count_of(mask); ++d) {
      const ObservedDataset& observed = problem.observations.datasets[d];
      const auto trained = static_cast<double>(std::count(mask[d].begin(), mask[d].end(), true));
      const bool alone = observed.measured_input || trained == 0.0;
      const Judge judge{observed,
                        comparison.noise.datasets[d],
                        comparison.whitening.datasets[d],
                        problem.settings,
                        granted[d],
                        alone ? kInfinity : trained};
      const Vector residual =
          measured_rows(observed, comparison.noise.alignments[d]) - predicted[d];
      for (int s = 0; s < count_of(mask[d]); ++s)
        if (!mask[d][s]) judge.judge(d, s, residual, *errors);
    }
  }

  result.valid = true;
  return result;
}

double shrink_of(double before, double after) { return 1.0 - (after - 1.0) / (before - 1.0); }

/// Student's t over the folds about `shrink`.
Bounds shrink_interval(const std::vector<FoldErrors>& folds, double shrink, double least_gap) {
  std::vector<double> shrinks;
  for (const FoldErrors& fold : folds) {
    const double before = fold.before.overall(), after = fold.after.overall();
    if (fold.valid && before > least_gap && std::isfinite(after))
      shrinks.push_back(shrink_of(before, after));
  }
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

std::vector<Vector> tolerance_variances(const Problem& problem, const Comparison& comparison) {
  std::vector<Vector> variances;
  for (int d = 0; d < count_of(problem.observations.datasets); ++d) {
    const ObservedDataset& observed = problem.observations.datasets[d];
    variances.emplace_back(Vector::Zero(observed.rows()));
    if (comparison.noise.random.tolerances.empty()) continue;

    Vector& own = variances.back();
    const Judge judge{observed, comparison.noise.datasets[d], comparison.whitening.datasets[d],
                      problem.settings, own};
    for (int s = 0; s < count_of(observed.segments); ++s)
      judge.add_granted(s, comparison.noise.random.tolerances[d], own);
  }
  return variances;
}

HeldOut held_out(const Problem& problem, const Comparison& comparison, const Fit& none,
                 const Fit& model, const std::vector<Vector>& granted) {
  HeldOut out;
  const Folds folds = folds_of(problem.observations, problem.settings);
  out.over = folds.over;
  if (folds.masks.empty()) return out;
  const auto of_none = tangent_of(problem, comparison.whitening, none);
  const auto of_model = tangent_of(problem, comparison.whitening, model);
  if (!of_none || !of_model) return out;

  std::vector<FoldErrors> judged(folds.masks.size(), {false, Errors(problem), Errors(problem)});
  tbb::parallel_for(0, count_of(judged), [&](int f) {
    judged[f] = judge_fold(problem, comparison, folds.masks[f], *of_none, *of_model, granted);
  });
  Errors before(problem), after(problem);
  for (const FoldErrors& fold : judged) {
    out.by_fold.push_back({});
    if (!fold.valid) continue;
    out.by_fold.back() = {fold.before.overall(), fold.after.overall()};
    ++out.folds;
    before.add(fold.before);
    after.add(fold.after);
  }
  if (out.folds == 0) return out;

  out.valid = true;
  out.before = before.overall();
  out.after = after.overall();
  out.beyond_before = before.overall_beyond();
  out.beyond_after = after.overall_beyond();
  out.log_gain = after.log_density - before.log_density;
  if (out.before >= problem.settings.plain_gap) {
    out.shrink = shrink_of(out.before, out.after);
    out.ci95 = shrink_interval(judged, *out.shrink, problem.settings.gap_of_fold);
  }
  out.channels = by_channel(problem, before, after);
  return out;
}

const ModelFit& HeldOutGaps::subset(const ModelFit& model, const std::vector<int>& members) {
  if (members == model.candidates) return model;
  if (const ModelFit* known = posterior_.find(members)) return *known;
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
  FitOptions options;
  options.scales = model.fit.scales;
  less.fit = fit_model(problem_, comparison_.whitening, hypotheses.freed_by(members), {p}, options);
  less.log_prior = log_prior(members.size(), hypotheses.candidates.size(), problem_.settings);
  return subsets_.emplace(members, std::move(less)).first->second;
}

const HeldOut& HeldOutGaps::of(const ModelFit& model) {
  const auto known = gaps_.find(model.candidates);
  if (known != gaps_.end()) return known->second;
  return gaps_
      .emplace(model.candidates, held_out(problem_, comparison_, none_, model.fit, granted_))
      .first->second;
}

}  // namespace jaculus::diagnosis
