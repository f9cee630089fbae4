// Self-righting by the two bodies on a pin against the planar robot of the leap, dropped with its
// legs in a stance pose.
//
// The pin of the two-body equations is at rest. That is exact for a robot in free fall where
// turning the tail moves no mass: a tail balanced about its pivot, which then loads the body as a
// point mass there. There the two must agree, saturation and back-EMF included. A tail whose mass
// lies along it pulls the pivot with it, and drag pushes the whole robot: there they must not.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "jaculus/core/installation.h"
#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/model/robot.h"
#include "jaculus/simulation/simulate.h"
#include "jaculus/studies/reorientation.h"

namespace jaculus::studies {
namespace {

constexpr double kStroke = std::numbers::pi, kBack = -0.5 * std::numbers::pi, kDuration = 0.12,
                 kVoltage = 16.0;

/// Minitaur with its tail free and its legs held at 1 rad of extension, straight down: one body and
/// a tail.
model::PlanarModel minitaur() {
  const std::filesystem::path models = source_folder() / "models";
  model::PlanarModel model = model::read_robot(models / "minitaur_tail").planar;
  for (const char* leg : {"front", "rear"}) {
    model = model::lock(model, std::string(leg) + "_extension", 1.0);
    model = model::lock(model, std::string(leg) + "_angle", 0.0);
  }
  for (model::PlanarMotor& motor : model.motors) {
    motor.rotor_inertia = 0.0;  // the two-body equations know none
    motor.current_limit = motor.torque_limit = kInfinity;
  }
  for (model::PlanarDrag& drag : model.drags) drag.kind = model::DragKind::none;
  return model;
}

model::PlanarBody& tail_of(model::PlanarModel& model) {
  return model.bodies[model.body_of_joint("tail")];
}

/// Pitch inertia of the whole robot about its centre of mass with the tail held straight back [kg
/// m^2].
double whole_inertia(const model::PlanarModel& model) {
  const model::PlanarModel held = model::lock(model, "tail", kBack);
  const dynamics::AbsoluteTree tree(held);
  dynamics::Motion motion(tree);
  EXPECT_TRUE(dynamics::set_configuration(tree, Vector::Zero(held.size()), motion));
  const Matrix M = dynamics::mass_matrix(tree, motion);
  return M(2, 2) - (M(0, 2) * M(0, 2) + M(1, 2) * M(1, 2)) / M(0, 0);
}

/// Pitch and tail angle of the planar robot after kDuration in the air, the tail's motor at full
/// voltage.
std::pair<double, double> drop(const model::PlanarModel& model) {
  simulation::Controller controller;
  controller.quantity = trajectory::Quantity::voltage;
  controller.rate_hz = kInfinity;
  controller.after_end = simulation::AfterEnd::repeat;
  controller.kp = controller.kd = Vector::Zero(1);
  controller.reference.motors = {"tail"};
  controller.reference.time = Vector::LinSpaced(2, 0.0, 2.0 * kDuration);
  controller.reference.feedforward = Matrix::Constant(1, 2, kVoltage);
  controller.reference.duration = 2.0 * kDuration;
  simulation::StartState start{Vector::Zero(model.size()), Vector::Zero(model.size())};
  start.q[model.coordinate_index("z")] = 5.0;
  start.q[model.coordinate_index("tail")] = kBack;
  simulation::SimulationOptions options;
  options.duration = kDuration;
  options.sample_times = Vector::LinSpaced(2, 0.0, kDuration);
  options.relative_tolerance = 1e-10;
  options.absolute_tolerance = 1e-12;
  const simulation::Simulation s =
      simulation::simulate(simulation::nominal_plant(model), controller, start, options);
  EXPECT_EQ(s.status, simulation::SimulationStatus::done) << s.message;
  return {s.q(model.coordinate_index("pitch"), 1), s.q(model.coordinate_index("tail"), 1) - kBack};
}

ReorientationResult two_bodies(const model::PlanarModel& model, double body_inertia,
                               double tail_inertia) {
  ReorientationCase c = paper_case();
  c.body_inertia = body_inertia;
  c.tail_inertia = tail_inertia;
  c.motor = model.motors.front();
  c.motor.voltage = kVoltage;
  c.drag.kind = model::DragKind::none;
  c.initial_tail_angle = kBack;
  c.stroke = kStroke;
  c.duration = kDuration;
  const ReorientationResult result = simulate_reorientation(c, 1e-9);
  EXPECT_TRUE(result.converged);
  EXPECT_FALSE(result.stop.has_value());
  return result;
}

/// The tail with its mass drawn to the pivot and its inertia about it kept.
model::PlanarModel balanced() {
  model::PlanarModel model = minitaur();
  model::PlanarBody& tail = tail_of(model);
  tail.inertia += tail.mass * tail.com.squaredNorm();
  tail.com = Vec2::Zero();
  return model;
}

TEST(SecondModel, AgreesWhereTheTailIsBalancedAboutItsPivot) {
  model::PlanarModel model = balanced();
  const double tail = tail_of(model).inertia;
  const auto [pitch, swing] = drop(model);
  const ReorientationResult pinned = two_bodies(model, whole_inertia(model) - tail, tail);
  EXPECT_GT(swing, 0.5);
  EXPECT_NEAR(pitch, pinned.body_angle, 1e-6);
  EXPECT_NEAR(swing, pinned.tail_angle, 1e-6);
}

TEST(SecondModel, DiffersWhereTheTailsMassPullsThePivotAlong) {
  model::PlanarModel model = minitaur();
  const model::PlanarBody& link = tail_of(model);
  const double tail = link.inertia + link.mass * link.com.squaredNorm();
  const auto [pitch, swing] = drop(model);
  const ReorientationResult pinned = two_bodies(model, whole_inertia(balanced()) - tail, tail);
  // The same motor and voltage; the ratio of the rotations is what the free pivot changes.
  EXPECT_GT(std::abs(pitch / swing - pinned.body_angle / pinned.tail_angle), 1e-3);
  EXPECT_LT(pitch / swing, 0.0);
  EXPECT_LT(std::abs(pitch / swing), 0.5);
}

TEST(SecondModel, DragThatFeelsTheBodysMotionAddsToTheRotation) {
  model::PlanarModel model = balanced();
  const double still = drop(model).first;
  for (model::PlanarDrag& drag : model.drags) drag.kind = model::DragKind::distributed;
  const double blown = drop(model).first;
  EXPECT_LT(blown, still - 0.01);  // further nose-up, by more than half a degree
}

}  // namespace
}  // namespace jaculus::studies
