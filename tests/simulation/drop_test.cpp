// The self-righting drop: body and tail on a pivot, the tail at full voltage against its stop.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "jaculus/model/robot.h"
#include "simulation/support.h"

namespace jaculus::simulation {
namespace {

using namespace test;

constexpr double kDegree = std::numbers::pi / 180.0;

/// A voltage at the tail from the start on.
Controller full_voltage(const model::PlanarModel& model, double volts) {
  Controller c = no_controller();
  c.quantity = Quantity::voltage;
  c.after_end = AfterEnd::repeat;
  c.reference.motors = {"tail"};
  c.reference.time = Vector::Zero(1);
  c.reference.feedforward = Matrix::Constant(1, 1, volts);
  EXPECT_GE(model.motor_index("tail"), 0);
  return c;
}

Simulation drop(const model::Robot& robot, double duration) {
  Plant plant = nominal_plant(robot.planar);
  plant.stops = {{"tail", {-kInfinity, std::numbers::pi}, 0.0}};
  SimulationOptions options = options_for(duration, 2);
  return simulate(plant, full_voltage(robot.planar, 16.0), start_at({0, 0}, {0, 0}), options);
}

TEST(Drop, MeetsTheFiguresOfTheTwoBodyEquations) {
  const model::Robot robot = model::read_robot(model::find_robot("self_righting", ""));
  const double stop = 0.17673;
  const Simulation s = drop(robot, std::sqrt(2.0 * 0.5 / kGravity));
  ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
  EXPECT_NEAR(event_time(s, EventKind::stop, "tail"), stop, 1e-5);
  EXPECT_NEAR(s.q(0, 1), -93.701 * kDegree, 2e-3 * kDegree);  // at the end of the fall
  EXPECT_NEAR(s.q(1, 1), std::numbers::pi, 1e-6);

  const double at = event_time(s, EventKind::stop, "tail");
  const Simulation before = drop(robot, at - 1e-9), after = drop(robot, at + 1e-7);
  EXPECT_NEAR(before.q(0, 1), -55.248 * kDegree, 2e-3 * kDegree);
  EXPECT_NEAR(before.v(1, 1), 25.28, 0.005);
  EXPECT_NEAR(before.v(0, 1), -10.07, 0.005);
  EXPECT_NEAR(after.v(0, 1), -4.98, 0.005);
  EXPECT_NEAR(after.v(1, 1), 0.0, 1e-9);
}

TEST(Drop, WithoutDragTheBodyStopsWhereTheTailDoes) {
  const std::vector<model::Override> none = {{"tail.drag.kind", yaml::Node::parse("none", "test")}};
  const model::Robot robot = model::read_robot(model::find_robot("self_righting", ""), none);
  const Simulation s = drop(robot, std::sqrt(2.0 * 0.5 / kGravity));
  EXPECT_NEAR(event_time(s, EventKind::stop, "tail"), 0.14643, 1e-5);
  EXPECT_NEAR(s.q(0, 1), -36.250 * kDegree, 2e-3 * kDegree);
  EXPECT_NEAR(s.v(0, 1), 0.0, 1e-6);
}

TEST(Drop, FreeBodyFallsAndTurnsAsThePinnedOne) {
  // A pivot at the centre of mass of a body that falls free: gravity changes nothing but the fall
  // where the tail has no mass.
  model::Robot robot;  // without stops
  robot.planar = model::read_robot(model::find_robot("self_righting", "")).planar;
  const Simulation pinned = drop(robot, 0.1);
  model::PlanarModel free = robot.planar;
  free.base_free = {true, true, true};
  free.gravity = kGravity;
  free.bodies[1].inertia += free.bodies[1].mass * free.bodies[1].com.squaredNorm();
  free.bodies[1].mass = 0.0;
  free.coordinates.clear();
  free = with_coordinates(free, {"tail"});
  Plant plant = nominal_plant(free);
  plant.drag_smoothing = nominal_plant(robot.planar).drag_smoothing;
  const Simulation s = simulate(plant, full_voltage(free, 16.0),
                                start_at({0, 1, 0, 0}, {0, 0, 0, 0}), options_for(0.1, 2));
  ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
  EXPECT_NEAR(s.q(1, 1), 1.0 - 0.5 * kGravity * 0.01, 1e-9);
  EXPECT_NEAR(s.q(2, 1), pinned.q(0, 1), 1e-8);
  EXPECT_NEAR(s.q(3, 1), pinned.q(1, 1), 1e-8);
}

}  // namespace
}  // namespace jaculus::simulation
