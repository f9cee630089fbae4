#include "evaluation/baselines.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <optional>

#include "diagnosis/build_problem.h"
#include "diagnosis/selection/screen.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::evaluation {
namespace {

/// Mean square of whitened residuals under which a baseline says "none": 1 is noise alone.
constexpr double kNoGap = 1.3;
constexpr int kTuningSteps = 40;

struct Ready {
  std::shared_ptr<const diagnosis::Problem> problem;
  diagnosis::Whitening whitening;
  diagnosis::Fit base;  ///< nominal, nuisances fitted
};

/// Nothing where the data are insufficient or the nominal model can't be fitted.
std::optional<Ready> prepare(const trajectory::Dataset& dataset) {
  const diagnosis::BuiltProblem built = diagnosis::build_problem({dataset}, {});
  if (!built.forward) return {};
  const diagnosis::Problem& problem = *built.problem;
  const Vector nominal = problem.hypotheses.nominal();
  const diagnosis::NoiseModel noise = diagnosis::estimate_noise(problem, nominal);
  if (!noise.valid()) return {};

  Ready ready{built.problem, diagnosis::whitening_of(problem, noise), {}};
  ready.base = fit_model(problem, ready.whitening, problem.hypotheses.nuisances, {nominal});
  if (!ready.base.valid || ready.whitening.rows == 0) return {};
  return ready;
}

/// A prediction that ranks candidates by `value`, larger is better; NaN is last.
Prediction answer_by(const Ready& ready, const std::vector<double>& value) {
  Prediction prediction;
  const auto better = [&](int a, int b) {
    const double x = value[a], y = value[b];
    return !std::isnan(x) && (std::isnan(y) || x > y);
  };
  std::vector<int> order(value.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), better);
  const auto& candidates = ready.problem->hypotheses.candidates;
  for (const diagnosis::Candidate& c : candidates) prediction.ranking[c.name] = 0.0;
  const bool gap = ready.base.chi2 > kNoGap * ready.whitening.rows;
  const bool named = gap && !order.empty();
  prediction.verdict = named ? diagnosis::Verdict::effect : diagnosis::Verdict::none;
  if (named) prediction.effects.push_back({candidates[order[0]].name, 0, {}, {}});
  return prediction;
}

Prediction lowest_training_error(const Ready& ready) {
  const diagnosis::Hypotheses& hypotheses = ready.problem->hypotheses;
  std::vector<double> value;
  for (int i = 0; i < count_of(hypotheses.candidates); ++i) {
    const diagnosis::Candidate& c = hypotheses.candidates[i];
    Vector probed = ready.base.p;
    for (std::size_t k = 0; k < c.parameters.size(); ++k)
      probed[c.parameters[k]] = c.effect->parameters[k].probed();
    const diagnosis::Fit fit = diagnosis::fit_model(*ready.problem, ready.whitening,
                                                    hypotheses.freed_by({i}), {probed}, {4});
    value.push_back(fit.valid ? -fit.chi2 : kNaN);
  }
  return answer_by(ready, value);
}

Prediction correlation(const Ready& ready, const std::vector<diagnosis::Probe>& probes) {
  std::vector<double> value;
  const Vector& r = ready.base.residual;
  for (const diagnosis::Probe& probe : probes) {
    double best = kNaN;
    for (Eigen::Index k = 0; probe.valid && k < probe.full.cols(); ++k) {
      const double both = probe.full.col(k).norm() * r.norm();
      if (both > 0.0) best = std::fmax(best, std::abs(probe.full.col(k).dot(r)) / both);
    }
    value.push_back(best);
  }
  return answer_by(ready, value);
}

/// dr/du of `free` at the base model: its own from its fit, a candidate's from its probes (of its
/// probing step where the small one does nothing, as below a threshold).
Matrix slopes(const Ready& ready, const std::vector<diagnosis::Probe>& probes,
              const std::vector<int>& free) {
  std::map<int, Vector> of;
  for (int i = 0; i < count_of(ready.base.free); ++i)
    of[ready.base.free[i]] = ready.base.jacobian.col(i);
  for (std::size_t c = 0; c < probes.size(); ++c) {
    const auto& parameters = ready.problem->hypotheses.candidates[c].parameters;
    for (int k = 0; probes[c].valid && k < count_of(parameters); ++k) {
      const bool threshold = probes[c].small.col(k).norm() == 0.0;
      of[parameters[k]] = -(threshold ? probes[c].full : probes[c].small).col(k);
    }
  }
  Matrix J = Matrix::Zero(ready.whitening.rows, free.size());
  for (int i = 0; i < count_of(free); ++i)
    if (of.count(free[i]) != 0) J.col(i) = of[free[i]];
  return J;
}

/// A local optimum of the probability of u, every parameter at once, from the base model on:
/// Levenberg-Marquardt within bounds on |r|^2 + |u|^2, whose slopes follow by Broyden's update;
/// sixty differences a step with all effects on at once would take minutes.
Vector tuned(const Ready& ready, const std::vector<diagnosis::Probe>& probes,
             const std::vector<int>& free) {
  const diagnosis::Hypotheses& hypotheses = ready.problem->hypotheses;
  Matrix J = slopes(ready, probes, free);

  Vector u = hypotheses.scaled(free, ready.base.p), r = ready.base.residual;
  double damping = 1e-3;
  for (int k = 0; k < kTuningSteps; ++k) {
    Matrix H = J.transpose() * J;
    H.diagonal().array() += 1.0;
    const Vector slope = J.transpose() * r + u;
    H.diagonal() *= 1.0 + damping;
    const Vector wanted = hypotheses.unscaled(free, u - H.ldlt().solve(slope), ready.base.p);
    const Vector there = hypotheses.scaled(free, wanted);
    const Vector moved = there - u;
    if (moved.squaredNorm() < 1e-12) break;
    const diagnosis::Fit next = diagnosis::evaluate_model(*ready.problem, ready.whitening, wanted);
    damping *= 4.0;
    if (!next.valid) continue;
    J += (next.residual - r - J * moved) * moved.transpose() / moved.squaredNorm();
    if (next.chi2 + there.squaredNorm() >= r.squaredNorm() + u.squaredNorm()) continue;
    u = there;
    r = next.residual;
    damping /= 12.0;
  }

  return u;
}

Prediction tune_everything(const Ready& ready, const std::vector<diagnosis::Probe>& probes) {
  const diagnosis::Hypotheses& hypotheses = ready.problem->hypotheses;
  std::vector<int> all(hypotheses.candidates.size());
  std::iota(all.begin(), all.end(), 0);
  const std::vector<int> free = hypotheses.freed_by(all);
  const Vector p = hypotheses.unscaled(free, tuned(ready, probes, free), ready.base.p);
  std::vector<double> value;
  for (const diagnosis::Candidate& c : hypotheses.candidates) {
    double moved = 0.0;
    for (const int i : c.parameters) {
      const diagnosis::FreeParameter& parameter = hypotheses.parameters[i];
      moved = std::max(moved, std::abs(p[i] - parameter.nominal) / parameter.scale);
    }
    value.push_back(moved);
  }
  return answer_by(ready, value);
}

}  // namespace

const std::vector<std::string>& baseline_names() {
  static const std::vector<std::string> names = {"lowest training error", "correlation",
                                                 "tune everything"};
  return names;
}

std::vector<Prediction> baseline_answers(const std::filesystem::path& dataset) {
  const std::optional<Ready> prepared = prepare(trajectory::read_dataset(dataset));
  if (!prepared) {
    Prediction insufficient;
    insufficient.verdict = diagnosis::Verdict::insufficient;
    return std::vector<Prediction>(baseline_names().size(), insufficient);
  }

  const Ready& ready = *prepared;
  const std::vector<diagnosis::Probe> probes =
      diagnosis::screen(*ready.problem, ready.whitening, ready.base);
  return {lowest_training_error(ready), correlation(ready, probes), tune_everything(ready, probes)};
}

}  // namespace jaculus::evaluation
