#include "diagnosis/forward/measured_input.h"

#include <algorithm>
#include <cmath>

#include "jaculus/simulation/experiment.h"

namespace jaculus::diagnosis {
namespace {

/// Samples of one motor's input in a segment's own time [s].
struct InputLog {
  std::string joint;
  std::vector<double> time, value;
};

/// The last sample before the start stands at it.
InputLog log_from(const trajectory::Stream& stream, int channel, const std::string& joint,
                  double start) {
  InputLog log;
  log.joint = joint;
  for (Eigen::Index i = 0; i < stream.time.size(); ++i) {
    if (!std::isfinite(stream.values(channel, i))) continue;
    if (!log.time.empty() && stream.time[i] <= start) log.time.clear(), log.value.clear();
    log.time.push_back(std::max(0.0, stream.time[i] - start));
    log.value.push_back(stream.values(channel, i));
  }
  return log;
}

std::vector<InputLog> logs_of(const ObservedDataset& observed, const Segment& segment) {
  std::vector<InputLog> logs;
  const trajectory::Trial& trial = observed.dataset.trials[segment.trial];
  for (const model::PlanarMotor& motor : observed.model.motors) {
    for (const trajectory::Stream& stream : trial.streams) {
      const int channel =
          stream.channel(channel_name(motor.joint, observed.dataset.controller.input));
      if (channel < 0) continue;
      logs.push_back(log_from(stream, channel, motor.joint, segment.start));
      break;  // one log a motor
    }
  }
  return logs;
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

simulation::Controller measured_controller(const ObservedDataset& observed,
                                           const Segment& segment) {
  trajectory::Dataset scripted = observed.dataset;
  scripted.plan.reset();
  scripted.trials.clear();
  scripted.script = script_of(logs_of(observed, segment), observed.dataset.controller.input);

  simulation::Controller controller = simulation::stated_controller(scripted, observed.model, {});
  controller.rate_hz = kInfinity;
  controller.reference.linear = true;
  return controller;
}

}  // namespace jaculus::diagnosis
