// Forces of the world on body and joints: momentum is force times time.

#include <gtest/gtest.h>

#include <numbers>

#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/model/robot.h"
#include "simulation/support.h"

namespace jaculus::simulation {
namespace {

using namespace test;

TEST(Push, OfTheBodyGivesMomentumAndSpin) {
  model::PlanarModel model = body_with_feet(2.0, 0.05, {});
  model.gravity = 0.0;
  Plant plant = plant_of(model, 0.0);
  Push push{0.1, 0.2, Vec2(3.0, -1.0)};
  push.moment = 0.3;
  plant.pushes = {push};

  const Simulation s =
      simulate(plant, no_controller(), start_at({0, 1, 0}, {0, 0, 0}), options_for(0.5));
  ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
  EXPECT_NEAR(s.v(0, 100), 3.0 * 0.2 / 2.0, 1e-9);
  EXPECT_NEAR(s.v(1, 100), -1.0 * 0.2 / 2.0, 1e-9);
  EXPECT_NEAR(s.v(2, 100), 0.3 * 0.2 / 0.05, 1e-9);
}

TEST(Push, OfAJointGivesItsAngularMomentum) {
  model::PlanarModel model = model::read_robot(source_folder() / "models" / "pendulum").planar;
  model.gravity = 0.0;
  const model::PlanarBody& link = model.bodies.back();
  const model::PlanarMotor& motor = model.motors.front();
  const double inertia = link.inertia + link.mass * link.com.squaredNorm() +
                         motor.gear * motor.gear * motor.rotor_inertia;
  Plant plant = plant_of(model, 0.0);
  Push push{0.1, 0.2};
  push.joint = motor.joint;
  push.torque = 0.4;
  plant.pushes = {push};

  const Simulation s = simulate(plant, no_controller(), start_at({0}, {0}), options_for(0.5));
  ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
  EXPECT_NEAR(s.v(0, 100), 0.4 * 0.2 / inertia, 1e-9 * 0.4 / inertia);
}

TEST(Push, OfHalfASineGivesTwoOverPiOfItsPeak) {
  model::PlanarModel model = body_with_feet(2.0, 0.05, {});
  model.gravity = 0.0;
  Plant plant = plant_of(model, 0.0);
  Push push{0.1, 0.2, Vec2(3.0, 0.0)};
  push.half_sine = true;
  plant.pushes = {push};

  const Simulation s =
      simulate(plant, no_controller(), start_at({0, 1, 0}, {0, 0, 0}), options_for(0.5));
  ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
  EXPECT_NEAR(s.v(0, 100), 2.0 / std::numbers::pi * 3.0 * 0.2 / 2.0, 1e-7);
  EXPECT_DOUBLE_EQ(push.share_at(0.2), 1.0);
}

TEST(Push, OfAJointThatIsNotThereIsRefused) {
  Plant plant = plant_of(body_with_feet(2.0, 0.05, {}), 0.0);
  Push push{0.1, 0.2};
  push.joint = "elbow";
  plant.pushes = {push};
  EXPECT_THROW(
      (void)simulate(plant, no_controller(), start_at({0, 1, 0}, {0, 0, 0}), options_for(0.5)),
      InputError);
}

}  // namespace
}  // namespace jaculus::simulation
