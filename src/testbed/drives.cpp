#include "testbed/drives.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/error.h"

namespace jaculus::testbed {

using trajectory::Quantity;

double current_of_torque(const model::PlanarMotor& motor, double torque) {
  return motor.saturation_linear * torque + motor.saturation_cubic * torque * torque * torque;
}

double torque_of_current(const model::PlanarMotor& motor, double current) {
  // The cubic rises and bends away from the axis, so Newton from the linear root comes down to it
  // without overshoot.
  double torque = current / motor.saturation_linear;
  for (int i = 0; i < 50; ++i) {
    const double error = current_of_torque(motor, torque) - current;
    const double step =
        error / (motor.saturation_linear + 3.0 * motor.saturation_cubic * torque * torque);
    torque -= step;
    if (std::abs(step) < 1e-15 * (1.0 + std::abs(torque))) break;
  }
  return torque;
}

Drives::Drives(const RobotFiles& files, const Changes& changes, Quantity quantity)
    : quantity_(quantity) {
  current_limit_ = changes.current_limit;
  battery_resistance_ = changes.battery_resistance;
  heat_ = changes.winding_heat;
  battery_ = kInfinity;

  for (const testbed::Drive& drive : files.drives) {
    const auto own = changes.joint_torque_constant.find(drive.planar);
    const double of_joint = own == changes.joint_torque_constant.end() ? 1.0 : own->second;
    all_.push_back(
        {drive.motor, changes.torque_constant * of_joint * drive.constant, changes.winding_rise});
    if (drive.motor.ideal()) {
      if (quantity == Quantity::torque) continue;
      throw InputError(
          fmt::format("motor of '{}' takes torque alone; allowed: a controller of quantity torque",
                      drive.planar));
    }
    battery_ = std::min(battery_, drive.motor.voltage);
  }

  battery_ = std::min(battery_, changes.voltage_limit);
}

DriveState Drives::one(const One& drive, double command, double rate, double bus) const {
  const model::PlanarMotor& motor = drive.motor;
  DriveState state;
  if (std::isnan(command)) return state;

  const double gearing = motor.gear * motor.efficiency;
  if (motor.ideal()) {
    state.torque =
        drive.constant * gearing * std::clamp(command, -motor.torque_limit, motor.torque_limit);
    return state;
  }

  const double strength = drive.constant * (1.0 - 0.001 * drive.temperature);
  const double resistance = motor.resistance * (1.0 + 0.0039 * drive.temperature);
  const double back_emf = strength * motor.torque_constant * motor.gear * rate;
  double current = 0.0;
  if (quantity_ == Quantity::torque) {
    const double asked = std::clamp(command, -motor.torque_limit, motor.torque_limit);
    current = current_of_torque(motor, asked);
  } else {
    const double wanted = quantity_ == Quantity::duty ? command * bus : command;
    current = (std::clamp(wanted, -bus, bus) - back_emf) / resistance;
  }

  const double limit = std::min(motor.current_limit, current_limit_);
  current = std::clamp(current, -limit, limit);
  const double saturated = current_of_torque(motor, motor.torque_limit);
  if (std::isfinite(saturated)) current = std::clamp(current, -saturated, saturated);
  current = std::clamp(current, (-bus - back_emf) / resistance, (bus - back_emf) / resistance);
  state.current = current;
  state.voltage = resistance * current + back_emf;
  state.torque = gearing * strength * torque_of_current(motor, current);
  return state;
}

double Drives::run(const std::vector<double>& commands, const std::vector<double>& rates,
                   std::vector<DriveState>& states) const {
  states.resize(all_.size());
  double bus = battery_;
  for (int pass = 0; pass < 100; ++pass) {
    double power = 0.0;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      states[i] = one(all_[i], commands[i], rates[i], bus);
      power += states[i].voltage * states[i].current;
    }
    if (battery_resistance_ == 0.0 || std::isinf(battery_)) break;
    const double next = std::max(0.3 * battery_, battery_ - battery_resistance_ * power / bus);
    const double change = next - bus;
    bus += 0.7 * change;  // the undamped iteration swings where the battery is weak
    if (std::abs(change) < 1e-11 * battery_) break;
  }
  return bus;
}

void Drives::warm(const std::vector<DriveState>& states, double seconds) {
  if (heat_ == 0.0) return;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    const double resistance = all_[i].motor.resistance * (1.0 + 0.0039 * all_[i].temperature);
    all_[i].temperature += heat_ * states[i].current * states[i].current * resistance * seconds;
  }
}

}  // namespace jaculus::testbed
