#include "evaluation/baselines.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "jaculus/diagnosis/forward.h"
#include "jaculus/diagnosis/screen.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::evaluation {
namespace {

/// Mean square of whitened residuals under which a baseline says "none": 1 is noise alone.
constexpr double kNoGap = 1.3;

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

CaseAnswer correlation(const Ready& ready) {
  std::vector<double> value;
  const Vector& r = ready.base.residual;
  for (const Probe& probe : screen(ready.problem, ready.space, ready.base)) {
    double best = kNaN;
    for (Eigen::Index k = 0; probe.valid && k < probe.full.cols(); ++k) {
      const double both = probe.full.col(k).norm() * r.norm();
      if (both > 0.0) best = std::fmax(best, std::abs(probe.full.col(k).dot(r)) / both);
    }
    value.push_back(best);
  }
  return answer_by(ready, value);
}

CaseAnswer tune_everything(const Ready& ready) {
  const Hypotheses& hypotheses = ready.problem.hypotheses;
  std::vector<int> all(hypotheses.candidates.size());
  std::iota(all.begin(), all.end(), 0);
  const Fit fit = fit_model(ready.problem, ready.space, hypotheses.freed_by(all), {ready.base.p}, {6});
  std::vector<double> value;
  for (const Candidate& c : hypotheses.candidates) {
    double moved = fit.valid ? 0.0 : kNaN;
    for (const int p : c.parameters) {
      const FreeParameter& parameter = hypotheses.parameters[static_cast<std::size_t>(p)];
      if (fit.valid) moved = std::max(moved, std::abs(fit.p[p] - parameter.nominal) / parameter.scale);
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
  return {lowest_training_error(ready), correlation(ready), tune_everything(ready)};
}

}  // namespace jaculus::evaluation
