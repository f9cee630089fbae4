// Self-righting by the two bodies on a pin against the planar robot of the leap, dropped with its legs in a stance pose.
//
// The pin of the two-body equations is at rest. That is exact for a robot in free fall where turning the tail moves no mass: a tail
// balanced about its pivot, which then loads the body as a point mass there. There the two must agree, saturation and back-EMF
// included. A tail whose mass lies along it pulls the pivot with it, and drag pushes the whole robot: there they must not.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/model/robot.h"
#include "jaculus/simulation/simulate.h"
#include "jaculus/studies/reorientation.h"

namespace jaculus {
namespace {

constexpr double kStroke = std::numbers::pi, kBack = -0.5 * std::numbers::pi, kDuration = 0.12, kVoltage = 16.0;

/// Minitaur with its tail free and its legs held at 1 rad of extension, straight down: one body and a tail.
PlanarModel minitaur() {
  const std::filesystem::path models = std::filesystem::path(JACULUS_SOURCE_DIR) / "models";
  PlanarModel model = read_robot(models / "minitaur_tail").planar;
  for (const char* leg : {"front", "rear"}) {
    model = lock(model, std::string(leg) + "_extension", 1.0);
    model = lock(model, std::string(leg) + "_angle", 0.0);
  }
  for (PlanarMotor& motor : model.motors) {
    motor.rotor_inertia = 0.0;  // the two-body equations know none
    motor.current_limit = motor.torque_limit = kInfinity;
  }
  for (PlanarDrag& drag : model.drags) drag.kind = DragKind::none;
  return model;
}

PlanarBody& tail_of(PlanarModel& model) { return model.bodies[static_cast<std::size_t>(model.body_of_joint("tail"))]; }

/// Pitch inertia of the whole robot about its centre of mass with the tail held straight back [kg m^2].
double whole_inertia(const PlanarModel& model) {
  const PlanarModel held = lock(model, "tail", kBack);
  const AbsoluteTree tree(held);
  Motion motion(tree);
  EXPECT_TRUE(set_configuration(tree, Vector::Zero(held.size()), motion));
  const Matrix M = mass_matrix(tree, motion);
  return M(2, 2) - (M(0, 2) * M(0, 2) + M(1, 2) * M(1, 2)) / M(0, 0);
}

/// Pitch and tail angle of the planar robot after kDuration in the air, the tail's motor at full voltage.
std::pair<double, double> drop(const PlanarModel& model) {
  Controller controller;
  controller.quantity = CommandQuantity::voltage;
  controller.rate_hz = kInfinity;
  controller.after_end = AfterEnd::repeat;
  controller.kp = controller.kd = Vector::Zero(1);
  controller.reference.motors = {"tail"};
  controller.reference.time = Vector::LinSpaced(2, 0.0, 2.0 * kDuration);
  controller.reference.feedforward = Matrix::Constant(1, 2, kVoltage);
  controller.reference.duration = 2.0 * kDuration;
  StartState start{Vector::Zero(model.size()), Vector::Zero(model.size())};
  start.q[model.coordinate_index("z")] = 5.0;
  start.q[model.coordinate_index("tail")] = kBack;
  SimulationOptions options;
  options.duration = kDuration;
  options.sample_times = Vector::LinSpaced(2, 0.0, kDuration);
  options.relative_tolerance = 1e-10;
  options.absolute_tolerance = 1e-12;
  const Simulation s = simulate(nominal_plant(model), controller, start, options);
  EXPECT_EQ(s.status, SimulationStatus::done) << s.message;
  return {s.q(model.coordinate_index("pitch"), 1), s.q(model.coordinate_index("tail"), 1) - kBack};
}

ReorientationResult two_bodies(const PlanarModel& model, double body_inertia, double tail_inertia) {
  ReorientationCase c = paper_case();
  c.body_inertia = body_inertia;
  c.tail_inertia = tail_inertia;
  c.motor = model.motors.front();
  c.motor.voltage = kVoltage;
  c.drag.kind = DragKind::none;
  c.initial_tail_angle = kBack;
  c.stroke = kStroke;
  c.duration = kDuration;
  const ReorientationResult result = simulate_reorientation(c, 1e-9);
  EXPECT_TRUE(result.converged);
  EXPECT_FALSE(result.stop.has_value());
  return result;
}

/// The tail with its mass drawn to the pivot and its inertia about it kept.
PlanarModel balanced() {
  PlanarModel model = minitaur();
  PlanarBody& tail = tail_of(model);
  tail.inertia += tail.mass * tail.com.squaredNorm();
  tail.com = Vec2::Zero();
  return model;
}

TEST(SecondModel, AgreesWhereTheTailIsBalancedAboutItsPivot) {
  PlanarModel model = balanced();
  const double tail = tail_of(model).inertia;
  const auto [pitch, swing] = drop(model);
  const ReorientationResult pinned = two_bodies(model, whole_inertia(model) - tail, tail);
  EXPECT_GT(swing, 0.5);
  EXPECT_NEAR(pitch, pinned.body_angle, 1e-6);
  EXPECT_NEAR(swing, pinned.tail_angle, 1e-6);
}

TEST(SecondModel, DiffersWhereTheTailsMassPullsThePivotAlong) {
  PlanarModel model = minitaur();
  const PlanarBody& link = tail_of(model);
  const double tail = link.inertia + link.mass * link.com.squaredNorm();
  const auto [pitch, swing] = drop(model);
  const ReorientationResult pinned = two_bodies(model, whole_inertia(balanced()) - tail, tail);
  // The same motor and voltage; the ratio of the rotations is what the free pivot changes.
  EXPECT_GT(std::abs(pitch / swing - pinned.body_angle / pinned.tail_angle), 1e-3);
  EXPECT_LT(pitch / swing, 0.0);
  EXPECT_LT(std::abs(pitch / swing), 0.5);
}

TEST(SecondModel, DragThatFeelsTheBodysMotionAddsToTheRotation) {
  PlanarModel model = balanced();
  const double still = drop(model).first;
  for (PlanarDrag& drag : model.drags) drag.kind = DragKind::distributed;
  const double blown = drop(model).first;
  EXPECT_LT(blown, still - 0.01);  // further nose-up, by more than half a degree
}

}  // namespace
}  // namespace jaculus
