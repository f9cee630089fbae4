// Selects the channels that count as evidence and cuts them to what the plan, the script or the logged input covers.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>

#include "jaculus/diagnosis/data.h"

namespace jaculus {
namespace {

constexpr int kFewestSamples = 8;    // of a channel in a run, below which it says nothing
constexpr double kSmoothing = 0.02;  // s, half width of the fit that starts a window

struct Samples {
  Vector time, value;
  int block = 1;
  double spacing = 0.0;
};

/// Samples of one channel within [from, to], gaps left out, averaged in blocks so that at most `most` remain. A block never
/// spans a gap: an average over one would stand at no instant.
Samples cut(const Stream& stream, int channel, double from, double to, int most) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < stream.time.size(); ++i) {
    if (stream.time[i] < from || stream.time[i] > to || !std::isfinite(stream.values(channel, i))) continue;
    kept.push_back(i);
  }
  const std::size_t block = std::max<std::size_t>(
      1, (kept.size() + static_cast<std::size_t>(most) - 1) / static_cast<std::size_t>(std::max(1, most)));
  std::vector<double> times, values;
  for (std::size_t i = 0; i + block <= kept.size(); i += block) {
    if (kept[i + block - 1] - kept[i] != static_cast<Eigen::Index>(block) - 1) continue;
    const auto n = static_cast<Eigen::Index>(block);
    times.push_back(stream.time.segment(kept[i], n).mean());
    values.push_back(stream.values.row(channel).segment(kept[i], n).mean());
  }
  const double spacing = kept.size() > 1 ? (stream.time[kept.back()] - stream.time[kept.front()]) /
                                               static_cast<double>(kept.back() - kept.front())
                                         : 0.0;
  return {Eigen::Map<Vector>(times.data(), static_cast<Eigen::Index>(times.size())),
          Eigen::Map<Vector>(values.data(), static_cast<Eigen::Index>(values.size())), static_cast<int>(block),
          spacing};
}

bool ends_with(const std::string& text, const std::string& end) { return text.ends_with(end); }

/// Whether a channel is one that the plant predicts; `held` where it follows the loop in steps.
bool is_predicted(const PlanarModel& model, const std::string& name, bool& held) {
  static const std::set<std::string> plain{"x", "z", "pitch", "imu_pitch", "imu_pitch_velocity", "bus_voltage"};
  held = name == "bus_voltage";
  if (name == "x" || name == "z" || name == "pitch") return model.coordinate_index(name) >= 0;
  if (name == "imu_pitch" || name == "imu_pitch_velocity") return model.coordinate_index("pitch") >= 0;
  if (name == "bus_voltage") return !model.motors.empty() && !model.motors.front().ideal();
  for (const PlanarMotor& motor : model.motors) {
    if (name == motor.joint || name == motor.joint + "_velocity") return true;
    if (name != motor.joint + "_torque" && (motor.ideal() || !name.starts_with(motor.joint + "_"))) continue;
    held = ends_with(name, "_torque") || ends_with(name, "_current") || ends_with(name, "_voltage") ||
           ends_with(name, "_duty");
    if (held && name.size() == motor.joint.size() + name.substr(name.rfind('_')).size()) return true;
  }
  return false;
}

/// A command is what was asked for, not what happened: the quantity that drove the joint. A duty happens only to a driver that was
/// asked for a torque, and shows by which voltage the windings were brought to it; else it is the command.
bool is_command(const Dataset& dataset, const std::string& name) {
  const StatedController& controller = dataset.controller;
  const std::string& asked = dataset.script ? dataset.script->quantity : controller.quantity;
  if (controller.kind == "measured") return ends_with(name, "_duty") || ends_with(name, "_" + controller.input);
  if (ends_with(name, "_duty")) return asked != "torque" || !(dataset.script || controller.quantity_stated);
  return dataset.script && ends_with(name, "_" + asked);
}

void select_channels(Condition& condition, const std::string& label, std::vector<std::string>& notes) {
  std::vector<std::string> unused;
  std::set<std::string> seen;
  for (const Trial& trial : condition.dataset.trials) {
    for (const Stream& stream : trial.streams) {
      if (condition.stream_index(stream.name) < 0) condition.streams.push_back(stream.name);
      for (std::size_t c = 0; c < stream.channels.size(); ++c) {
        Channel channel{stream.name, stream.channels[c], stream.units[c]};
        if (!seen.insert(stream.name + "." + channel.name).second || is_command(condition.dataset, channel.name))
          continue;
        if (is_predicted(condition.model, channel.name, channel.held)) {
          condition.channels.push_back(channel);
        } else {
          unused.push_back(channel.name);
        }
      }
    }
  }
  if (!unused.empty()) {
    notes.push_back(
        fmt::format("{}: not used, as the plant does not predict them: {}", label, fmt::join(unused, ", ")));
  }
}

/// Latest time at which any stream of the data has a sample.
double data_end(const Dataset& dataset) {
  double end = 0.0;
  for (const Trial& trial : dataset.trials)
    for (const Stream& stream : trial.streams)
      if (stream.time.size() > 0) end = std::max(end, stream.time[stream.time.size() - 1]);
  return end;
}

void set_window(Condition& condition, const ObservationOptions& options) {
  const Dataset& dataset = condition.dataset;
  double end = data_end(dataset);
  if (dataset.plan) {
    const int column = dataset.plan->column("time");
    if (column >= 0 && dataset.plan->values.rows() > 0)
      end = std::min(end, dataset.plan->values.col(column).maxCoeff());
  }
  condition.window_start = -options.rest;
  condition.window_end = end;
  condition.prefix_end = options.prefix_share * end;
}

void add_channels(const Condition& condition, const Trial& trial, double from, double to, int most, Run& run) {
  run.shift.assign(condition.streams.size(), 0.0);
  for (const Channel& channel : condition.channels) {
    const Stream* stream = trial.stream(channel.stream);
    const int index = stream != nullptr ? stream->channel(channel.name) : -1;
    Samples samples;
    const double begin = channel.held && !condition.measured_input ? std::max(from, kCommanded) : from;
    if (index >= 0) samples = cut(*stream, index, begin, to, most);
    if (samples.time.size() < kFewestSamples) samples = {};
    run.time.push_back(samples.time);
    run.value.push_back(samples.value);
    run.block.push_back(samples.block);
    run.spacing.push_back(samples.spacing);
  }
}

/// Least-squares parabola through samples about t: value and slope there; NaN where fewer than four are near.
Vec2 local_fit(const Stream& stream, int channel, double t) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  int count = 0;
  for (Eigen::Index i = 0; i < stream.time.size(); ++i) {
    const double dt = stream.time[i] - t;
    if (std::abs(dt) > kSmoothing || !std::isfinite(stream.values(channel, i))) continue;
    const Eigen::Vector3d row(1.0, dt / kSmoothing, dt * dt / (kSmoothing * kSmoothing));
    normal += row * row.transpose();
    right += row * stream.values(channel, i);
    ++count;
  }
  if (count < 4) return Vec2::Constant(kNaN);
  const Eigen::Vector3d fit = normal.ldlt().solve(right);
  return {fit[0], fit[1] / kSmoothing};
}

/// Initial coordinates of a window from the joints' own channels; false where one is missing.
bool measured_start(const Condition& condition, const Trial& trial, double t, Run& run) {
  const int n = condition.model.size();
  run.start_q = Vector::Zero(n);
  run.start_v = Vector::Zero(n);
  for (int i = 0; i < n; ++i) {
    bool found = false;
    for (const Stream& stream : trial.streams) {
      const int channel = stream.channel(condition.model.coordinates[static_cast<std::size_t>(i)].name);
      if (channel < 0) continue;
      const Vec2 fit = local_fit(stream, channel, t);
      if (!fit.allFinite()) continue;
      run.start_q[i] = fit[0];
      run.start_v[i] = fit[1];
      found = true;
    }
    if (!found) return false;
  }
  return true;
}

void cut_windows(Condition& condition, int trial_index, const ObservationOptions& options) {
  const Trial& trial = condition.dataset.trials[static_cast<std::size_t>(trial_index)];
  double end = 0.0;
  for (const Stream& stream : trial.streams)
    if (stream.time.size() > 0) end = std::max(end, stream.time[stream.time.size() - 1]);
  const int possible = std::max(1, static_cast<int>(std::floor(end / options.window)));
  const int count = std::min(possible, options.windows);
  for (int w = 0; w < count; ++w) {
    const double from = options.window * std::floor(static_cast<double>(w) * possible / count);
    const double to = std::min(end, from + options.window);
    Run run;
    run.trial = trial_index;
    run.start = from;
    if (!measured_start(condition, trial, from, run)) continue;
    add_channels(condition, trial, from, to, options.samples, run);
    condition.runs.push_back(std::move(run));
  }
}

bool has_data(const Run& run) {
  return std::any_of(run.time.begin(), run.time.end(), [](const Vector& t) { return t.size() > 0; });
}

/// Drops channels without samples, and constant ones: a dead sensor agrees with nothing and proves nothing.
void drop_dead_channels(Condition& condition, const std::string& label, std::vector<std::string>& notes) {
  for (std::size_t c = condition.channels.size(); c-- > 0;) {
    double least = kInfinity, most = -kInfinity;
    for (const Run& run : condition.runs) {
      if (run.value[c].size() == 0) continue;
      least = std::min(least, run.value[c].minCoeff());
      most = std::max(most, run.value[c].maxCoeff());
    }
    if (most > least) continue;
    const std::string& name = condition.channels[c].name;
    notes.push_back(
        most < least ? fmt::format("{}: {} has too few samples in the window, or none but NaN: left out", label, name)
                     : fmt::format("{}: {} is constant (a dead sensor?): left out", label, name));
    drop_channel(condition, c);
  }
}

void find_copies(const Condition& condition, const std::string& label, std::vector<std::string>& reasons) {
  if (condition.measured_input) return;
  for (std::size_t a = 0; a < condition.runs.size(); ++a) {
    for (std::size_t b = a + 1; b < condition.runs.size(); ++b) {
      bool same = has_data(condition.runs[a]);
      for (std::size_t c = 0; c < condition.channels.size() && same; ++c) {
        const Vector& u = condition.runs[a].value[c];
        const Vector& v = condition.runs[b].value[c];
        same = u.size() == v.size() && (u.size() == 0 || u == v);
      }
      if (!same) continue;
      const auto& trials = condition.dataset.trials;
      reasons.push_back(fmt::format("{}: {} and {} are copies of one another, so nothing tells the noise", label,
                                    trials[static_cast<std::size_t>(condition.runs[a].trial)].name,
                                    trials[static_cast<std::size_t>(condition.runs[b].trial)].name));
      return;
    }
  }
}

void set_spacing(Condition& condition) {
  for (std::size_t c = 0; c < condition.channels.size(); ++c) {
    std::vector<double> gaps;
    for (const Run& run : condition.runs)
      for (Eigen::Index i = 1; i < run.time[c].size(); ++i) gaps.push_back(run.time[c][i] - run.time[c][i - 1]);
    if (gaps.empty()) continue;
    const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
    std::nth_element(gaps.begin(), middle, gaps.end());
    condition.channels[c].spacing = *middle;
  }
}

Condition cut_condition(const Dataset& dataset, const PlanarModel& model, const ObservationOptions& options,
                        Observations& out) {
  Condition condition;
  condition.dataset = dataset;
  condition.model = model;
  condition.measured_input = dataset.controller.kind == "measured";
  const std::string label = dataset.folder.filename().string();
  select_channels(condition, label, out.notes);
  set_window(condition, options);
  for (std::size_t t = 0; t < dataset.trials.size(); ++t) {
    if (condition.measured_input) {
      cut_windows(condition, static_cast<int>(t), options);
      continue;
    }
    Run run;
    run.trial = static_cast<int>(t);
    add_channels(condition, dataset.trials[t], condition.window_start, condition.window_end, options.samples, run);
    condition.runs.push_back(std::move(run));
  }
  std::erase_if(condition.runs, [](const Run& run) { return !has_data(run); });
  drop_dead_channels(condition, label, out.notes);
  std::erase_if(condition.runs, [](const Run& run) { return !has_data(run); });
  set_spacing(condition);
  std::set<int> trials;
  for (const Run& run : condition.runs) trials.insert(run.trial);
  condition.trials = static_cast<int>(trials.size());
  if (condition.runs.empty()) {
    out.insufficient.push_back(
        fmt::format("{}: no channel has {} or more samples between {:.3g} s and {:.3g} s that the plant "
                    "predicts",
                    label, kFewestSamples, condition.window_start, condition.window_end));
  }
  find_copies(condition, label, out.insufficient);
  return condition;
}

}  // namespace

Observations observe(const std::vector<Dataset>& datasets, const std::vector<PlanarModel>& models,
                     const ObservationOptions& options) {
  Observations out;
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    Condition condition = cut_condition(datasets[i], models[i], options, out);
    if (!condition.runs.empty()) out.conditions.push_back(std::move(condition));
  }
  return out;
}

}  // namespace jaculus
