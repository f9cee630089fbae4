#include "evaluation/baseline_problem.h"

#include <algorithm>
#include <cmath>

namespace jaculus::evaluation {
namespace {

/// Mean square of whitened residuals under which a baseline says "none": 1 is noise alone.
constexpr double kNoGap = 1.3;

}  // namespace

bool BaselineProblem::has_gap() const { return base.chi2 > kNoGap * whitening.rows; }

std::optional<BaselineProblem> baseline_problem(const std::vector<trajectory::Dataset>& datasets) {
  const diagnosis::BuiltProblem built = diagnosis::build_problem(datasets, {});
  if (!built.forward) return {};
  const diagnosis::Problem& problem = *built.problem;
  const Vector nominal = problem.hypotheses.nominal();
  diagnosis::NoiseModel noise = diagnosis::estimate_noise(problem, nominal);
  if (!noise.valid()) return {};

  BaselineProblem ready{built.problem, *built.forward, std::move(noise), {}, {}};
  ready.whitening = diagnosis::whitening_of(problem, ready.noise);
  ready.base = fit_model(problem, ready.whitening, problem.hypotheses.gains, {nominal});
  if (!ready.base.valid || ready.whitening.rows == 0) return {};
  if (!problem.hypotheses.gains.empty()) {
    diagnosis::NoiseModel again =
        diagnosis::estimate_noise(problem, ready.base.p, ready.noise.alignments);
    if (again.valid()) ready.noise = std::move(again);
  }
  return ready;
}

Prediction statement(const BaselineProblem& ready, const std::string& effect) {
  using diagnosis::Verdict;
  Prediction prediction;
  for (const diagnosis::Candidate& c : ready.problem->hypotheses.candidates)
    prediction.ranking[c.name] = 0.0;
  for (const Verdict verdict : {Verdict::none, Verdict::unexplained})
    prediction.ranking[to_text(verdict)] = 0.0;

  const bool none = effect == to_text(Verdict::none);
  const bool named = !none && effect != to_text(Verdict::unexplained);
  prediction.verdict = none ? Verdict::none : named ? Verdict::effect : Verdict::unexplained;
  if (named) prediction.effects.push_back({effect, 0, {}, {}});
  return prediction;
}

Prediction answer_by(const BaselineProblem& ready, const std::vector<double>& value) {
  const auto& candidates = ready.problem->hypotheses.candidates;
  int best = -1;
  for (int i = 0; i < count_of(value); ++i)
    if (!std::isnan(value[i]) && (best < 0 || value[i] > value[best])) best = i;
  const bool named = ready.has_gap() && best >= 0;
  return statement(ready, named ? candidates[best].name : to_text(diagnosis::Verdict::none));
}

}  // namespace jaculus::evaluation
