// A logged current drives a joint through the motor's own law, not as a torque.

#include <gtest/gtest.h>

#include "jaculus/components/motor.h"
#include "jaculus/model/robot.h"
#include "jaculus/simulation/controller.h"
#include "jaculus/simulation/simulate.h"
#include "simulation/support.h"
#include "support/input_error.h"

namespace jaculus::simulation {
namespace {

using namespace test;

/// A dataset whose logs drive one joint.
trajectory::Dataset logged(const std::string& joint, Quantity quantity, double value) {
  trajectory::Dataset dataset;
  dataset.folder = "swing";
  dataset.controller.kind = trajectory::ControllerKind::measured;
  dataset.controller.input = quantity;
  dataset.script = trajectory::InputScript{
      quantity, Vector::LinSpaced(2, 0.0, 0.1), {joint}, Matrix::Constant(1, 2, value)};
  return dataset;
}

model::PlanarModel robot(const std::string& name) {
  return model::read_robot(model::find_robot(name, "")).planar;
}

/// Everything but the tail held, as on a bench.
model::PlanarModel tail_bench() {
  model::PlanarModel model = robot("minitaur_tail");
  for (const model::Coordinate& c : std::vector<model::Coordinate>(model.coordinates))
    if (c.name != "tail") model = model::lock(model, c.name, c.name == "z" ? 1.0 : 0.5);
  return model;
}

TEST(MeasuredCurrent, BecomesTheTorqueThatTheMotorMakesOfIt) {
  const model::PlanarModel model = robot("minitaur_tail");
  for (const model::PlanarMotor& motor : model.motors) {
    for (const double current : {-25.0, 0.0, 7.0, 30.0}) {
      const Controller c =
          stated_controller(logged(motor.joint, Quantity::current, current), model, {});
      EXPECT_EQ(c.quantity, Quantity::torque);
      const double joint_torque = c.reference.feedforward(0, 0) * motor.gear * motor.efficiency;
      EXPECT_NEAR(components::motor_current(motor, joint_torque), current, 1e-10) << motor.joint;
    }
  }
}

TEST(MeasuredCurrent, IsTheCurrentThatTheSimulatedMotorDraws) {
  const model::PlanarModel model = tail_bench();
  const Plant plant = nominal_plant(model);
  Controller c = stated_controller(logged("tail", Quantity::current, 6.0), model, {});
  c.rate_hz = kInfinity;
  const Simulation s = simulate(plant, c, {Vector::Zero(1), Vector::Zero(1)}, options_for(0.05, 6));
  ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
  const auto m = model.motor_index("tail");
  for (Eigen::Index k = 0; k < s.time.size(); ++k) {
    EXPECT_NEAR(s.current(m, k), 6.0, 1e-10);
    EXPECT_NEAR(components::motor_current(model.motors[m], s.torque(m, k)), 6.0, 1e-10);
  }
}

TEST(MeasuredCurrent, NeedsAMotorThatIsElectric) {
  const std::string message = input_error_of([] {
    (void)stated_controller(logged("swing", Quantity::current, 1.0), robot("pendulum"), {});
  });
  EXPECT_TRUE(holds(message, "dataset.yaml: controller.input: current given"));
  EXPECT_TRUE(holds(message, "'swing' is ideal"));
  EXPECT_TRUE(holds(message, "allowed: torque"));
  EXPECT_NO_THROW(
      (void)stated_controller(logged("swing", Quantity::torque, 1.0), robot("pendulum"), {}));
}

}  // namespace
}  // namespace jaculus::simulation
