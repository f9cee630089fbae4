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

/// Columns at a share of the probing steps; beyond one it is the first parameter's alone. Nothing
/// where a simulation fails.
std::optional<Matrix> columns_of(const Problem& problem, const Whitening& whitening,
                                 const Fit& base, const Candidate& candidate, double share) {
  Matrix columns(whitening.rows, count_of(candidate.parameters));
  Vector p = base.p;
  std::vector<Vector> rows = base.rows;

  for (int k = 0; k < columns.cols(); ++k) {
    const int i = candidate.parameters[k];
    const FreeParameter& own = problem.hypotheses.parameters[i];
    const double step = probe_step(own, p[i], k == 0 ? share : std::min(1.0, std::abs(share)));
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

/// Raises the probe's score and estimate to what these columns reach.
void raise_score(const Problem& problem, const Fit& base, const Candidate& candidate,
                 const Matrix& own, Probe& probe) {
  const double alone = linear_evidence(-base.jacobian, base.residual).log_evidence;
  Matrix G(own.rows(), own.cols() + base.jacobian.cols());
  G << own, -base.jacobian;
  LinearEvidence linear = linear_evidence(G, base.residual);

  for (Eigen::Index k = 0; k < own.cols(); ++k) {
    const FreeParameter& p = problem.hypotheses.parameters[candidate.parameters[k]];
    const double value = base.p[candidate.parameters[k]];
    const Bounds range{(p.bounds.lower - value) / p.scale, (p.bounds.upper - value) / p.scale};
    if (range.contains(linear.mean[k])) continue;
    linear.mean[k] = std::clamp(linear.mean[k], range.lower, range.upper);
    // On the wrong side of a boundary the first parameter can do nothing for the residual.
    if (k == 0 && linear.mean[k] == 0.0) linear.log_evidence = alone - 1.0;
  }

  if (linear.log_evidence - alone <= probe.score) return;
  probe.score = linear.log_evidence - alone;
  probe.estimate = linear.mean.head(own.cols());
}

}  // namespace

Probe probe_candidate(const Problem& problem, const Whitening& whitening, const Fit& base, int c,
                      Screening how) {
  const Candidate& candidate = problem.hypotheses.candidates[c];
  const int first = candidate.parameters.front();
  Probe probe;
  if (std::find(base.free.begin(), base.free.end(), first) != base.free.end()) return probe;

  const double influence = problem.settings.influence;
  const auto full = columns_of(problem, whitening, base, candidate, 1.0);
  const auto small = columns_of(problem, whitening, base, candidate, problem.settings.small_probe);
  probe.predictions = 2 * count_of(candidate.parameters);
  const bool by_full = full && full->norm() > influence;
  const bool by_small = small && small->norm() > influence;
  if (by_full) raise_score(problem, base, candidate, *full, probe);
  if (by_small) raise_score(problem, base, candidate, *small, probe);
  probe.valid = by_full || by_small;
  if (probe.valid) {
    probe.full = by_full ? *full : *small;
    probe.small = by_small ? *small : *full;
  }
  if (how != Screening::line_search) return probe;

  const BestStep best = line_search(problem, whitening, base, first);
  probe.predictions += best.predictions;
  probe.step = best.u;
  probe.score = std::max(probe.score, best.score);
  if (probe.valid || std::isnan(probe.step)) return probe;

  // Without influence up to its threshold: its columns are those of the step that helps.
  const FreeParameter& own = problem.hypotheses.parameters[first];
  const double share = probe.step * own.scale / own.usual_step();
  const auto there = columns_of(problem, whitening, base, candidate, share);
  probe.predictions += count_of(candidate.parameters);
  probe.valid = there.has_value();
  if (there) probe.full = probe.small = *there;
  return probe;
}

std::vector<Probe> screen(const Problem& problem, const Whitening& whitening, const Fit& base,
                          Screening how) {
  std::vector<Probe> probes(problem.hypotheses.candidates.size());
  tbb::parallel_for(0, count_of(probes),
                    [&](int c) { probes[c] = probe_candidate(problem, whitening, base, c, how); });
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

    estimated[i] = std::clamp(base[i] + u * p.scale, p.bounds.lower, p.bounds.upper);
    if (k == 0 && std::abs(u * p.scale) < problem.settings.off_nominal * std::abs(step))
      estimated[i] = base[i] + problem.settings.from_nominal * step;

    const bool downwards = k == 0 && u < 0.0;
    const double two_sided = downwards ? -std::abs(step) : std::abs(step);
    const double move = p.one_sided() ? step : two_sided;
    probed[i] = std::clamp(base[i] + move, p.bounds.lower, p.bounds.upper);
  }
  if (std::isnan(probe.step)) return {estimated, probed};

  Vector searched = base;
  const int first = parameters.front();
  searched[first] += probe.step * problem.hypotheses.parameters[first].scale;
  return {estimated, searched, probed};
}

double unexplained_energy(const Vector& signature, const Matrix& own) {
  if (own.cols() == 0) return signature.squaredNorm();
  const Matrix A = own.transpose() * own + kRidge * Matrix::Identity(own.cols(), own.cols());
  const Vector u = A.llt().solve(own.transpose() * signature);
  return (signature - own * u).squaredNorm();
}

}  // namespace jaculus::diagnosis
