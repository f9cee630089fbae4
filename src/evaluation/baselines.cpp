#include "evaluation/baselines.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "evaluation/baseline_problem.h"
#include "evaluation/residual_torque.h"
#include "evaluation/ridge.h"
#include "evaluation/sparse_regression.h"

namespace jaculus::evaluation {
namespace {

using diagnosis::Verdict;

constexpr const char* kLowestError = "lowest training error";
constexpr int kIterations = 12;  ///< of a candidate's least squares

/// Softmax of -BIC/2 over candidates and none, as the prediction's ranking.
void rank_by_bic(const BaselineProblem& ready, double none, const std::vector<double>& chi2,
                 Prediction& prediction) {
  const auto& candidates = ready.problem->hypotheses.candidates;
  const double per_parameter = std::log(static_cast<double>(ready.whitening.rows));
  std::map<std::string, double> score = {{to_text(Verdict::none), none}};
  for (int i = 0; i < count_of(candidates); ++i)
    if (!std::isnan(chi2[i]))
      score[candidates[i].name] = chi2[i] + per_parameter * count_of(candidates[i].parameters);

  double least = kInfinity, sum = 0.0;
  for (const auto& [name, bic] : score) least = std::min(least, bic);
  for (auto& [name, bic] : score) sum += bic = std::exp(-0.5 * (bic - least));
  for (const auto& [name, weight] : score) prediction.ranking[name] = weight / sum;
  for (NamedEffect& effect : prediction.effects)
    effect.probability = prediction.ranking.at(effect.name);
}

/// Tolerances by their slopes about the base model: told anew for each of some ninety effects they
/// were nine tenths of the time of all baselines.
Prediction lowest_training_error(const BaselineProblem& ready) {
  const diagnosis::Hypotheses& hypotheses = ready.problem->hypotheses;
  const diagnosis::LinearNuisances nuisances =
      diagnosis::linear_nuisances(*ready.problem, ready.whitening, ready.base.p);
  diagnosis::FitOptions options;
  options.iterations = kIterations;
  options.by_slopes = &nuisances;
  options.renew = false;
  const auto error_of = [&](const std::vector<int>& members, const Vector& start) {
    const diagnosis::Fit fit = diagnosis::fit_model(*ready.problem, ready.whitening,
                                                    hypotheses.freed_by(members), {start}, options);
    return fit.valid ? fit.chi2 : kNaN;
  };

  std::vector<double> value, chi2;
  for (int i = 0; i < count_of(hypotheses.candidates); ++i) {
    const diagnosis::Candidate& c = hypotheses.candidates[i];
    Vector probed = ready.base.p;
    for (int k = 0; k < count_of(c.parameters); ++k)
      probed[c.parameters[k]] = c.effect->parameters[k].probed();
    chi2.push_back(error_of({i}, probed));
    value.push_back(-chi2.back());
  }
  const double none = error_of({}, ready.base.p);
  Prediction prediction = answer_by(ready, value);
  rank_by_bic(ready, std::isnan(none) ? ready.base.chi2 : none, chi2, prediction);
  return prediction;
}

Prediction correlation(const BaselineProblem& ready, const std::vector<diagnosis::Probe>& probes) {
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

/// df/du of `free` at the base model: its own from its fit, a candidate's from its probes (of its
/// probing step where the small one does nothing, as below a threshold).
Matrix slopes(const BaselineProblem& ready, const std::vector<diagnosis::Probe>& probes,
              const std::vector<int>& free) {
  std::map<int, Vector> of;
  for (int i = 0; i < count_of(ready.base.free); ++i)
    of[ready.base.free[i]] = -ready.base.jacobian.col(i);
  for (int c = 0; c < count_of(probes); ++c) {
    const auto& parameters = ready.problem->hypotheses.candidates[c].parameters;
    for (int k = 0; probes[c].valid && k < count_of(parameters); ++k) {
      const bool threshold = probes[c].small.col(k).norm() == 0.0;
      of[parameters[k]] = (threshold ? probes[c].full : probes[c].small).col(k);
    }
  }
  Matrix G = Matrix::Zero(ready.whitening.rows, count_of(free));
  for (int i = 0; i < count_of(free); ++i)
    if (of.count(free[i]) != 0) G.col(i) = of[free[i]];
  return G;
}

/// Ranges of u - u of the base model.
std::vector<Bounds> free_ranges(const BaselineProblem& ready, const std::vector<int>& free) {
  std::vector<Bounds> ranges;
  for (const int i : free) {
    const diagnosis::FreeParameter& p = ready.problem->hypotheses.parameters[i];
    ranges.push_back({(p.bounds.lower - ready.base.p[i]) / p.scale,
                      (p.bounds.upper - ready.base.p[i]) / p.scale});
  }
  return ranges;
}

Prediction ridge_on_all(const BaselineProblem& ready, const std::vector<diagnosis::Probe>& probes) {
  const diagnosis::Hypotheses& hypotheses = ready.problem->hypotheses;
  std::vector<int> all;
  for (int i = 0; i < count_of(hypotheses.candidates); ++i) all.push_back(i);
  const std::vector<int> free = hypotheses.freed_by(all);
  const Matrix G = slopes(ready, probes, free);
  const RidgeFit fit = ridge(G, ready.base.residual, free_ranges(ready, free));

  std::vector<double> energy;
  for (const diagnosis::Candidate& c : hypotheses.candidates) {
    Vector explained = Vector::Zero(G.rows());
    for (int i = 0; i < count_of(free); ++i)
      if (std::find(c.parameters.begin(), c.parameters.end(), free[i]) != c.parameters.end())
        explained += G.col(i) * fit.u[i];
    energy.push_back(explained.squaredNorm());
  }
  return answer_by(ready, energy);
}

Prediction insufficient() {
  Prediction prediction;
  prediction.verdict = Verdict::insufficient;
  return prediction;
}

Prediction sparse_torque(const BaselineProblem& ready) {
  const std::vector<JointTorque> joints = residual_torques(ready);
  if (joints.empty()) return insufficient();
  if (!ready.has_gap()) return statement(ready, to_text(Verdict::none));

  double most = 0.0;
  std::string named = to_text(Verdict::none);
  for (const JointTorque& joint : joints) {
    const SparseFit fit = sparse_regression(joint.library, joint.torque);
    for (int k = 0; k < kTorqueTerms; ++k) {
      const double energy =
          (joint.library.col(k) * fit.coefficients[k]).cwiseQuotient(joint.deviation).squaredNorm();
      if (!(energy > most)) continue;
      most = energy;
      named = effect_of_term(ready.problem->hypotheses,
                             ready.problem->observations.datasets.front().model, joint.joint,
                             static_cast<TorqueTerm>(k));
      if (named.empty()) named = to_text(Verdict::unexplained);
    }
  }
  return statement(ready, named);
}

}  // namespace

const std::vector<std::string>& baseline_names() {
  static const std::vector<std::string> names = {kLowestError, "correlation",
                                                 "ridge on all parameters", "sparse regression"};
  return names;
}

bool states_probability(const std::string& baseline) { return baseline == kLowestError; }

std::vector<Prediction> baseline_answers(const std::vector<std::filesystem::path>& datasets) {
  std::vector<trajectory::Dataset> read;
  for (const std::filesystem::path& dataset : datasets)
    read.push_back(trajectory::read_dataset(dataset));
  const std::optional<BaselineProblem> prepared = baseline_problem(read);
  if (!prepared) return std::vector<Prediction>(baseline_names().size(), insufficient());

  const BaselineProblem& ready = *prepared;
  const std::vector<diagnosis::Probe> probes =
      diagnosis::screen(*ready.problem, ready.whitening, ready.base);
  return {lowest_training_error(ready), correlation(ready, probes), ridge_on_all(ready, probes),
          sparse_torque(ready)};
}

}  // namespace jaculus::evaluation
