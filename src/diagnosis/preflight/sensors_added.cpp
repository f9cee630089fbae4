#include "diagnosis/preflight/sensors_added.h"

#include <algorithm>

namespace jaculus::diagnosis {
namespace {

using model::PlanarModel;
using simulation::Experiment;
using simulation::SensorStream;
using trajectory::Quantity;

/// Channels that come together, and the noise of each.
struct SensorKind {
  std::string name;
  std::string stream;
  std::vector<std::string> channels;
  double noise = 0.0;  ///< [unit]
};

bool records(const Experiment& planned, const std::string& channel) {
  return std::any_of(planned.streams.begin(), planned.streams.end(),
                     [&](const SensorStream& s) { return index_of(s.channels, channel) >= 0; });
}

/// Of every motor that has the quantity.
SensorKind of_motors(const PlanarModel& model, const std::string& name, Quantity quantity,
                     double noise) {
  SensorKind kind{name, trajectory::kJointStream, {}, noise};
  const bool electric =
      quantity == Quantity::current || quantity == Quantity::voltage || quantity == Quantity::duty;
  for (const model::PlanarMotor& motor : model.motors)
    if (!electric || !motor.ideal())
      kind.channels.push_back(quantity == Quantity::position
                                  ? motor.joint
                                  : trajectory::channel_name(motor.joint, quantity));
  return kind;
}

std::vector<SensorKind> kinds_of(const Experiment& planned, const PlanarModel& model,
                                 const Settings& s) {
  std::vector<SensorKind> kinds = {
      of_motors(model, "encoders", Quantity::position, s.new_encoder_noise),
      of_motors(model, "joint rates", Quantity::velocity, s.new_rate_noise),
      of_motors(model, "joint torques", Quantity::torque, s.new_torque_noise),
      of_motors(model, "motor currents", Quantity::current, s.new_current_noise),
      of_motors(model, "motor voltages", Quantity::voltage, s.new_voltage_noise)};
  const trajectory::StatedController& controller = planned.setup.controller;
  const Quantity commanded =
      planned.setup.script ? planned.setup.script->quantity : controller.quantity;
  if (planned.setup.script)
    std::erase_if(kinds, [&](const SensorKind& kind) {
      return !kind.channels.empty() &&
             trajectory::parse_channel(kind.channels.front()).quantity == commanded;
    });

  if (!model.motors.empty() && !model.motors.front().ideal())
    kinds.push_back({"bus voltage", trajectory::kJointStream, {"bus_voltage"}, s.new_bus_noise});
  if (model.coordinate_index("pitch") >= 0) {
    kinds.push_back({"IMU pitch", trajectory::kJointStream, {"imu_pitch"}, s.new_imu_noise});
    kinds.push_back(
        {"gyroscope", trajectory::kJointStream, {"imu_pitch_velocity"}, s.new_imu_rate_noise});
  }
  SensorKind mocap{"motion capture", trajectory::kMocapStream, {}, s.new_place_noise};
  for (const char* name : {"x", "z", "pitch"})
    if (model.coordinate_index(name) >= 0) mocap.channels.emplace_back(name);
  kinds.push_back(std::move(mocap));
  return kinds;
}

}  // namespace

std::vector<NamedExperiment> with_one_more_sensor(const Experiment& planned,
                                                  const PlanarModel& model,
                                                  const Settings& settings) {
  std::vector<NamedExperiment> out;
  for (const SensorKind& kind : kinds_of(planned, model, settings)) {
    NamedExperiment named{kind.name, planned};
    std::vector<SensorStream>& streams = named.experiment.streams;
    auto stream = std::find_if(streams.begin(), streams.end(),
                               [&](const SensorStream& s) { return s.name == kind.stream; });
    if (stream == streams.end()) {
      const bool mocap = kind.stream == trajectory::kMocapStream;
      SensorStream added;
      added.name = kind.stream;
      added.rate_hz = mocap ? settings.new_mocap_rate : settings.new_encoder_rate;
      stream = streams.insert(streams.end(), std::move(added));
    }

    bool any = false;
    for (const std::string& channel : kind.channels) {
      if (records(planned, channel)) continue;
      any = true;
      stream->channels.push_back(channel);
      stream->noise[channel] = channel == "pitch" ? settings.new_pitch_noise : kind.noise;
    }
    if (any) out.push_back(std::move(named));
  }
  return out;
}

}  // namespace jaculus::diagnosis
