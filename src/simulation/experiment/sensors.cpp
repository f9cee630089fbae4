#include "simulation/experiment/sensors.h"

#include <algorithm>
#include <cmath>

#include "simulation/experiment/channel_values.h"
#include "simulation/plant/named_values.h"

namespace jaculus::simulation {
namespace {

std::string unit_of(const model::PlanarModel& model, const std::string& name) {
  const auto linear = [&model](const std::string& coordinate) {
    const int i = model.coordinate_index(coordinate);
    return i >= 0 && !model.coordinates[i].angular;
  };
  const trajectory::ChannelName channel = trajectory::parse_channel(name);
  const bool motion =
      channel.quantity == Quantity::position || channel.quantity == Quantity::velocity;
  return trajectory::unit_of(channel.quantity, motion && linear(channel.of));
}

/// One channel at its stamps, which are late by `late` [s].
Eigen::RowVectorXd read_channel(const SensorStream& spec, const std::string& name,
                                const Plant& plant, const Simulation& truth, const Vector& stamps,
                                double late, Random& random) {
  const Eigen::RowVectorXd raw = low_passed(tracked_channel(plant, truth, name), kTruthStep,
                                            value_or(plant.sensing.filter, name, 0.0));
  const double zero =
      spec.name == trajectory::kMocapStream && (name == "x" || name == "pitch") ? raw[0] : 0.0;
  const double scale = value_or(plant.sensing.scale, name, 1.0);
  const double offset = value_or(plant.sensing.offset, name, 0.0);
  const double noise = value_or(spec.noise, name, 0.0);
  const auto law = plant.sensing.laws.find(name);
  Eigen::RowVectorXd out(stamps.size());
  for (Eigen::Index k = 0; k < stamps.size(); ++k) {
    out[k] = scale * (interpolate(raw, kTruthStep, stamps[k] - late) - zero) + offset;
    if (law != plant.sensing.laws.end()) out[k] = law->second(out[k], stamps[k] - late);
    if (noise > 0.0) out[k] += noise * random.normal();
  }
  return out;
}

/// Gaps of geometric length, `dropout` of all samples on average.
void drop(const SensorStream& spec, Random& random, trajectory::Stream& stream) {
  if (spec.dropout <= 0.0) return;
  const double stop = 1.0 / spec.dropout_length;
  const double begin = std::min(1.0, stop * spec.dropout / (1.0 - spec.dropout));
  bool lost = false;
  for (Eigen::Index k = 0; k < stream.time.size(); ++k) {
    const double u = random.uniform();
    lost = lost ? u >= stop : u < begin;
    if (lost) stream.values.col(k).setConstant(kNaN);
  }
}

}  // namespace

trajectory::Stream read_sensor(const Experiment& experiment, const SensorStream& spec,
                               const Plant& plant, const Simulation& truth, Random& random) {
  const double late =
      random.draw(spec.time_shift) + value_or(plant.sensing.latency, spec.name, 0.0);
  trajectory::Stream stream;
  stream.name = spec.name;
  stream.rate_hz = spec.rate_hz;
  const double end = std::min(experiment.duration, truth.end_time);
  const double first = std::ceil(-experiment.lead * spec.rate_hz - 1e-6),
               last = std::floor(end * spec.rate_hz + 1e-6);
  stream.time.resize(std::max(1L, std::lround(last - first) + 1));
  for (int k = 0; k < count_of(stream.time); ++k) stream.time[k] = (first + k) / spec.rate_hz;

  stream.channels = spec.channels;
  stream.values.resize(count_of(spec.channels), stream.time.size());
  for (int c = 0; c < count_of(spec.channels); ++c) {
    stream.units.push_back(unit_of(plant.model, spec.channels[c]));
    stream.values.row(c) =
        read_channel(spec, spec.channels[c], plant, truth, stream.time, late, random);
  }

  drop(spec, random, stream);
  return stream;
}

}  // namespace jaculus::simulation
