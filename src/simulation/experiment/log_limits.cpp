#include "jaculus/simulation/log_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>

#include "jaculus/components/motor.h"
#include "jaculus/trajectory/quantity.h"

namespace jaculus::simulation {
namespace {

using trajectory::Quantity;

// Chosen, not tuned: the factor of trajectory/log_checks.h, and as long a span; a share that spikes
// of a bus do not reach.
constexpr double kLargestFactor = 2.0;  // [-]
constexpr double kSpan = 0.05;          // [s]
constexpr double kBeyond = 0.99;        // of the samples
constexpr int kFewest = 20;             // samples, for a share to mean something

/// What a channel may reach: its size, its rate, its span.
struct Reach {
  double value = kInfinity, rate = kInfinity, span = kInfinity;
  std::string_view by;  ///< what sets it
};

/// Joint rate without load [rad/s or m/s].
double free_rate(const model::PlanarMotor& motor) {
  if (motor.ideal() || !std::isfinite(motor.voltage)) return motor.speed_limit / motor.gear;
  return motor.voltage / (motor.torque_constant * motor.gear);
}

double stall_torque(const model::PlanarMotor& motor) {
  if (motor.ideal() || !std::isfinite(motor.voltage))
    return components::largest_joint_torque(motor).value;
  return components::limited_joint_torque_at_voltage(motor, motor.voltage, 0.0).value;
}

double stall_current(const model::PlanarMotor& motor) {
  const double by_voltage = motor.ideal() ? kInfinity : motor.voltage / motor.resistance;
  return std::min(motor.current_limit, by_voltage);
}

Bounds range_of(const model::PlanarModel& model, const std::string& joint) {
  if (const int q = model.coordinate_index(joint); q >= 0) return model.coordinates[q].range;
  for (const model::JointRange& own : model.joint_ranges)
    if (own.joint == joint) return own.range;
  return {};
}

std::optional<Reach> reach_of(const std::string& channel, const model::PlanarModel& model) {
  const trajectory::ChannelName name = trajectory::parse_channel(channel);
  const int m = model.motor_index(name.of);
  if (m < 0) return std::nullopt;
  const model::PlanarMotor& motor = model.motors[m];
  const double ratio = motor.gear * motor.efficiency;
  switch (name.quantity) {
    case Quantity::torque:
      return Reach{.value = stall_torque(motor), .by = "the motor gives"};
    case Quantity::motor_torque:
      return Reach{.value = stall_torque(motor) / ratio, .by = "the motor gives"};
    case Quantity::current:
      return Reach{.value = stall_current(motor), .by = "the motor takes"};
    case Quantity::voltage:
      return Reach{.value = motor.voltage, .by = "the bus has"};
    case Quantity::duty:
      return Reach{.value = 1.0, .by = "of a duty there is"};
    case Quantity::velocity:
      return Reach{.value = free_rate(motor), .by = "without load the motor turns at"};
    case Quantity::position: {
      const Bounds range = range_of(model, name.of);
      return Reach{.rate = free_rate(motor), .span = range.upper - range.lower, .by = ""};
    }
    default:
      return std::nullopt;
  }
}

/// Values of a channel and rates of its spans over all trials.
struct Sizes {
  std::string unit;
  std::vector<double> values, rates;
};

void add(const trajectory::Stream& stream, int channel, Sizes& sizes) {
  sizes.unit = stream.units[channel];
  Eigen::Index from = -1;
  for (Eigen::Index k = 0; k < stream.time.size(); ++k) {
    const double value = stream.values(channel, k);
    if (!std::isfinite(value)) continue;
    sizes.values.push_back(value);
    if (from >= 0 && stream.time[k] - stream.time[from] < kSpan) continue;
    if (from >= 0)
      sizes.rates.push_back((value - stream.values(channel, from)) /
                            (stream.time[k] - stream.time[from]));
    from = k;
  }
}

/// The value below which a share of them lies; nothing of too few.
std::optional<double> quantile(std::vector<double> values, double share) {
  if (std::ssize(values) < kFewest) return std::nullopt;
  const auto at = values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::optional<double> largest(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return quantile(std::move(values), kBeyond);
}

/// "reaches 512 N m; the motor gives 5.1 N m at most"; empty where it may be.
std::string beyond(const Sizes& sizes, const Reach& reach) {
  const auto passes = [](std::optional<double> size, double limit) {
    return size && std::isfinite(limit) && limit > 0.0 && *size > kLargestFactor * limit;
  };
  const std::string& unit = sizes.unit;
  if (const auto size = largest(sizes.values); passes(size, reach.value))
    return fmt::format("reaches {:.3g} {}; {} {:.3g} {} at most", *size, unit, reach.by,
                       reach.value, unit);

  const auto low = quantile(sizes.values, 1.0 - kBeyond), high = quantile(sizes.values, kBeyond);
  if (low && passes(*high - *low, reach.span))
    return fmt::format("spans {:.3g} {}; the joint's range is {:.3g} {}", *high - *low, unit,
                       reach.span, unit);

  if (const auto rate = largest(sizes.rates); passes(rate, reach.rate))
    return fmt::format("moves at {:.3g} {}/s; without load the motor turns at {:.3g} {}/s at most",
                       *rate, unit, reach.rate, unit);
  return {};
}

}  // namespace

std::vector<std::string> values_out_of_reach(const trajectory::Dataset& dataset,
                                             const model::PlanarModel& model) {
  std::map<std::pair<std::string, std::string>, Sizes> all;
  for (const trajectory::Trial& trial : dataset.trials)
    for (const trajectory::Stream& stream : trial.streams)
      for (const std::string& channel : stream.channels)
        if (reach_of(channel, model))
          add(stream, stream.channel(channel), all[{stream.name, channel}]);

  std::vector<std::string> found;
  for (const auto& [name, sizes] : all) {
    const std::string text = beyond(sizes, *reach_of(name.second, model));
    if (!text.empty()) found.push_back(fmt::format("{}.{} {}", name.first, name.second, text));
  }
  return found;
}

}  // namespace jaculus::simulation
