#include "simulation/plant/drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>

#include "jaculus/core/error.h"

namespace jaculus::simulation::detail {

namespace {

constexpr double kBrownOut = 0.3;  // share of the open voltage below which the bus is not followed

/// Whether a limit took more than rounding off a command; plans lie on their limits.
bool cut(double command, double taken) {
  return std::abs(command - taken) > 1e-6 * (1.0 + std::abs(taken));
}

/// What dead time takes of a voltage while u = R i is on the winding, at most V_d [V].
double lost_to_dead_time(double u, double most) {
  return most == 0.0 ? 0.0 : most * std::tanh(u / most);
}

/// The root u of u + V_d tanh(u/V_d) = voltage, by Newton's method in units of V_d: the function is
/// odd, and of positive numbers concave, so that steps from below come from below.
double on_winding(double voltage, double most) {
  if (most == 0.0) return voltage;
  const double y = std::abs(voltage) / most;
  double x = std::max(0.5 * y, y - 1.0);
  for (int k = 0; k < 20; ++k) {
    const double level = std::tanh(x), step = (y - x - level) / (2.0 - level * level);
    x += step;
    if (std::abs(step) <= 1e-15 * y) break;
  }
  return std::copysign(most * x, voltage);
}

/// An ideal motor has none, and is never asked.
components::MagneticSaturation saturation_of(const model::PlanarMotor& motor) {
  if (motor.ideal()) return {1.0, 0.0};
  return {motor.saturation_linear, motor.saturation_cubic};
}

}  // namespace

Drive::Drive(const Plant& plant, Quantity quantity)
    : resistance_(plant.battery.resistance), open_voltage_(kInfinity) {
  if (!(plant.actuation.dead_time >= 0.0 && plant.actuation.dead_time < 1.0))
    throw InputError(
        fmt::format("dead_time: {} given; allowed: 0 to 1, without 1", plant.actuation.dead_time));
  warm_ = plant.winding.heat != 0.0 || plant.winding.initial != 0.0;
  for (const model::PlanarMotor& motor : plant.model.motors) {
    if (motor.ideal() && quantity != Quantity::torque)
      throw InputError(fmt::format(
          "motor of '{}': it is ideal, so it takes torque, no duty or voltage", motor.joint));
    const auto scale = plant.actuation.torque_scale.find(motor.joint);
    const double ratio = motor.gear * motor.efficiency;
    data_.push_back(
        {motor, saturation_of(motor), ratio,
         motor.ideal() ? motor.torque_limit : components::largest_joint_torque(motor).value / ratio,
         scale == plant.actuation.torque_scale.end() ? 1.0 : scale->second,
         plant.actuation.dead_time});
    if (!motor.ideal()) open_voltage_ = std::min(open_voltage_, motor.voltage);
  }
  motors.resize(data_.size());
}

void Drive::change(const PlantChanges& changes) {
  for (std::size_t m = 0; m < data_.size(); ++m) data_[m].changed = changes.torque_scale[m];
  drop_ = changes.bus_drop;
}

MotorState Drive::one(std::size_t m, Quantity quantity, const Command& command, double rate,
                      double temperature, double bus) const {
  if (!command.on) return {};
  const Motor& motor = data_[m];
  const model::PlanarMotor& d = motor.data;
  if (d.ideal()) {
    const double t = std::clamp(command.value, -motor.largest, motor.largest);
    return {.torque = motor.scale * motor.changed * motor.ratio * t,
            .limited = cut(command.value, t)};
  }

  const double strength = 1.0 - 0.001 * temperature;
  const double resistance = warm_ ? d.resistance * (1.0 + 0.0039 * temperature) : d.resistance;
  const double emf = (warm_ ? d.torque_constant * strength : d.torque_constant) * d.gear * rate;
  const double most_lost = motor.dead_time == 0.0 ? 0.0 : motor.dead_time * bus;
  const auto torque_at = [&](double voltage) {
    const double t = motor.saturation.torque(on_winding(voltage - emf, most_lost) / resistance);
    return warm_ ? t * strength : t;
  };

  // Of a torque, or of what a driver that believes in a cold motor takes for it.
  const auto current_of_cold = [&](double t) {
    return t * (d.saturation_linear + d.saturation_cubic * t * t);
  };

  const auto voltage_of = [&](double current) {
    const double u = resistance * current;
    return u + lost_to_dead_time(u, most_lost) + emf;
  };

  const auto current_of = [&](double t) { return current_of_cold(warm_ ? t / strength : t); };
  // limits are of the current
  const double largest = warm_ ? motor.largest * strength : motor.largest;
  MotorState state;
  double t = command.value;
  if (quantity == Quantity::torque) {
    t = std::clamp(t, -motor.largest, motor.largest);
    state.limited = cut(command.value, t);
    state.current = current_of_cold(t);
    if (warm_) t *= strength;
    state.voltage = voltage_of(state.current);
    if (std::abs(state.voltage) > bus) {
      state.voltage = std::copysign(bus, state.voltage);
      const double clamped = std::clamp(torque_at(state.voltage), -largest, largest);
      state.limited = state.limited || cut(t, clamped);
      t = clamped;
      state.current = current_of(t);
    }
  } else {
    const double wanted = quantity == Quantity::duty ? command.value * bus : command.value;
    state.voltage = std::clamp(wanted, -bus, bus);
    const double free = torque_at(state.voltage);
    t = std::clamp(free, -largest, largest);
    state.limited = cut(free, t) || cut(wanted, state.voltage);
    state.current = current_of(t);
    if (t != free) state.voltage = voltage_of(state.current);
  }

  state.lost = lost_to_dead_time(resistance * state.current, most_lost);
  state.torque = motor.scale * motor.changed * motor.ratio * t;
  return state;
}

double Drive::set_at(double bus, Quantity quantity, const Command* commands, const double* rates,
                     const double* temperatures) {
  double power = 0.0;
  for (std::size_t m = 0; m < data_.size(); ++m) {
    const double own = data_[m].data.voltage - drop_, limit = std::min(bus, own);
    motors[m] =
        one(m, quantity, commands[m], rates[m], temperatures == nullptr ? 0.0 : temperatures[m],
            resistance_ == 0.0 ? own : limit);
    power += data_[m].data.count * (motors[m].voltage - motors[m].lost) * motors[m].current;
  }
  return power;
}

double Drive::set(Quantity quantity, const Command* commands, const double* rates,
                  const double* temperatures) {
  const double open = open_voltage_ - drop_;
  if (resistance_ == 0.0 || std::isinf(open)) {
    set_at(open, quantity, commands, rates, temperatures);
    return open;
  }

  // V_0 - R_b P(V)/V - V falls with V near the working point. Motors at their voltage limit take
  // less at less voltage, so that there is one even below half of V_0, where a battery gives no
  // more power.
  const auto gap = [&](double bus) {
    return open - resistance_ * set_at(bus, quantity, commands, rates, temperatures) / bus - bus;
  };

  double low = kBrownOut * open, high = open;
  double at_low = gap(low), at_high = gap(high);
  // braking motors feed it
  while (at_high > 0.0 && high < 4.0 * open) at_high = gap(high *= 1.25);
  double bus = at_low <= 0.0 ? low : high;
  if (at_low > 0.0 && at_high < 0.0) {
    std::uintmax_t iterations = 60;
    const auto close = [&](double a, double b) { return b - a <= 1e-13 * open; };
    const auto root =
        boost::math::tools::toms748_solve(gap, low, high, at_low, at_high, close, iterations);
    bus = 0.5 * (root.first + root.second);
  }
  set_at(bus, quantity, commands, rates, temperatures);
  return bus;
}

}  // namespace jaculus::simulation::detail
