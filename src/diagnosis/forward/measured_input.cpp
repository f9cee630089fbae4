#include "diagnosis/forward/measured_input.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "jaculus/simulation/experiment.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kBeyond = 1.0;  ///< of a segment's end, that its simulation may run on [s]

/// Samples of one motor's input in a segment's own time [s].
struct InputLog {
  std::string joint;
  std::vector<double> time, value;
};

/// Samples from the last one before `first` on, in time since `start`, to the first after `end`.
InputLog log_from(const trajectory::Stream& stream, int channel, const std::string& joint,
                  double start, double first, double end) {
  InputLog log;
  log.joint = joint;
  for (Eigen::Index i = 0; i < stream.time.size(); ++i) {
    if (!std::isfinite(stream.values(channel, i))) continue;
    if (!log.time.empty() && stream.time[i] <= first) log.time.clear(), log.value.clear();
    log.time.push_back(stream.time[i] - start);
    log.value.push_back(stream.values(channel, i));
    if (stream.time[i] > end) break;
  }
  return log;
}

/// Means over cells of `step` since the start, at the cells' mean times: the line through them
/// moves the robot as the samples do, and a simulation need not stop at each of those.
InputLog thinned(const InputLog& log, double step) {
  const auto cell = [&](std::size_t i) { return std::floor(log.time[i] / step); };
  InputLog out;
  out.joint = log.joint;
  for (std::size_t first = 0; first < log.time.size();) {
    std::size_t end = first + 1;
    while (end < log.time.size() && cell(end) == cell(first)) ++end;
    const auto count = static_cast<double>(end - first);
    out.time.push_back(std::accumulate(&log.time[first], &log.time[0] + end, 0.0) / count);
    out.value.push_back(std::accumulate(&log.value[first], &log.value[0] + end, 0.0) / count);
    first = end;
  }
  return out;
}

/// Linear between samples, held at the ends; zero of an empty log.
double value_at(const InputLog& log, double time) {
  if (log.time.empty()) return 0.0;
  const auto after = std::lower_bound(log.time.begin(), log.time.end(), time);
  if (after == log.time.begin()) return log.value.front();
  if (after == log.time.end()) return log.value.back();
  const auto i = after - log.time.begin();
  if (*after == time) return log.value[i];
  const double share = (time - log.time[i - 1]) / (log.time[i] - log.time[i - 1]);
  return log.value[i - 1] + share * (log.value[i] - log.value[i - 1]);
}

/// The same log `late` later, from zero on. Cells stay what they were, so that it moves smoothly.
InputLog moved(const InputLog& log, double late) {
  InputLog later = log;
  for (double& time : later.time) time += late;
  if (later.time.empty()) return later;

  InputLog out{log.joint, {0.0}, {value_at(later, 0.0)}};
  for (std::size_t i = 0; i < later.time.size(); ++i) {
    if (later.time[i] <= 0.0) continue;
    out.time.push_back(later.time[i]);
    out.value.push_back(later.value[i]);
  }
  return out;
}

std::vector<InputLog> logs_of(const ObservedDataset& observed, const Segment& segment, double late,
                              double step) {
  std::vector<InputLog> logs;
  const trajectory::Trial& trial = observed.dataset.trials[segment.trial];
  for (const model::PlanarMotor& motor : observed.model.motors) {
    for (const trajectory::Stream& stream : trial.streams) {
      const int channel =
          stream.channel(channel_name(motor.joint, observed.dataset.controller.input));
      if (channel < 0) continue;
      const double first = segment.start - late - step;
      const InputLog log = log_from(stream, channel, motor.joint, segment.start, first,
                                    segment.end() - late + kBeyond);
      logs.push_back(moved(thinned(log, step), late));
      break;  // one log a motor
    }
  }
  return logs;
}

trajectory::InputScript script_of(const std::vector<InputLog>& logs,
                                  trajectory::Quantity quantity) {
  std::vector<double> stamps;
  for (const InputLog& log : logs) stamps.insert(stamps.end(), log.time.begin(), log.time.end());
  std::sort(stamps.begin(), stamps.end());
  stamps.erase(std::unique(stamps.begin(), stamps.end()), stamps.end());

  trajectory::InputScript script;
  script.quantity = quantity;
  script.time = Eigen::Map<const Vector>(stamps.data(), count_of(stamps));
  script.values.resize(count_of(logs), count_of(stamps));
  for (int j = 0; j < count_of(logs); ++j) {
    script.joints.push_back(logs[j].joint);
    for (int i = 0; i < count_of(stamps); ++i) script.values(j, i) = value_at(logs[j], stamps[i]);
  }
  return script;
}

}  // namespace

simulation::Controller measured_controller(const ObservedDataset& observed, const Segment& segment,
                                           double step, double late) {
  trajectory::Dataset scripted;
  scripted.folder = observed.dataset.folder;
  scripted.controller = observed.dataset.controller;
  scripted.script =
      script_of(logs_of(observed, segment, late, step), observed.dataset.controller.input);

  simulation::Controller controller = simulation::stated_controller(scripted, observed.model, {});
  controller.rate_hz = kInfinity;
  controller.reference.linear = true;
  return controller;
}

}  // namespace jaculus::diagnosis
