#include "diagnosis/noise/input_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "diagnosis/data/scatter.h"

namespace jaculus::diagnosis {
namespace {

/// Samples of a channel that were logged, in order.
std::vector<double> samples_of(const trajectory::Stream& stream, int channel) {
  std::vector<double> x;
  for (Eigen::Index i = 0; i < stream.values.cols(); ++i)
    if (std::isfinite(stream.values(channel, i))) x.push_back(stream.values(channel, i));
  return x;
}

/// Torque at the joint by a unit of what is logged, at rest [N m, N]; 0 where the log drives no
/// motor by itself.
double torque_by(const model::PlanarMotor& motor, trajectory::Quantity logged, double bus_voltage) {
  using enum trajectory::Quantity;
  const double geared = motor.gear * motor.efficiency;
  if (logged == torque) return 1.0;
  if (logged == motor_torque) return geared;
  if (motor.ideal()) return 0.0;
  if (logged == current) return geared * motor.torque_constant;
  const double by_voltage = geared * motor.torque_constant / motor.resistance;
  if (logged == voltage) return by_voltage;
  return logged == duty ? by_voltage * bus_voltage : 0.0;
}

/// The scatter of a motor's log over all trials, root mean square, and its samples a second.
struct LogScatter {
  double deviation = 0.0;  ///< [unit of the log]
  double rate = 0.0;       ///< [1/s]
};

LogScatter log_scatter(const trajectory::Dataset& dataset, const std::string& channel) {
  double squares = 0.0, samples = 0.0, time = 0.0;
  for (const trajectory::Trial& trial : dataset.trials)
    for (const trajectory::Stream& stream : trial.streams) {
      const int c = stream.channel(channel);
      if (c < 0) continue;
      const std::vector<double> x = samples_of(stream, c);
      const auto count = static_cast<double>(x.size());
      squares += count * std::pow(scatter_of(x), 2);
      samples += count;
      if (stream.time.size() > 1) time += stream.time.tail<1>()[0] - stream.time[0];
      break;  // one log a motor
    }
  if (samples == 0.0 || time == 0.0) return {};
  return {std::sqrt(squares / samples), samples / time};
}

}  // namespace

std::map<std::string, double> input_noise(const ObservedDataset& observed,
                                          const Settings& settings) {
  std::map<std::string, double> noise;
  if (!observed.measured_input) return noise;
  const trajectory::StatedController& controller = observed.dataset.controller;
  for (const model::PlanarMotor& motor : observed.model.motors) {
    const LogScatter log =
        log_scatter(observed.dataset, trajectory::channel_name(motor.joint, controller.input));
    const double torque = log.deviation * torque_by(motor, controller.input,
                                                    controller.bus_voltage.value_or(motor.voltage));
    if (torque > 0.0)
      noise[motor.joint] = torque / std::sqrt(std::max(1.0, log.rate * settings.force_box));
  }
  return noise;
}

SegmentNuisances with_input_noise(SegmentNuisances nuisances, const Hypotheses& hypotheses,
                                  const std::map<std::string, double>& noise,
                                  const Matrix& slopes) {
  std::vector<Eigen::Index> columns;
  std::vector<double> scales;
  Eigen::Index next = 0;
  for (const ForceGroup& force : hypotheses.forces) {
    const auto own = noise.find(force.name);
    for (const int box : force.boxes) {
      if (own != noise.end()) {
        columns.push_back(next);
        scales.push_back(own->second / hypotheses.parameters[box].scale);
        nuisances.names.push_back("noise of the input at " + force.name);
      }
      ++next;
    }
  }

  const Eigen::Index before = nuisances.columns.cols(), more = count_of(columns);
  nuisances.columns.conservativeResize(Eigen::NoChange, before + more);
  nuisances.columns.rightCols(more) = slopes(Eigen::all, columns);
  nuisances.mean.conservativeResize(before + more);
  nuisances.mean.tail(more).setZero();
  nuisances.scale.conservativeResize(before + more);
  nuisances.scale.tail(more) = Eigen::Map<const Vector>(scales.data(), more);
  return nuisances;
}

}  // namespace jaculus::diagnosis
