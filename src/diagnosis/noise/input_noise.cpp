#include "diagnosis/noise/input_noise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "diagnosis/data/scatter.h"
#include "diagnosis/noise/force_bands.h"

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

/// The noise of a motor's log over all trials, and its samples a second.
struct LogNoise {
  double white = 0.0;    ///< of a sample [unit of the log]
  double flicker = 0.0;  ///< the root of h, at most [unit of the log]
  double rate = 0.0;     ///< [1/s]
};

/// Mean squares of octaves over trials, each by the trials that have it.
struct PooledOctaves {
  std::vector<double> sums, counts;

  void add(const std::vector<double>& squares, double count) {
    sums.resize(std::max(sums.size(), squares.size()));
    counts.resize(sums.size());
    for (std::size_t o = 0; o < squares.size(); ++o) {
      sums[o] += count * squares[o];
      counts[o] += count;
    }
  }
  [[nodiscard]] std::vector<double> means() const {
    std::vector<double> out = sums;
    for (std::size_t o = 0; o < out.size(); ++o) out[o] /= counts[o];
    return out;
  }
};

LogNoise log_noise(const trajectory::Dataset& dataset, const std::string& channel) {
  PooledOctaves octaves;
  double samples = 0.0, time = 0.0;
  for (const trajectory::Trial& trial : dataset.trials)
    for (const trajectory::Stream& stream : trial.streams) {
      const int c = stream.channel(channel);
      if (c < 0) continue;
      const std::vector<double> x = samples_of(stream, c);
      octaves.add(scatter_by_octaves(x), static_cast<double>(x.size()));
      samples += static_cast<double>(x.size());
      if (stream.time.size() > 1) time += stream.time.tail<1>()[0] - stream.time[0];
      break;  // one log a motor
    }
  const std::vector<double> squares = octaves.means();
  if (squares.empty() || time == 0.0) return {};
  return {std::sqrt(squares.front()), most_flicker(squares), samples / time};
}

/// What the integral of 1/f has in the frequencies of a cosine.
double octaves_of(int cosine) {
  const double k = cosine;
  return cosine == 0 ? std::numbers::ln2 : std::log((2.0 * k + 1.0) / (2.0 * k - 1.0));
}

}  // namespace

std::map<std::string, InputNoise> input_noise(const ObservedDataset& observed,
                                              const Settings& settings) {
  std::map<std::string, InputNoise> noise;
  if (!observed.measured_input) return noise;
  const trajectory::StatedController& controller = observed.dataset.controller;
  for (const model::PlanarMotor& motor : observed.model.motors) {
    const LogNoise log =
        log_noise(observed.dataset, trajectory::channel_name(motor.joint, controller.input));
    const double torque =
        torque_by(motor, controller.input, controller.bus_voltage.value_or(motor.voltage));
    const double white = log.white / std::sqrt(std::max(1.0, log.rate * settings.force_box));
    if (torque * log.white > 0.0) noise[motor.joint] = {torque * white, torque * log.flicker};
  }
  return noise;
}

Vector deviations_of(const InputNoise& noise, int boxes) {
  Vector deviations(boxes);
  for (int k = 0; k < boxes; ++k)
    deviations[k] = std::hypot(noise.white, noise.flicker * std::sqrt(boxes * octaves_of(k)));
  return deviations;
}

double flicker_of_force(double rms, int boxes) {
  double octaves = 0.0;
  for (int k = 0; k < boxes; ++k) octaves += octaves_of(k);
  return rms / std::sqrt(octaves);
}

SegmentNuisances with_input_noise(SegmentNuisances nuisances, const Hypotheses& hypotheses,
                                  const std::map<std::string, InputNoise>& noise,
                                  const Matrix& slopes) {
  Eigen::Index first = 0;
  for (const ForceGroup& force : hypotheses.forces) {
    const int boxes = count_of(force.boxes);
    const auto own = noise.find(force.name);
    if (own != noise.end()) {
      const double unit = hypotheses.parameters[force.boxes.front()].scale;
      const Eigen::Index before = nuisances.columns.cols();
      nuisances.columns.conservativeResize(Eigen::NoChange, before + boxes);
      nuisances.columns.rightCols(boxes) = slopes.middleCols(first, boxes) * cosines(boxes);
      nuisances.mean.conservativeResize(before + boxes);
      nuisances.mean.tail(boxes).setZero();
      nuisances.scale.conservativeResize(before + boxes);
      nuisances.scale.tail(boxes) = deviations_of(own->second, boxes) / unit;
      nuisances.names.insert(nuisances.names.end(), boxes, "noise of the input at " + force.name);
    }
    first += boxes;
  }
  return nuisances;
}

}  // namespace jaculus::diagnosis
