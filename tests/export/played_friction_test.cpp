// A plan whose motor makes up for dry friction, exported and played on the plant, which has that
// friction: torques alone, held from sample to sample, no feedback.
//
// The pendulum's motor is too weak to lift it at once, so that it swings back first: its joint
// turns, and friction with it, between nodes of a mesh of 50 ms.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "jaculus/export/export.h"
#include "jaculus/simulation/simulate.h"
#include "jaculus/solver/plan.h"
#include "transcription/example_problems.h"

namespace jaculus::exporting {
namespace {

constexpr double kRate = 1000.0;   // [Hz]
constexpr double kFriction = 1.0;  // [N m], of a motor of 5 N m
constexpr double kInertia = 1.0;   // of 1 kg at 1 m about the joint [kg m^2]
constexpr double kDuration = 2.0;  // [s]

struct Swing {
  model::PlanarModel model;
  Source source;
};

/// From hanging to 60 degrees, at rest at both ends.
Swing swing(double dry_friction) {
  const transcription::Problem problem = test::extended_problem(
      "pendulum_swing_up",
      fmt::format("override: {{motors.swing.dry_friction: {}}}\n"
                  "phases: [{{name: swing, contacts: [], intervals: 40, duration: {} s}}]\n"
                  "final: {{at_rest: true, position: {{swing: 60 deg}}}}\n"
                  "guess: {{kind: line, poses: [{{swing: 0 deg}}, {{swing: 60 deg}}]}}\n",
                  dry_friction, kDuration));
  const model::PlanarModel model =
      model::read_robot(problem.robot_folder, problem.overrides).planar;
  const solver::Plan plan = solver::make_plan(problem, model);
  EXPECT_TRUE(plan.converged());
  return {model, source(solver::solved_plan(plan, problem))};
}

/// Largest distance of what is played from what was exported [rad].
double off(const Swing& swing, const Export& plan) {
  const ExportedMotor& motor = plan.motors.at(0);
  const auto samples = static_cast<Eigen::Index>(plan.time.size());
  simulation::Controller controller;
  controller.rate_hz = kInfinity;
  simulation::Reference& reference = controller.reference;
  reference.time = Eigen::Map<const Vector>(plan.time.data(), samples);
  reference.motors = {motor.joint};
  reference.feedforward = Eigen::Map<const Matrix>(motor.torque.data(), 1, samples);
  reference.duration = plan.duration;

  simulation::StartState start;
  start.q = Vector::Constant(1, motor.position.front());
  start.v = Vector::Constant(1, motor.velocity.front());
  simulation::SimulationOptions options;
  options.duration = plan.duration;
  options.sample_times = reference.time;
  const simulation::Simulation played =
      simulation::simulate(simulation::nominal_plant(swing.model), controller, start, options);
  EXPECT_EQ(played.status, simulation::SimulationStatus::done) << played.message;
  double largest = 0.0;
  for (Eigen::Index k = 0; k < played.time.size(); ++k)
    largest = std::max(largest, std::abs(played.q(0, k) - motor.position.at(k)));
  return largest;
}

/// Sign changes of the joint's rate, but for its rests at both ends.
int turns(const Export& plan) {
  constexpr double kMoves = 0.1;  // [rad/s], within which friction swells
  int count = 0;
  double last = 0.0;
  for (const double rate : plan.motors.at(0).velocity) {
    if (std::abs(rate) < kMoves) continue;
    if (rate * last < 0.0) ++count;
    last = rate;
  }
  return count;
}

/// What a playing is off by without friction, by its mesh and the hold of its torques, and for
/// each turn what the mean of friction over a sample leaves: a rate that is off by at most c h / I
/// within the sample and back at its end, so that the angle is off by less than c h^2 / I.
double allowed(double without_friction, int turned) {
  return without_friction + turned * kFriction / (kRate * kRate * kInertia);
}

TEST(PlayedFriction, APlanComesBackWithTheFrictionThatItMakesUpFor) {
  const Swing smooth = swing(0.0), rubs = swing(kFriction);
  const double usual = off(smooth, resample(smooth.source, kRate, Side::joint));
  const Export plan = resample(rubs.source, kRate, Side::joint);
  const double with_friction = off(rubs, plan);
  std::printf("off its plan: %.2e rad without friction, %.2e with, %d turns\n", usual,
              with_friction, turns(plan));
  ASSERT_GE(turns(plan), 1);
  EXPECT_LT(with_friction, allowed(usual, turns(plan)));
}

TEST(PlayedFriction, WithoutItsShareThePlanDoesNotComeBack) {
  const Swing rubs = swing(kFriction);
  const Export whole = resample(rubs.source, kRate, Side::joint);

  // shares that are interpolated as the rest is: a turn is smeared over 50 ms
  Swing smeared = rubs;
  smeared.source.motors.at(0).dry_friction = 0.0;
  const double by_nodes = off(smeared, resample(smeared.source, kRate, Side::joint));

  // none at all
  Swing without = rubs;
  Source& source = without.source;
  const int rate = source.table.column("swing_velocity"),
            torque = source.table.column("swing_torque");
  for (Eigen::Index k = 0; k < source.table.values.rows(); ++k)
    source.table.values(k, torque) -= kFriction * std::tanh(source.table.values(k, rate) / 0.1);
  source.motors.at(0).dry_friction = 0.0;
  const double none = off(without, resample(source, kRate, Side::joint));

  std::printf("off its plan: %.2e rad by interpolated shares, %.2e without\n", by_nodes, none);
  EXPECT_GT(by_nodes, 10.0 * off(rubs, whole));
  EXPECT_GT(none, 0.1);
}

}  // namespace
}  // namespace jaculus::exporting
