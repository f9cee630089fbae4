// What leans one way or comes late, by closed forms: torque beside the motor's, friction by
// direction, friction by load that fades, gravity that leans, torque behind its command.

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/core/error.h"
#include "simulation/control/command_lag.h"
#include "simulation/support.h"

namespace jaculus::simulation {
namespace {

using namespace test;

constexpr double kMoment = 1e-3;   ///< in which a pendulum hardly turns [s]
constexpr double kInertia = 0.02;  ///< of the arm about its joint [kg m^2]

/// An arm with its mass at its joint, turned by one motor of left and right, in no gravity.
Plant free_arm() {
  model::PlanarModel model = test_support::on_fixed_base(
      {link("arm", 0, Vec2::Zero(), 1.0, Vec2::Zero(), kInertia)}, {"arm"});
  model.gravity = 0.0;
  model::PlanarMotor motor;
  motor.joint = "arm";
  motor.body = 1;
  motor.count = 2;
  motor.voltage = kInfinity;
  model.motors = {motor};
  return nominal_plant(model);
}

/// A script of torques without feedback, played at a rate.
Controller torques(const Vector& time, const Vector& values, double rate_hz) {
  Controller c = no_controller();
  c.rate_hz = rate_hz;
  c.after_end = AfterEnd::repeat;
  c.reference.motors = {"arm"};
  c.reference.time = time;
  c.reference.feedforward = values.transpose();
  c.reference.duration = time[time.size() - 1];
  return c;
}

double rate_after(const Plant& plant, const Controller& controller, double angle, double rate,
                  double duration) {
  const Simulation s =
      simulate(plant, controller, start_at({angle}, {rate}), options_for(duration));
  EXPECT_EQ(s.status, SimulationStatus::done) << s.message;
  return s.v(0, s.v.cols() - 1);
}

TEST(TorqueOffset, TurnsAFreeArmAndIsInNoTorqueThatIsRead) {
  Plant plant = free_arm();
  plant.actuation.torque_offset = {{"arm", -0.03}};
  const Simulation s = simulate(plant, no_controller(), start_at({0}, {0}), options_for(0.5));
  EXPECT_NEAR(s.v(0, 100), -2.0 * 0.03 / kInertia * 0.5, 1e-9) << "of left and right";
  EXPECT_EQ(s.torque.cwiseAbs().maxCoeff(), 0.0);

  plant.actuation.torque_offset = {{"leg", 0.1}};
  EXPECT_THROW((void)simulate(plant, no_controller(), start_at({0}, {0}), options_for(0.5)),
               InputError);
}

TEST(DirectionalFriction, BrakesEachWayByItsOwnAndHoldsWhatRests) {
  Plant plant = free_arm();
  JointFriction friction{"arm"};
  friction.smoothing_rate = 1e-3;
  friction.positive = 0.03;
  friction.negative = 0.01;
  plant.friction = {friction};
  EXPECT_NEAR(rate_after(plant, no_controller(), 0.0, 5.0, 0.5), 5.0 - 2.0 * 0.03 / kInertia * 0.5,
              1e-6);
  EXPECT_NEAR(rate_after(plant, no_controller(), 0.0, -5.0, 0.5),
              -5.0 + 2.0 * 0.01 / kInertia * 0.5, 1e-6);
  EXPECT_EQ(rate_after(plant, no_controller(), 0.0, 0.0, 0.5), 0.0) << "it pushes nothing";
}

TEST(DryFriction, HoldsALightJointThatCreepsAsItsLawSaysWithoutTinySteps) {
  // 2 tau = 2 c tanh(w/s) where an arm of 2e-5 kg m^2 stands: 2 c/(s J) is 1e7 1/s.
  const double c = 0.5, tau = 0.3, end = 0.5;
  Plant plant = free_arm();
  plant.model.bodies[1].inertia = 2e-5;
  plant.actuation.torque_offset = {{"arm", tau}};
  plant.friction = {{"arm", c}};
  const Simulation s = simulate(plant, no_controller(), start_at({0}, {0}), options_for(end));
  ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
  const double creep = JointFriction{}.smoothing_rate * std::atanh(tau / c);
  EXPECT_NEAR(s.v(0, s.v.cols() - 1), creep, 1e-3 * creep);
  EXPECT_NEAR(s.q(0, s.q.cols() - 1), creep * end, 1e-2 * creep * end);
  EXPECT_LT(s.evaluations, 20'000) << "explicit steps, stable to 3.3e-7 s, would take 1e7";
}

TEST(LoadStribeck, TakesItsShareAtRestAndNoneAtSpeed) {
  // Torque t on an arm: far below the Stribeck rate it loses the share, far above it nothing.
  Plant plant = free_arm();
  JointFriction friction{"arm"};
  friction.smoothing_rate = 1e-5;
  friction.load_stribeck = 0.4;
  friction.load_stribeck_rate = 10.0;
  plant.friction = {friction};
  const Controller push = torques(Vector::Zero(1), Vector::Constant(1, 0.01), kInfinity);
  EXPECT_NEAR(rate_after(plant, push, 0.0, 0.01, 0.01) - 0.01, 0.6 * 2.0 * 0.01 / kInertia * 0.01,
              1e-6);
  EXPECT_NEAR(rate_after(plant, push, 0.0, 60.0, 0.01) - 60.0, 2.0 * 0.01 / kInertia * 0.01, 1e-9);
}

TEST(GravityTilt, HangsAPendulumAtItsAngle) {
  // A pendulum released where the leaning gravity lets it hang stays there; at rest straight down
  // it is turned by m g l sin(tilt).
  const double mass = 0.7, length = 0.3, tilt = 0.08;
  const model::PlanarModel model = test_support::on_fixed_base(
      {link("arm", 0, Vec2::Zero(), mass, Vec2(0.0, -length), 0.0)}, {"arm"});
  Plant plant = nominal_plant(model);
  plant.gravity_tilt = tilt;

  const auto rate = [&](double angle) {
    return rate_after(plant, no_controller(), angle, 0.0, kMoment);
  };
  // nose-down turns the hanging arm's end forward, which is a negative turn about +y
  EXPECT_NEAR(rate(-tilt), 0.0, 1e-12);
  EXPECT_NEAR(rate(0.0), -model.gravity * std::sin(tilt) / length * kMoment, 1e-7);
}

TEST(Lag, OfAHoldIsItsMeanAndItsEnd) {
  double u = 1.0;
  const double mean = detail::held_mean(0.02, 0.03, 3.0, u);
  EXPECT_NEAR(u, 3.0 - 2.0 * std::exp(-1.5), 1e-14);
  double sum = 0.0;  // of the exponential, by Simpson's rule
  constexpr int kParts = 1000;
  for (int k = 0; k <= kParts; ++k) {
    const double weight = k == 0 || k == kParts ? 1.0 : (k % 2 == 1 ? 4.0 : 2.0);
    sum += weight * (3.0 - 2.0 * std::exp(-1.5 * k / kParts));
  }
  EXPECT_NEAR(mean, sum / (3.0 * kParts), 1e-12);
}

TEST(Lag, OfASineIsTheFirstOrderFilters) {
  // Long after the start: amplitude 1/sqrt(1 + (w T)^2), phase -atan(w T).
  const double lag = 3e-3, w = 40.0;
  Reference reference;
  reference.time = Vector::LinSpaced(2001, 0.0, 1.0);
  reference.duration = 1.0;
  reference.linear = true;
  reference.feedforward = (w * reference.time.array()).sin().matrix().transpose();
  const Reference out = detail::lagged(reference, lag);
  const double size = 1.0 / std::hypot(1.0, w * lag), phase = std::atan(w * lag);
  for (const int k : {500, 1234, 2000})
    EXPECT_NEAR(out.feedforward(0, k), size * std::sin(w * reference.time[k] - phase), 1e-4);
  EXPECT_EQ(out.feedforward(0, 0), reference.feedforward(0, 0));
}

TEST(Lag, GivesTheRateOfTheExponentialAndNoneAtZero) {
  // A step at t1 behind a lag T: impulse c (t - t1 - T (1 - exp(-(t - t1)/T))).
  Plant plant = free_arm();
  Vector time(2), values(2);
  time << 0.0, 0.05;
  values << 0.0, 0.01;
  Controller step = torques(time, values, 1000.0);
  const double duration = 0.08, since = 0.03, lag = 4e-3;
  const double prompt = rate_after(plant, step, 0.0, 0.0, duration);
  EXPECT_NEAR(prompt, 2.0 * 0.01 / kInertia * since, 1e-9);

  plant.actuation.lag = lag;
  const double impulse = 0.01 * (since - lag * (1.0 - std::exp(-since / lag)));
  EXPECT_NEAR(rate_after(plant, step, 0.0, 0.0, duration), 2.0 * impulse / kInertia, 1e-9);
  step.rate_hz = kInfinity;
  step.reference.duration = duration;
  EXPECT_NEAR(rate_after(plant, step, 0.0, 0.0, duration), 2.0 * impulse / kInertia, 1e-9);

  step.reference.position = Matrix::Zero(1, 2);
  step.kp = Vector::Constant(1, 1.0);
  EXPECT_THROW((void)rate_after(plant, step, 0.0, 0.0, duration), InputError)
      << "a state that nothing samples can't be fed back late";
  plant.actuation.lag = 0.0;
  EXPECT_NO_THROW((void)rate_after(plant, step, 0.0, 0.0, duration));
}

}  // namespace
}  // namespace jaculus::simulation
