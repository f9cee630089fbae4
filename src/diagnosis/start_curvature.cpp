#include "diagnosis/start_curvature.h"

#include <cstddef>
#include <string>

#include "diagnosis/nuisance_estimate.h"

namespace jaculus {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Nuisances of a run by its rows before the prefix' end.
Vector by_prefix(const Condition& condition, const RunNuisances& n, int run, const Prediction& prediction) {
  Vector residual(n.count), weight = Vector::Zero(n.count);
  const Run& own = condition.runs[at(run)];
  for (const RowSpan& span : row_spans(condition)) {
    if (span.run != run) continue;
    const Channel& channel = condition.channels[at(span.channel)];
    const double late = own.start + own.shift[at(condition.stream_index(channel.stream))];
    for (int i = 0; i < span.count; ++i) {
      const int row = span.first - n.first + i;
      const double t = own.time[at(span.channel)][i];
      residual[row] = own.value[at(span.channel)][i] - prediction.row(own, span.channel, t - late);
      if (t < condition.prefix_end && !channel.held && channel.noise_floor > 0.0)
        weight[row] = 1.0 / channel.noise_floor;
    }
  }
  return n.mean + nuisance_deviation(n, residual - n.columns * n.mean, weight);
}

bool take_from_run(DiagnosisProblem& problem, const Linearisation& about, int c, int r) {
  Condition& condition = problem.observations.conditions[at(c)];
  const RunNuisances& n = about.nuisances[at(c)][at(r)];
  const Prediction& straight = *about.at_p.runs(condition, c)[at(r)];
  const Vector found = by_prefix(condition, n, r, straight);
  Vector p = about.p, slope = Vector::Zero(n.count);
  for (const int start : problem.hypotheses.starts) {
    const FreeParameter& own = problem.hypotheses.parameters[at(start)];
    for (std::size_t k = 0; k < n.names.size(); ++k) {
      if (n.names[k] != "start of " + own.name) continue;
      const double value = found[static_cast<Eigen::Index>(k)];
      p[start] += value;
      slope += value * n.columns.col(static_cast<Eigen::Index>(k));
    }
  }
  if (p == about.p) return false;
  const Prediction there = problem.forward(c, r, p);
  if (!there.valid) return false;
  Run& run = condition.runs[at(r)];
  for (const RowSpan& span : row_spans(condition)) {
    if (span.run != r) continue;
    const double late = run.start + run.shift[at(condition.stream_index(condition.channels[at(span.channel)].stream))];
    for (int i = 0; i < span.count; ++i) {
      const double t = run.time[at(span.channel)][i] - late;
      run.value[at(span.channel)][i] -=
          there.row(run, span.channel, t) - straight.row(run, span.channel, t) - slope[span.first - n.first + i];
    }
  }
  return true;
}

}  // namespace

bool take_start_curvature(DiagnosisProblem& problem, const Linearisation& about, int c) {
  const Condition& condition = problem.observations.conditions[at(c)];
  if (condition.measured_input || problem.hypotheses.starts.empty()) return false;
  bool any = false;
  for (std::size_t r = 0; r < condition.runs.size(); ++r)
    any = take_from_run(problem, about, c, static_cast<int>(r)) || any;
  return any;
}

}  // namespace jaculus
