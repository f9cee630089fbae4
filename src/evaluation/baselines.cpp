#include "evaluation/baselines.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "jaculus/diagnosis/forward.h"
#include "jaculus/diagnosis/screen.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::evaluation {
namespace {

/// Mean square of whitened residuals under which a baseline says "none": 1 is noise alone.
constexpr double kNoGap = 1.3;
constexpr int kTuningSteps = 40;

struct Ready {
  DiagnosisProblem problem;
  EvidenceSpace space;
  Fit base;  ///< nominal, nuisances fitted
  std::string insufficient;
};

bool prepare(const Dataset& dataset, Ready& ready) {
  DiagnosisProblem& problem = ready.problem;
  problem.observations = observe({dataset}, {dataset_robot(dataset).planar});
  if (problem.observations.conditions.empty() || !problem.observations.insufficient.empty()) return false;
  std::vector<const Effect*> effects;
  for (const Effect& effect : effect_catalogue()) effects.push_back(&effect);
  const PlantForward forward = plant_forward(problem.observations, effects);
  problem.hypotheses = forward.hypotheses;
  problem.forward = forward.predict;
  const Linearisation about = linearise(problem, problem.hypotheses.nominal());
  if (!about.at_p.valid) return false;
  ready.space = evidence_space(problem, about);
  ready.base = fit_model(problem, ready.space, problem.hypotheses.nuisances, {problem.hypotheses.nominal()});
  return ready.base.valid && ready.space.rows > 0;
}

/// An answer that ranks candidates by `value`, larger is better; NaN is last.
CaseAnswer answer_by(const Ready& ready, const std::vector<double>& value) {
  CaseAnswer answer;
  const auto better = [&](int a, int b) {
    const double x = value[static_cast<std::size_t>(a)], y = value[static_cast<std::size_t>(b)];
    return !std::isnan(x) && (std::isnan(y) || x > y);
  };
  std::vector<int> order(value.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), better);
  const auto& candidates = ready.problem.hypotheses.candidates;
  for (const Candidate& c : candidates) answer.ranking[c.name] = 0.0;
  const bool gap = ready.base.chi2 > kNoGap * ready.space.rows;
  answer.verdict = !gap || order.empty() ? "none" : "effect";
  if (answer.verdict == "effect")
    answer.effects.push_back({candidates[static_cast<std::size_t>(order[0])].name, 0, {}, {}});
  return answer;
}

CaseAnswer lowest_training_error(const Ready& ready) {
  const Hypotheses& hypotheses = ready.problem.hypotheses;
  std::vector<double> value;
  for (std::size_t i = 0; i < hypotheses.candidates.size(); ++i) {
    const Candidate& c = hypotheses.candidates[i];
    Vector probed = ready.base.p;
    for (std::size_t k = 0; k < c.parameters.size(); ++k) probed[c.parameters[k]] = c.effect->parameters[k].probed();
    const Fit fit = fit_model(ready.problem, ready.space, hypotheses.freed_by({static_cast<int>(i)}), {probed}, {4});
    value.push_back(fit.valid ? -fit.chi2 : kNaN);
  }
  return answer_by(ready, value);
}

CaseAnswer correlation(const Ready& ready, const std::vector<Probe>& probes) {
  std::vector<double> value;
  const Vector& r = ready.base.residual;
  for (const Probe& probe : probes) {
    double best = kNaN;
    for (Eigen::Index k = 0; probe.valid && k < probe.full.cols(); ++k) {
      const double both = probe.full.col(k).norm() * r.norm();
      if (both > 0.0) best = std::fmax(best, std::abs(probe.full.col(k).dot(r)) / both);
    }
    value.push_back(best);
  }
  return answer_by(ready, value);
}

/// dr/du of `free` at the base model: its own from its fit, a candidate's from its probes (of its probing step where the small one does
/// nothing, as below a threshold).
Matrix slopes(const Ready& ready, const std::vector<Probe>& probes, const std::vector<int>& free) {
  std::map<int, Vector> of;
  for (std::size_t i = 0; i < ready.base.free.size(); ++i)
    of[ready.base.free[i]] = ready.base.jacobian.col(static_cast<Eigen::Index>(i));
  for (std::size_t c = 0; c < probes.size(); ++c) {
    const auto& parameters = ready.problem.hypotheses.candidates[c].parameters;
    for (std::size_t k = 0; probes[c].valid && k < parameters.size(); ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      const bool threshold = probes[c].small.col(column).norm() == 0.0;
      of[parameters[k]] = -(threshold ? probes[c].full : probes[c].small).col(column);
    }
  }
  Matrix J = Matrix::Zero(ready.space.rows, static_cast<Eigen::Index>(free.size()));
  for (std::size_t i = 0; i < free.size(); ++i)
    if (of.count(free[i]) != 0) J.col(static_cast<Eigen::Index>(i)) = of[free[i]];
  return J;
}

/// A local optimum of the probability of u, every parameter at once, from the base model on: Levenberg-Marquardt within bounds on |r|^2 + |u|^2, whose slopes
/// follow by Broyden's update; sixty differences a step with all effects on at once would take minutes.
Vector tuned(const Ready& ready, const std::vector<Probe>& probes, const std::vector<int>& free) {
  const Hypotheses& hypotheses = ready.problem.hypotheses;
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
    const Fit next = evaluate_model(ready.problem, ready.space, wanted);
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

CaseAnswer tune_everything(const Ready& ready, const std::vector<Probe>& probes) {
  const Hypotheses& hypotheses = ready.problem.hypotheses;
  std::vector<int> all(hypotheses.candidates.size());
  std::iota(all.begin(), all.end(), 0);
  const std::vector<int> free = hypotheses.freed_by(all);
  const Vector p = hypotheses.unscaled(free, tuned(ready, probes, free), ready.base.p);
  std::vector<double> value;
  for (const Candidate& c : hypotheses.candidates) {
    double moved = 0.0;
    for (const int i : c.parameters) {
      const FreeParameter& parameter = hypotheses.parameters[static_cast<std::size_t>(i)];
      moved = std::max(moved, std::abs(p[i] - parameter.nominal) / parameter.scale);
    }
    value.push_back(moved);
  }
  return answer_by(ready, value);
}

}  // namespace

const std::vector<std::string>& baseline_names() {
  static const std::vector<std::string> names = {"lowest training error", "correlation", "tune everything"};
  return names;
}

std::vector<CaseAnswer> baseline_answers(const std::filesystem::path& dataset) {
  Ready ready;
  if (!prepare(read_dataset(dataset), ready)) {
    CaseAnswer insufficient;
    insufficient.verdict = "insufficient";
    return std::vector<CaseAnswer>(baseline_names().size(), insufficient);
  }
  const std::vector<Probe> probes = screen(ready.problem, ready.space, ready.base);
  return {lowest_training_error(ready), correlation(ready, probes), tune_everything(ready, probes)};
}

}  // namespace jaculus::evaluation
