// What dead time takes off a voltage, and how old filtered rates are, by closed forms.

#include "simulation/plant/drive.h"

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/core/installation.h"
#include "jaculus/model/robot.h"
#include "simulation/control/controller_state.h"

namespace jaculus::simulation::detail {
namespace {

/// The tailless robot, whose motors are electric.
Plant minitaur() {
  return nominal_plant(model::read_robot(source_folder() / "models" / "minitaur").planar);
}

/// State of the first motor under a command for it alone.
MotorState state(const Plant& plant, Quantity quantity, double value, double rate) {
  Drive drive(plant, quantity);
  std::vector<Command> commands(plant.model.motors.size());
  commands.front() = {true, value};
  std::vector<double> rates(commands.size(), 0.0);
  rates.front() = rate;
  drive.set(quantity, commands.data(), rates.data(), nullptr);
  return drive.motors.front();
}

TEST(DeadTime, TakesItsShareOfTheBusAgainstTheCurrent) {
  Plant plant = minitaur();
  plant.actuation.dead_time = 0.03;
  const model::PlanarMotor& motor = plant.model.motors.front();
  const double lost = 0.03 * motor.voltage;
  for (const double voltage : {-5.0, -0.4, -0.01, 0.0, 1e-6, 0.3, 0.7, 4.0}) {
    for (const double rate : {-10.0, 0.0, 3.0}) {
      const double emf = motor.torque_constant * motor.gear * rate;
      const double u = motor.resistance * state(plant, Quantity::voltage, voltage, rate).current;
      EXPECT_NEAR(u + lost * std::tanh(u / lost) + emf, voltage, 1e-12) << voltage << ", " << rate;
    }
  }

  // Far from zero current all of it is lost, as from a duty.
  const double u = motor.resistance * state(plant, Quantity::duty, 0.3, 0.0).current;
  EXPECT_NEAR(u, 0.3 * motor.voltage - lost, 1e-6);
}

TEST(DeadTime, IsMadeUpForByALoopOfTheCurrentUpToTheBus) {
  const Plant bare = minitaur();
  Plant plant = bare;
  plant.actuation.dead_time = 0.05;
  const MotorState free = state(bare, Quantity::torque, 1.0, 5.0),
                   made_up = state(plant, Quantity::torque, 1.0, 5.0);
  EXPECT_EQ(made_up.torque, free.torque);
  EXPECT_EQ(made_up.current, free.current);
  const model::PlanarMotor& motor = bare.model.motors.front();
  const double lost = 0.05 * motor.voltage, u = motor.resistance * free.current;
  EXPECT_NEAR(made_up.voltage - free.voltage, lost * std::tanh(u / lost), 1e-12);

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

TEST(DeadTime, OfNoneChangesNothing) {
  const Plant bare = minitaur();
  for (const double voltage : {-3.0, 0.1, 4.0}) {
    const model::PlanarMotor& motor = bare.model.motors.front();
    const MotorState one = state(bare, Quantity::voltage, voltage, 2.0);
    const double emf = motor.torque_constant * motor.gear * 2.0;
    EXPECT_NEAR(motor.resistance * one.current + emf, voltage, 1e-12);
  }
}

TEST(FilteredRates, OfARampAreAsOldAsTheFilterSays) {
  Plant plant = minitaur();
  plant.actuation.rate_filter = 0.004;
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
  const double acceleration = 3.0, gear = plant.model.motors.front().gear;
  double command = 0.0;
  for (int k = 0; k <= 200; ++k) {
    const double t = k / controller.rate_hz;
    const std::vector<double> velocity(position.size(), acceleration * t);
    state.update(t, position.data(), velocity.data());
    command = state.commands(t, position.data(), velocity.data())->value;
  }
  EXPECT_NEAR(command, -gear * acceleration * (0.4 - 0.004), 1e-12);
}

}  // namespace
}  // namespace jaculus::simulation::detail
