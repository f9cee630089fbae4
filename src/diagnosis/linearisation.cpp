#include "jaculus/diagnosis/linearisation.h"

#include <cmath>
#include <cstddef>

#include "diagnosis/align.h"
#include "diagnosis/start_curvature.h"
#include "jaculus/diagnosis/evidence_space.h"

namespace jaculus {
namespace {

constexpr double kStartStep = 0.25;  // of its scale, by which a start is moved for its slope
constexpr double kFreeOffset = 1.0;  // m or rad: relative to rest, wherever that was
constexpr double kHeightOffset = 0.003, kImuOffset = 0.01, kBusOffset = 0.1;  // m, rad, V
constexpr double kShift = 2e-3;                                               // s, prior scatter of stamps
constexpr double kShiftWeight = 2.0;                                          // runs that this prior is worth

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Prior standard deviation of a channel's own constant offset in a run; 0: it has none.
double offset_scale(const Condition& condition, const Channel& channel) {
  if (condition.measured_input) return 0.0;
  if (channel.name == "x" || channel.name == "pitch") return kFreeOffset;
  if (channel.name == "z") return kHeightOffset;
  if (channel.name == "imu_pitch") return kImuOffset;
  return channel.name == "bus_voltage" ? kBusOffset : 0.0;
}

double shift_scale(const Condition& condition, std::size_t stream) {
  double mean = 0.0, squares = 0.0;
  const auto n = static_cast<double>(condition.runs.size());
  for (const Run& run : condition.runs) mean += run.shift[stream] / n;
  for (const Run& run : condition.runs) squares += std::pow(run.shift[stream] - mean, 2);
  return std::sqrt((kShiftWeight * kShift * kShift + squares) / (kShiftWeight + n - 1.0));
}

/// Adds a column that is `value(channel, time)` on the rows of one run.
template <class Value>
void add_column(const Condition& condition, int run, const std::string& name, double mean, double scale, Value&& value,
                RunNuisances& out) {
  Vector column = Vector::Zero(out.count);
  for (const RowSpan& span : row_spans(condition)) {
    if (span.run != run) continue;
    const Vector& time = condition.runs[at(run)].time[at(span.channel)];
    for (int i = 0; i < span.count; ++i) column[span.first - out.first + i] = value(span.channel, time[i]);
  }
  if (column.cwiseAbs().maxCoeff() == 0.0) return;
  const Eigen::Index k = out.columns.cols();
  out.columns.conservativeResize(out.count, k + 1);
  out.columns.col(k) = column;
  out.mean.conservativeResize(k + 1);
  out.scale.conservativeResize(k + 1);
  out.mean[k] = mean;
  out.scale[k] = scale;
  out.names.push_back(name);
}

void add_shifts(const Condition& condition, int r, const Prediction& prediction, RunNuisances& out) {
  if (condition.measured_input) return;
  const Run& run = condition.runs[at(r)];
  const double period = 1.0 / condition.dataset.controller.rate_hz;
  for (std::size_t s = 0; s < condition.streams.size(); ++s) {
    const auto slope = [&](int channel, double time) {
      if (condition.stream_index(condition.channels[at(channel)].stream) != static_cast<int>(s)) return 0.0;
      const double t = time - run.start - run.shift[s], h = prediction.step;
      return -(prediction.row(run, channel, t + h) - prediction.row(run, channel, t - h)) / (2.0 * h);
    };
    const auto slope_of_held = [&](int channel, double time) {
      return condition.channels[at(channel)].held ? slope(channel, time) : 0.0;
    };
    add_column(condition, r, "shift of " + condition.streams[s], -run.shift[s], shift_scale(condition, s), slope, out);
    // Where between two steps of the loop its samples lie, nobody says.
    if (std::isfinite(period) && period > 0.0)
      add_column(condition, r, "phase of the loop in " + condition.streams[s], 0.0, period / std::sqrt(12.0),
                 slope_of_held, out);
  }
}

void add_offsets(const Condition& condition, int r, RunNuisances& out) {
  for (std::size_t c = 0; c < condition.channels.size(); ++c) {
    const double scale = offset_scale(condition, condition.channels[c]);
    if (scale == 0.0) continue;
    add_column(
        condition, r, "offset of " + condition.channels[c].name, 0.0, scale,
        [&](int channel, double) { return channel == static_cast<int>(c) ? 1.0 : 0.0; }, out);
  }
}

/// A run's own smooth ways, where runs differ by more than noise and starts.
void add_wander(const Condition& condition, int r, RunNuisances& out) {
  for (const RowSpan& span : row_spans(condition)) {
    const Channel& channel = condition.channels[at(span.channel)];
    if (span.run != r || channel.wander == 0.0) continue;
    const Eigen::Index first = out.columns.cols(), all = first + kWanderModes;
    out.columns.conservativeResize(out.count, all);
    out.columns.rightCols(kWanderModes).setZero();
    out.columns.block(span.first - out.first, first, span.count, kWanderModes) =
        fault_modes(condition, channel, condition.runs[at(r)].time[at(span.channel)], kWanderModes);
    out.mean.conservativeResize(all);
    out.mean.tail(kWanderModes).setZero();
    out.scale.conservativeResize(all);
    out.scale.tail(kWanderModes).setConstant(channel.wander);
    out.names.insert(out.names.end(), kWanderModes, "wander of " + channel.name);
  }
}

RunNuisances run_nuisances(const DiagnosisProblem& problem, const Linearisation& about, int c, int r) {
  const Condition& condition = problem.observations.conditions[at(c)];
  RunNuisances out;
  for (const RowSpan& span : row_spans(condition)) {
    if (span.run < r) out.first = span.first + span.count;
    if (span.run == r) out.count += span.count;
  }
  out.columns.resize(out.count, 0);
  const Prediction& nominal = *about.at_p.runs(condition, c)[at(r)];
  add_shifts(condition, r, nominal, out);
  for (std::size_t k = 0; k < about.starts.size(); ++k) {
    const FreeParameter& parameter = problem.hypotheses.parameters[at(problem.hypotheses.starts[k])];
    if (!about.starts[k].valid) continue;
    const Prediction& moved = *about.starts[k].runs(condition, c)[at(r)];
    const Run& run = condition.runs[at(r)];
    const auto difference = [&](int channel, double time) {
      const auto stream = static_cast<std::size_t>(condition.stream_index(condition.channels[at(channel)].stream));
      const double t = time - run.start - run.shift[stream];
      return (moved.row(run, channel, t) - nominal.row(run, channel, t)) / (kStartStep * parameter.scale);
    };
    add_column(condition, r, "start of " + parameter.name, 0.0, parameter.scale, difference, out);
  }
  add_offsets(condition, r, out);
  return out;
}

}  // namespace

std::vector<const Prediction*> PredictionSet::runs(const Condition& condition, int c) const {
  std::vector<const Prediction*> pointers;
  const auto& own = simulations[at(c)];
  for (std::size_t r = 0; r < condition.runs.size(); ++r) pointers.push_back(&own[own.size() == 1 ? 0 : r]);
  return pointers;
}

PredictionSet predict_all(const DiagnosisProblem& problem, const Vector& p) {
  PredictionSet set;
  set.valid = true;
  for (std::size_t c = 0; c < problem.observations.conditions.size(); ++c) {
    const Condition& condition = problem.observations.conditions[c];
    const std::size_t count = condition.measured_input ? condition.runs.size() : 1;
    set.simulations.emplace_back();
    for (std::size_t r = 0; r < count; ++r) {
      set.simulations.back().push_back(problem.forward(static_cast<int>(c), static_cast<int>(r), p));
      if (set.simulations.back().back().valid) continue;
      set.valid = false;
      set.message = set.simulations.back().back().message;
      return set;
    }
  }
  return set;
}

std::vector<Vector> rows_of(const DiagnosisProblem& problem, const PredictionSet& predictions) {
  std::vector<Vector> rows;
  for (std::size_t c = 0; c < problem.observations.conditions.size(); ++c) {
    const Condition& condition = problem.observations.conditions[c];
    rows.push_back(predicted_rows(condition, predictions.runs(condition, static_cast<int>(c))));
  }
  return rows;
}

Linearisation linearise(DiagnosisProblem& problem, const Vector& p) {
  Linearisation about;
  about.p = p;
  about.at_p = predict_all(problem, p);
  if (!about.at_p.valid) return about;
  for (const int start : problem.hypotheses.starts) {
    Vector moved = p;
    moved[start] += kStartStep * problem.hypotheses.parameters[at(start)].scale;
    about.starts.push_back(predict_all(problem, moved));
  }
  for (std::size_t c = 0; c < problem.observations.conditions.size(); ++c) {
    Condition& condition = problem.observations.conditions[c];
    const auto predictions = about.at_p.runs(condition, static_cast<int>(c));
    for (Run& run : condition.runs) {
      if (run.recorded.empty()) run.recorded = run.value;
      run.value = run.recorded;
    }
    if (!condition.measured_input) align(condition, predictions);
    about.nuisances.emplace_back();
    for (std::size_t r = 0; r < condition.runs.size(); ++r) {
      about.nuisances.back().push_back(run_nuisances(problem, about, static_cast<int>(c), static_cast<int>(r)));
    }
    estimate_noise(condition, predictions, about.nuisances.back());
    if (take_start_curvature(problem, about, static_cast<int>(c)))
      estimate_noise(condition, predictions, about.nuisances.back());
    for (std::size_t r = 0; r < condition.runs.size(); ++r)
      add_wander(condition, static_cast<int>(r), about.nuisances.back()[r]);
  }
  return about;
}

void declare_discrepancy(DiagnosisProblem& problem, const Linearisation& about, double share, double floor) {
  const std::vector<Vector> predicted = rows_of(problem, about.at_p);
  for (std::size_t c = 0; c < problem.observations.conditions.size(); ++c) {
    Condition& condition = problem.observations.conditions[c];
    const Vector residual = measured_rows(condition) - predicted[c];
    std::vector<double> squares(condition.channels.size(), 0.0), counts(condition.channels.size(), 0.0);
    for (const RowSpan& span : row_spans(condition)) {
      Vector r = residual.segment(span.first, span.count);
      if (offset_scale(condition, condition.channels[at(span.channel)]) == kFreeOffset) r.array() -= r[0];
      squares[at(span.channel)] += r.squaredNorm();
      counts[at(span.channel)] += span.count;
    }
    for (std::size_t k = 0; k < condition.channels.size(); ++k) {
      Channel& channel = condition.channels[k];
      const double noise = channel.noise_floor * channel.noise_floor;
      const double gap = counts[k] > 0.0 ? std::max(0.0, squares[k] / counts[k] - noise) : 0.0;
      channel.discrepancy = std::sqrt(floor * floor * noise + share * share * gap);
    }
  }
}

}  // namespace jaculus
