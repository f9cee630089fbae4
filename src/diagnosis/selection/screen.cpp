#include "diagnosis/selection/screen.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "diagnosis/forward/sensitivities.h"
#include "diagnosis/selection/line_search.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kRidge = 1e-6;  // of columns that may be dependent

/// Columns at a step of the first parameter [its unit] and a share of the others' probing steps.
/// Nothing where a simulation fails.
std::optional<Matrix> columns_at(const Problem& problem, const Whitening& whitening,
                                 const Fit& base, const Candidate& candidate, double first_step,
                                 double others) {
  Matrix columns(whitening.rows, count_of(candidate.parameters));
  Vector p = base.simulated;
  std::vector<Vector> rows = base.rows;

  for (int k = 0; k < columns.cols(); ++k) {
    const int i = candidate.parameters[k];
    const FreeParameter& own = problem.hypotheses.parameters[i];
    const double step = k == 0 ? first_step : probe_step(own, p[i], others);
    const auto moved = difference_at(problem, whitening.alignments, p, rows, i, step);
    if (!moved) return {};
    columns.col(k) = whitening.apply(moved->rows) * (own.scale / step);
    if (k > 0) continue;

    // The others may do nothing before the first is switched on.
    p[i] += step;
    for (std::size_t d = 0; d < rows.size(); ++d) rows[d] += moved->rows[d];
  }

  return columns;
}

/// Columns at a share of the probing steps.
std::optional<Matrix> columns_of(const Problem& problem, const Whitening& whitening,
                                 const Fit& base, const Candidate& candidate, double share) {
  const int first = candidate.parameters.front();
  const double step =
      probe_step(problem.hypotheses.parameters[first], base.simulated[first], share);
  return columns_at(problem, whitening, base, candidate, step, share);
}

/// Whether an effect does at both strengths what its slope says.
bool proportional(const Matrix& small, const Matrix& full, const Settings& settings) {
  return (small - full).norm() < settings.same_slope * full.norm();
}

/// Whether the first parameter's slope holds as far as its estimate: between nominal and the step
/// that it was probed by, or by one more step to there, of this parameter alone.
bool holds_to_estimate(const Problem& problem, const Whitening& whitening, const Fit& base,
                       const Candidate& candidate, Probe& probe) {
  if (probe.estimate.size() == 0) return false;
  const int first = candidate.parameters.front();
  const FreeParameter& own = problem.hypotheses.parameters[first];
  const double value = base.simulated[first];
  const double step = own.moved(value, probe.estimate[0]) - value;
  const double share = step / probe_step(own, value, 1.0);
  if (share >= 0.0 && share <= 1.0) return true;
  if (!(std::abs(share) <= problem.settings.line_search_highest)) return false;

  ++probe.predictions;
  const auto moved =
      difference_at(problem, whitening.alignments, base.simulated, base.rows, first, step);
  if (!moved) return false;
  const Matrix there = whitening.apply(moved->rows) * (own.scale / moved->step);
  return proportional(probe.better().leftCols(1), there, problem.settings);
}

/// What screening knows of the base model.
struct Base {
  const Problem& problem;
  const Whitening& whitening;
  const Fit& fit;
  const Standing& standing;
};

/// The posterior of one more candidate's columns beside the base model's own, which come first.
ScaleEstimate with_columns(const Base& base, const Matrix& own) {
  const RandomEffects& random = base.whitening.random;
  const Columns& model = base.standing.model;
  const Products products = side_by_side(model.products, products_between(random, model.X, own),
                                         products_of(random, own));
  return followed_by(base.problem, random, products, base.fit.scales,
                     base.problem.settings.screening_scale_steps);
}

/// Raises the probe's score and estimate to what these columns reach; whether they do.
bool raise_score(const Base& base, const Candidate& candidate, const Matrix& own, Probe& probe) {
  const ScaleEstimate followed = with_columns(base, own);
  double gain = followed.evidence() - base.standing.log_evidence;
  Vector mean = followed.mean.tail(own.cols());
  for (Eigen::Index k = 0; k < own.cols(); ++k) {
    const FreeParameter& p = base.problem.hypotheses.parameters[candidate.parameters[k]];
    const double value = base.fit.p[candidate.parameters[k]];
    const Bounds range{(p.bounds.lower - value) / p.scale, (p.bounds.upper - value) / p.scale};
    if (range.contains(mean[k])) continue;
    mean[k] = std::clamp(mean[k], range.lower, range.upper);
    // On the wrong side of a boundary the first parameter can do nothing for the residual.
    if (k == 0 && mean[k] == 0.0) gain = -1.0;
  }

  if (gain <= probe.score) return false;
  probe.score = gain;
  probe.estimate = mean;
  return true;
}

}  // namespace

Probe probe_candidate(const Problem& problem, const Whitening& whitening, const Fit& base,
                      const Standing& standing, int c, Screening how, bool linear) {
  const Candidate& candidate = problem.hypotheses.candidates[c];
  const int first = candidate.parameters.front();
  Probe probe;
  if (std::find(base.free.begin(), base.free.end(), first) != base.free.end()) return probe;
  const Base known{problem, whitening, base, standing};

  const double influence = problem.settings.influence;
  const auto small = columns_of(problem, whitening, base, candidate, problem.settings.small_probe);
  const bool by_small = small && small->norm() > influence;
  const bool one = linear && by_small;
  const auto full = one ? std::nullopt : columns_of(problem, whitening, base, candidate, 1.0);
  const bool by_full = full && full->norm() > influence;
  probe.predictions = (one ? 1 : 2) * count_of(candidate.parameters);
  if (by_full) raise_score(known, candidate, *full, probe);
  if (by_small) probe.by_small = raise_score(known, candidate, *small, probe);
  probe.valid = by_full || by_small;
  probe.linear = one || (by_full && by_small && proportional(*small, *full, problem.settings));
  if (probe.valid) {
    probe.full = by_full ? *full : *small;
    probe.small = by_small ? *small : *full;
  }
  if (how != Screening::line_search) return probe;
  if (probe.linear &&
      (in_windows(problem) || holds_to_estimate(problem, whitening, base, candidate, probe)))
    return probe;

  const BestStep best = line_search(problem, whitening, base, standing, first);
  probe.predictions += best.predictions;
  probe.step = best.u;
  probe.score = std::max(probe.score, best.score);
  if (probe.valid || std::isnan(probe.step)) return probe;

  // Without influence up to its threshold: its columns are those of the step that helps.
  const FreeParameter& own = problem.hypotheses.parameters[first];
  const double value = base.simulated[first], step = own.moved(value, probe.step) - value;
  const double others = std::min(1.0, std::abs(step / own.usual_step()));
  const auto there = columns_at(problem, whitening, base, candidate, step, others);
  probe.predictions += count_of(candidate.parameters);
  probe.valid = there.has_value();
  if (there) probe.full = probe.small = *there;
  return probe;
}

std::vector<Probe> screen(const Problem& problem, const Whitening& whitening, const Fit& base,
                          Screening how, const std::vector<Probe>* before) {
  std::vector<Probe> probes(problem.hypotheses.candidates.size());
  const Standing standing = standing_of(problem, whitening, base);
  tbb::parallel_for(0, count_of(probes), [&](int c) {
    const bool linear = before != nullptr && (*before)[c].linear;
    probes[c] = probe_candidate(problem, whitening, base, standing, c, how, linear);
  });
  return probes;
}

std::vector<Vector> fit_starts(const Problem& problem, const Vector& base, int c,
                               const Probe& probe) {
  const std::vector<int>& parameters = problem.hypotheses.candidates[c].parameters;
  Vector estimated = base, probed = base;
  for (int k = 0; k < count_of(parameters); ++k) {
    const int i = parameters[k];
    const FreeParameter& p = problem.hypotheses.parameters[i];
    const double step = p.usual_step();
    const double u = probe.estimate.size() > 0 ? probe.estimate[k] : 0.0;

    estimated[i] = p.moved(base[i], u);
    if (k == 0 && std::abs(u * p.scale) < problem.settings.off_nominal * std::abs(step))
      estimated[i] = base[i] + problem.settings.from_nominal * step;

    const bool downwards = k == 0 && u < 0.0;
    const double two_sided = downwards ? -std::abs(step) : std::abs(step);
    const double move = p.one_sided() ? step : two_sided;
    probed[i] = std::clamp(base[i] + move, p.bounds.lower, p.bounds.upper);
  }
  std::vector<Vector> starts = {estimated, probed};
  if (!std::isnan(probe.step)) {
    starts.insert(starts.begin() + 1, base);
    const int first = parameters.front();
    starts[1][first] += probe.step * problem.hypotheses.parameters[first].scale;
  }

  return starts;
}

double unexplained_energy(const RandomEffects& random, const Vector& scales,
                          const Vector& signature, const Matrix& others, Eigen::Index with_prior) {
  Matrix X(signature.size(), 1 + others.cols());
  X << signature, others;
  return unexplained_energy(random, scales, products_of(random, X), with_prior);
}

double unexplained_energy(const RandomEffects& random, const Vector& scales,
                          const Products& columns, Eigen::Index with_prior) {
  const Matrix gram = weigh(random, columns, scales).gram;
  const Eigen::Index n = gram.cols() - 1;
  if (n == 0) return gram(0, 0);

  Matrix A = gram.bottomRightCorner(n, n);
  A.diagonal().array() += kRidge;
  A.diagonal().head(with_prior).array() += 1.0;
  const Vector b = gram.col(0).tail(n);
  return gram(0, 0) - b.dot(A.llt().solve(b));
}

}  // namespace jaculus::diagnosis
