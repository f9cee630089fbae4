#include "jaculus/simulation/log_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "jaculus/components/motor.h"
#include "jaculus/core/units.h"
#include "jaculus/trajectory/log_checks.h"
#include "jaculus/trajectory/quantity.h"

namespace jaculus::simulation {
namespace {

using trajectory::Quantity;

// Chosen, not tuned: a share that spikes of a bus do not reach.
constexpr double kBeyond = 0.01;  // of the samples, and at least
constexpr int kFewest = 3;        // of them: one that is bad spoils two rates

/// What a channel may reach: its size, its rate, its span.
struct Reach {
  double value = kInfinity, rate = kInfinity, span = kInfinity;
  std::string_view by;   ///< what sets it
  bool planned = false;  ///< whether plans alone keep below it
};

/// Joint rate without load, or as plans limit it where nothing tells that [rad/s or m/s].
Reach rate_of(const model::PlanarMotor& motor) {
  if (motor.ideal() || !std::isfinite(motor.voltage))
    return {.value = motor.speed_limit / motor.gear, .by = "plans keep below", .planned = true};
  return {.value = motor.voltage / (motor.torque_constant * motor.gear),
          .by = "without load the motor drives it at"};
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
      return Reach{.value = 1.0, .by = "a duty is"};
    case Quantity::velocity:
      return rate_of(motor);
    case Quantity::position: {
      const Bounds range = range_of(model, name.of);
      Reach reach = rate_of(motor);
      reach.rate = std::exchange(reach.value, kInfinity);
      reach.span = range.upper - range.lower;
      return reach;
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
    if (from >= 0 && stream.time[k] - stream.time[from] < trajectory::kLogSpan) continue;
    if (from >= 0)
      sizes.rates.push_back((value - stream.values(channel, from)) /
                            (stream.time[k] - stream.time[from]));
    from = k;
  }
}

/// The value that a share of them passes, and some at least; nothing of too few.
std::optional<double> passed(std::vector<double> values) {
  const auto n = std::ssize(values);
  const auto beyond = std::max<std::ptrdiff_t>(
      kFewest, static_cast<std::ptrdiff_t>(std::ceil(kBeyond * static_cast<double>(n))));
  if (n <= beyond) return std::nullopt;
  const auto at = values.end() - beyond - 1;
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::optional<double> largest(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return passed(std::move(values));
}

/// Between what a share of them passes at either end.
std::optional<double> span_of(std::vector<double> values) {
  const auto high = passed(values);
  for (double& value : values) value = -value;
  const auto low = passed(std::move(values));
  return high && low ? std::optional(*high + *low) : std::nullopt;
}

/// "12 N m", "1" of what has no unit.
std::string with_unit(double value, const std::string& unit) {
  return fmt::format("{:.3g}{}", value, after_number(unit));
}

/// "reaches 512 N m; the motor gives 5.1 N m at most"; nothing where it may be.
std::optional<OutOfReach> beyond(const Sizes& sizes, const Reach& reach) {
  const auto passes = [](std::optional<double> size, double limit) {
    return size && std::isfinite(limit) && limit > 0.0 &&
           *size > trajectory::kLargestLogFactor * limit;
  };
  const std::string& unit = sizes.unit;
  if (const auto size = largest(sizes.values); passes(size, reach.value))
    return OutOfReach{fmt::format("reaches {}; {} {} at most", with_unit(*size, unit), reach.by,
                                  with_unit(reach.value, unit)),
                      !reach.planned};
  if (const auto rate = largest(sizes.rates); passes(rate, reach.rate))
    return OutOfReach{fmt::format("moves at {}/s; {} {}/s at most", with_unit(*rate, unit),
                                  reach.by, with_unit(reach.rate, unit)),
                      !reach.planned};
  if (const auto span = span_of(sizes.values); passes(span, reach.span))
    return OutOfReach{fmt::format("spans {}; the joint's range is {}", with_unit(*span, unit),
                                  with_unit(reach.span, unit)),
                      false};
  return std::nullopt;
}

}  // namespace

std::vector<OutOfReach> values_out_of_reach(const trajectory::Dataset& dataset,
                                            const model::PlanarModel& model) {
  std::map<std::pair<std::string, std::string>, Sizes> all;
  for (const trajectory::Trial& trial : dataset.trials)
    for (const trajectory::Stream& stream : trial.streams)
      for (const std::string& channel : stream.channels)
        if (reach_of(channel, model))
          add(stream, stream.channel(channel), all[{stream.name, channel}]);

  std::vector<OutOfReach> found;
  for (const auto& [name, sizes] : all) {
    auto own = beyond(sizes, *reach_of(name.second, model));
    if (!own) continue;
    own->text = fmt::format("{}.{} {}", name.first, name.second, own->text);
    found.push_back(std::move(*own));
  }
  return found;
}

}  // namespace jaculus::simulation
