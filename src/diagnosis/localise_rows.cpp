#include "diagnosis/localise_rows.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnosis/grid_simulation.h"

namespace jaculus {
namespace {

void set_weights(ConditionRows& rows) {
  rows.weight = Vector::Zero(rows.residual.size());
  for (const RowSpan& span : rows.spans) {
    const Channel& channel = rows.condition->channels[static_cast<size_t>(span.channel)];
    if (!(channel.noise_floor > 0.0)) continue;
    rows.weight.segment(span.first, span.count)
        .setConstant(1.0 / (channel.noise_floor * std::sqrt(channel_inflation(channel))));
  }
}

/// 1 for rows before the end of the prefix, 0 after it.
Vector prefix_rows(const ConditionRows& rows) {
  Vector use = Vector::Zero(rows.residual.size());
  for (const RowSpan& span : rows.spans) {
    const Run& run = rows.condition->runs[static_cast<size_t>(span.run)];
    const Vector& time = run.time[static_cast<size_t>(span.channel)];
    for (int k = 0; k < span.count; ++k)
      use[span.first + k] = time[k] - run.start <= rows.condition->prefix_end ? 1.0 : 0.0;
  }
  return use;
}

/// Takes a run's nuisances, as its prefix gives them, out of `judged`.
void judge(const RunNuisances& nuisances, const Vector& prefix, ConditionRows& rows) {
  const int first = nuisances.first, count = nuisances.count;
  const auto m = nuisances.columns.cols();
  if (m == 0) return;
  const Matrix A = nuisances.columns * nuisances.scale.asDiagonal();
  const Vector use = rows.weight.segment(first, count).cwiseProduct(prefix.segment(first, count));
  const Matrix N = use.asDiagonal() * A;
  const Eigen::LLT<Matrix> normal(Matrix::Identity(m, m) + N.transpose() * N);
  const Vector mean = normal.solve(N.transpose() * use.cwiseProduct(rows.residual.segment(first, count)));
  rows.judged.segment(first, count) -= A * mean;
  const Matrix AC = normal.solve(A.transpose()).transpose();
  for (int k = 0; k < count; ++k) rows.judged_deviation[first + k] = std::sqrt(std::max(0.0, AC.row(k).dot(A.row(k))));
}

}  // namespace

double channel_inflation(const Channel& channel) { return (1.0 + channel.correlation) / (1.0 - channel.correlation); }

ConditionRows condition_rows(const DiagnosisProblem& problem, const Linearisation& about, int c) {
  ConditionRows rows;
  rows.index = c;
  rows.condition = &problem.observations.conditions[static_cast<size_t>(c)];
  rows.spans = row_spans(*rows.condition);
  rows.predictions = about.at_p.runs(*rows.condition, c);
  rows.predicted = predicted_rows(*rows.condition, rows.predictions);
  rows.residual = measured_rows(*rows.condition) - rows.predicted;
  const std::vector<RunNuisances>& nuisances = about.nuisances[static_cast<size_t>(c)];
  for (const RunNuisances& run : nuisances)
    if (run.columns.cols() > 0) rows.residual.segment(run.first, run.count) -= run.columns * run.mean;
  rows.judged = rows.residual;
  rows.judged_deviation = Vector::Zero(rows.residual.size());
  set_weights(rows);
  const Vector prefix = prefix_rows(rows);
  for (const RunNuisances& run : nuisances) judge(run, prefix, rows);
  return rows;
}

bool predict_changed(const DiagnosisProblem& problem, const PlantForward& forward, int c, const Vector& p,
                     const std::function<void(RunSetup&)>& change, Vector& predicted) {
  const Condition& condition = problem.observations.conditions[static_cast<size_t>(c)];
  std::vector<Prediction> predictions;
  const int count = condition.measured_input ? static_cast<int>(condition.runs.size()) : 1;
  for (int r = 0; r < count; ++r) {
    RunSetup setup = forward.setup(c, r, p);
    change(setup);
    const Simulation simulation = simulate_on_grid(setup.plant, setup.controller, setup.start, setup.options);
    if (simulation.status != SimulationStatus::done || simulation.time.size() < 2) return false;
    predictions.push_back(prediction_of(condition, setup.plant, simulation));
  }
  std::vector<const Prediction*> runs;
  for (size_t r = 0; r < condition.runs.size(); ++r) runs.push_back(&predictions[count == 1 ? 0 : r]);
  predicted = predicted_rows(condition, runs);
  return predicted.allFinite();
}

}  // namespace jaculus
