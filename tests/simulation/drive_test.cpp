// What dead time takes off a voltage, and how old filtered rates are, by closed forms.

#include "simulation/plant/drive.h"

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/model/robot.h"
#include "simulation/control/controller_state.h"

namespace jaculus::simulation::detail {
namespace {

/// The tailless robot, whose motors are electric.
Plant minitaur() {
  return nominal_plant(model::read_robot(source_folder() / "models" / "minitaur").planar);
}

/// State of the first motor under a command for it alone, its winding so much warmer.
MotorState state(const Plant& plant, Quantity quantity, double value, double rate,
                 double temperature = 0.0) {
  Drive drive(plant, quantity);
  std::vector<Command> commands(plant.model.motors.size());
  commands.front() = {true, value};
  std::vector<double> rates(commands.size(), 0.0), temperatures(commands.size(), temperature);
  rates.front() = rate;
  drive.set(quantity, commands.data(), rates.data(), temperatures.data());
  return drive.motors.front();
}

Plant with_dead_time(double share) {
  Plant plant = minitaur();
  plant.actuation.dead_time = share;
  return plant;
}

double emf_of(const model::PlanarMotor& motor, double rate) {
  return motor.torque_constant * motor.gear * rate;
}

TEST(DeadTime, TakesItsShareOfTheBusAgainstTheCurrent) {
  const Plant plant = with_dead_time(0.03);
  const model::PlanarMotor& motor = plant.model.motors.front();
  const double lost = 0.03 * motor.voltage;
  for (const double voltage : {-5.0, -0.4, -0.01, 0.0, 1e-6, 0.3, 0.7, 4.0}) {
    for (const double rate : {-10.0, 0.0, 3.0}) {
      const MotorState at = state(plant, Quantity::voltage, voltage, rate);
      const double u = motor.resistance * at.current;
      EXPECT_NEAR(u + lost * std::tanh(u / lost) + emf_of(motor, rate), voltage, 1e-12)
          << voltage << ", " << rate;
      EXPECT_NEAR(at.lost, lost * std::tanh(u / lost), 1e-12);
    }
  }

  // Far from zero current all of it is lost, as from a duty.
  const double u = motor.resistance * state(plant, Quantity::duty, 0.3, 0.0).current;
  EXPECT_NEAR(u, 0.3 * motor.voltage - lost, 1e-6);
}

TEST(DeadTime, IsOfTheWarmWindingToo) {
  Plant plant = with_dead_time(0.03);
  plant.winding.initial = 60.0;
  const model::PlanarMotor& motor = plant.model.motors.front();
  const double lost = 0.03 * motor.voltage, resistance = motor.resistance * (1.0 + 0.0039 * 60.0);
  const MotorState at = state(plant, Quantity::voltage, 4.0, 3.0, 60.0);
  const double u = resistance * at.current;
  EXPECT_NEAR(u + lost * std::tanh(u / lost) + 0.94 * emf_of(motor, 3.0), 4.0, 1e-12);
}

TEST(DeadTime, IsMadeUpForByALoopOfTheCurrentUpToTheBus) {
  const Plant bare = minitaur(), plant = with_dead_time(0.05);
  const model::PlanarMotor& motor = bare.model.motors.front();
  const double lost = 0.05 * motor.voltage;
  const MotorState free = state(bare, Quantity::torque, 1.0, 5.0),
                   made_up = state(plant, Quantity::torque, 1.0, 5.0);
  const double u = motor.resistance * free.current;
  EXPECT_EQ(made_up.torque, free.torque);
  EXPECT_EQ(made_up.current, free.current);
  EXPECT_NEAR(made_up.voltage - free.voltage, lost * std::tanh(u / lost), 1e-12);

  // What the loop tells is what a driver that is told a voltage makes that current of.
  for (double rate = -60.0; rate < 160.0; rate += 7.0) {
    for (const double torque : {-1.0, 0.02, 1.0}) {
      const MotorState one = state(plant, Quantity::torque, torque, rate);
      EXPECT_NEAR(state(plant, Quantity::voltage, one.voltage, rate).current, one.current, 1e-9)
          << rate << ", " << torque;
    }
  }

  // Where the bus ends the torque falls off without a jump.
  const auto torque = [&](double rate) { return state(plant, Quantity::torque, 1.0, rate).torque; };
  double limit = 0.0;
  for (double high = motor.voltage / (motor.torque_constant * motor.gear), low = 0.0;
       high - low > 1e-12;) {
    limit = 0.5 * (low + high);
    (state(plant, Quantity::torque, 1.0, limit).limited ? high : low) = limit;
  }
  EXPECT_GT(limit, 0.0);
  EXPECT_NEAR(torque(limit - 1e-9), torque(limit + 1e-9), 1e-6);
  EXPECT_LT(torque(limit + 0.5), torque(limit - 0.5) - 1e-3);
}

TEST(DeadTime, HoldsWhereALimitOfTheCurrentBinds) {
  const Plant plant = with_dead_time(0.05);
  const MotorState at = state(plant, Quantity::duty, 0.9, -40.0);
  const model::PlanarMotor& motor = plant.model.motors.front();
  ASSERT_TRUE(at.limited);
  const double lost = 0.05 * motor.voltage, u = motor.resistance * at.current;
  EXPECT_NEAR(at.voltage, u + emf_of(motor, -40.0) + lost * std::tanh(u / lost), 1e-12);
}

TEST(DeadTime, TakesNoPowerFromTheBattery) {
  Plant bare = minitaur(), plant = with_dead_time(0.05);
  bare.battery.resistance = plant.battery.resistance = 0.05;
  const auto bus = [](const Plant& of, MotorState& first) {
    Drive drive(of, Quantity::torque);
    const std::vector<Command> commands(of.model.motors.size(), {true, 1.0});
    const std::vector<double> rates(commands.size(), 12.0);
    const double voltage = drive.set(Quantity::torque, commands.data(), rates.data(), nullptr);
    first = drive.motors.front();
    return voltage;
  };

  // A loop keeps the current, so that the winding's power is the same.
  MotorState none, with;
  const double without = bus(bare, none), sagged = bus(plant, with);
  const model::PlanarMotor& motor = bare.model.motors.front();
  EXPECT_LT(without, motor.voltage - 0.1);
  EXPECT_NEAR(sagged, without, 1e-9);
  EXPECT_EQ(none.lost, 0.0);

  // What is lost is a share of the bus as it is.
  const double most = 0.05 * sagged;
  EXPECT_NEAR(with.lost, most * std::tanh(motor.resistance * with.current / most), 1e-9);
}

TEST(DeadTime, LeavesABatteryThatSagsOneVoltage) {
  Plant plant = with_dead_time(0.05);
  plant.battery.resistance = 0.03;
  const auto bus = [&](double voltage, double rate) {
    Drive drive(plant, Quantity::voltage);
    const std::vector<Command> commands(plant.model.motors.size(), {true, voltage});
    const std::vector<double> rates(commands.size(), rate);
    return drive.set(Quantity::voltage, commands.data(), rates.data(), nullptr);
  };
  // Driven forwards, where the battery gives all the power that is asked for.
  constexpr double kStep = 0.02;
  for (const double voltage : {6.0, 11.9, 14.0})
    for (double rate = 0.0; rate < 150.0; rate += kStep)
      EXPECT_LT(std::abs(bus(voltage, rate + kStep) - bus(voltage, rate)), 0.02)
          << voltage << ", " << rate;
}

TEST(DeadTime, OfNoneChangesNothing) {
  const Plant bare = minitaur();
  const model::PlanarMotor& motor = bare.model.motors.front();
  for (const double voltage : {-3.0, 0.1, 4.0}) {
    const MotorState one = state(bare, Quantity::voltage, voltage, 2.0);
    EXPECT_EQ(one.voltage, voltage);
    EXPECT_EQ(one.lost, 0.0);
    EXPECT_NEAR(motor.resistance * one.current + emf_of(motor, 2.0), voltage, 1e-12);
  }
}

TEST(DeadTime, OfAWholePeriodIsRefused) {
  for (const double share : {-0.01, 1.0})
    EXPECT_THROW(state(with_dead_time(share), Quantity::voltage, 1.0, 0.0), InputError);
}

TEST(FilteredRates, OfARampLagByTheTimeConstant) {
  Plant plant = minitaur();
  plant.actuation.velocity_filter = 0.004;
  Controller controller;
  controller.quantity = Quantity::torque;
  controller.rate_hz = 500.0;
  controller.after_end = AfterEnd::repeat;
  controller.reference.motors = {plant.model.motors.front().joint};
  controller.reference.time = Vector::LinSpaced(2, 0.0, 1.0);
  controller.reference.duration = 1.0;
  controller.reference.velocity = Matrix::Zero(1, 2);
  controller.kp = Vector::Zero(1);
  controller.kd = Vector::Constant(1, 1.0);

  ControllerState state(plant, controller);
  const std::vector<double> position(plant.model.motors.size(), 0.0);
  const double initial = 10.0, acceleration = 3.0, gear = plant.model.motors.front().gear;
  const double period = 1.0 / controller.rate_hz, late = 0.004;
  double lag = 0.0;  // of what is read: none at first, then towards T
  for (int k = 0; k <= 200; ++k) {
    const double t = k * period;
    const std::vector<double> velocity(position.size(), initial + acceleration * t);
    state.update(t, position.data(), velocity.data());
    const double command = state.commands(t, position.data(), velocity.data())->value;
    EXPECT_NEAR(command, -gear * (initial + acceleration * (t - lag)), 1e-10) << k;
    lag = (lag + period) * late / (late + period);
  }
  EXPECT_NEAR(lag, late, 1e-12);
}

}  // namespace
}  // namespace jaculus::simulation::detail
