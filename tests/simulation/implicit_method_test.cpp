// The implicit method against closed forms, and where it is taken.

#include "simulation/integrate/implicit_method.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "jaculus/model/robot.h"
#include "simulation/contact/plant_equations.h"
#include "simulation/integrate/stepper.h"
#include "simulation/support.h"
#include "support/random_state.h"

namespace jaculus::simulation {
namespace {

using detail::FastPart;
using detail::FastParts;
using detail::FastSlopes;
using detail::ImplicitMethod;
using detail::State;
using detail::Step;
using detail::Stepper;
using detail::Touch;

/// Prothero and Robinson's problem for a rate, v = cos t whatever holds it, beside its coordinate
/// q' = v and z' = -v z: v' = -damping (v - cos t) - stiffness (q - sin t) - sin t.
struct Followed {
  double damping, stiffness;  ///< [1/s], [1/s^2]
  bool operator()(double t, const State& y, State& dydt) const {
    dydt[0] = y[1];
    dydt[1] = -damping * (y[1] - std::cos(t)) - stiffness * (y[0] - std::sin(t)) - std::sin(t);
    dydt[2] = -y[1] * y[2];
    return true;
  }
  static State at(double t) { return {std::sin(t), std::cos(t), std::exp(-std::sin(t))}; }
  /// `share`: of what is so, told to the method.
  [[nodiscard]] FastParts fast(double share = 1.0) const {
    FastPart part{{}, share * damping, share * stiffness};
    part.row[0] = part.response[0] = 1.0;
    return {1, {part}};
  }
  [[nodiscard]] FastSlopes slopes(double share) const {
    return [parts = fast(share).parts](const State&, std::vector<FastPart>& out) { out = parts; };
  }
};

Step step_from(const Followed& f, double t, double length) {
  Step step;
  step.t = t;
  step.length = length;
  step.y = Followed::at(t);
  for (State* s : {&step.dydt, &step.y_end, &step.dydt_end}) s->resize(3);
  f(t, step.y, step.dydt);
  return step;
}

double distance(const State& a, const State& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Error at the end of one step, and its estimate.
std::pair<double, double> errors(const Followed& f, double share, double length) {
  Step step = step_from(f, 0.3, length);
  State estimate(3);
  ImplicitMethod().take(f, f.fast(share), f.slopes(share), step, estimate);
  return {distance(step.y_end, Followed::at(0.3 + length)), distance(estimate, {0.0, 0.0, 0.0})};
}

TEST(ImplicitMethod, IsOfOrderThreeWhateverOfTheFastPartsItIsTold) {
  for (const double share : {1.0, 0.5, 0.0}) {
    const auto [coarse, coarse_estimate] = errors({3.0, 2.0}, share, 0.02);
    const auto [fine, fine_estimate] = errors({3.0, 2.0}, share, 0.01);
    EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.2) << share;
    EXPECT_NEAR(std::log2(coarse_estimate / fine_estimate), 3.0, 0.2) << share;
    EXPECT_LT(coarse, coarse_estimate) << share;
  }
}

TEST(ImplicitMethod, LengthIsSetByTheMotionAndNotByItsFastestPart) {
  // Of order two where a stiff hinge makes the rate follow the way.
  for (const Followed& f : {Followed{1e7, 0.0}, Followed{2e5, 1e10}}) {
    const auto [error, estimate] = errors(f, 1.0, 0.005);
    EXPECT_LT(error, 1e-4);
    EXPECT_LT(estimate, 2e-3);
  }
}

TEST(ImplicitMethod, InterpolatesWithinAStep) {
  const Followed f{3.0, 0.0};
  Step step = step_from(f, 0.3, 0.05);
  State estimate(3), between(3);
  ImplicitMethod method;
  method.take(f, f.fast(), f.slopes(1.0), step, estimate);
  for (const double t : {0.3, 0.31, 0.33, 0.35}) {
    method.dense(step, t, between);
    EXPECT_NEAR(between[0], std::sin(t), 1e-7);
    EXPECT_NEAR(between[1], std::cos(t), 1e-5);
  }
}

TEST(Stepper, TakesTheImplicitMethodWhereStabilityWouldShortenSteps) {
  for (const double rate : {3.0, 1e6}) {
    const Followed f{rate, 0.0};
    const FastParts fast = f.fast();
    Stepper stepper(1e-6, 1e-8, 1, 3, f.slopes(1.0));
    stepper.expect(fast);
    Step step = step_from(f, 0.0, 0.0);
    int steps = 0;
    for (; step.t < 1.0; ++steps) {
      ASSERT_EQ(stepper.take(f, 1.0, step), detail::StepResult::accepted);
      EXPECT_EQ(step.method == detail::Method::implicit, rate > 1e3);
      step.t = step.end;
      step.y = step.y_end;
      step.dydt = step.dydt_end;
    }
    EXPECT_LT(steps, 400);
    EXPECT_NEAR(step.y[2], std::exp(-std::sin(1.0)), 1e-5);
  }
}

/// A rotor that dry friction holds until the torque is more than it is, a step each 1 ms: q and v
/// after 10 ms, and the number of evaluations.
struct BreakAway {
  double inertia, friction, smoothing, torque;  ///< [kg m^2, N m, rad/s, N m]
  double jump = 0.0;                            ///< more torque in every second hold [N m]

  [[nodiscard]] FastPart part(const State& y) const {
    const double t = std::tanh(y[1] / smoothing);
    FastPart part{{}, friction / smoothing * (1.0 - t * t), 0.0, {}, y[1], smoothing};
    part.row[0] = 1.0;
    part.response[0] = 1.0 / inertia;
    return part;
  }
  [[nodiscard]] State moved(double tolerance, int& evaluations, double from = 0.0) const {
    double own = torque;
    const auto f = [&](double, const State& y, State& dydt) {
      ++evaluations;
      dydt[0] = y[1];
      dydt[1] = (own - friction * std::tanh(y[1] / smoothing)) / inertia;
      return true;
    };
    Stepper stepper(100.0 * tolerance, tolerance, 1, 2,
                    [&](const State& y, std::vector<FastPart>& out) { out = {part(y)}; });
    Step step;
    step.y = {0.0, from};
    step.dydt.resize(2);
    f(0.0, step.y, step.dydt);
    while (step.t < 0.01) {
      const FastParts fast{1, {part(step.y)}};
      stepper.expect(fast);
      const double hold = 1e-3 * (std::floor(step.t / 1e-3 + 1e-9) + 1.0);
      EXPECT_EQ(stepper.take(f, hold, step), detail::StepResult::accepted);
      step.t = step.end;
      step.y = step.y_end;
      step.dydt = step.dydt_end;
      if (jump == 0.0 || step.t < hold) continue;
      own = own == torque ? torque + jump : torque;
      f(step.t, step.y, step.dydt);
    }
    return step.y;
  }
};

TEST(Stepper, LosesNothingOfTheTorqueByWhichAJointBreaksAway) {
  for (const BreakAway& joint : {BreakAway{1e-3, 0.4, 5e-4, 0.5}, BreakAway{1e-2, 0.4, 5e-3, 0.5},
                                 BreakAway{3e-6, 0.02, 1e-3, 0.03}}) {
    int evaluations = 0, exact_evaluations = 0;
    const State y = joint.moved(1e-7, evaluations), exact = joint.moved(1e-12, exact_evaluations);
    EXPECT_GT(exact[1], 0.05);
    EXPECT_NEAR(y[0], exact[0], 1e-5);
    EXPECT_NEAR(y[1], exact[1], 1e-3 * exact[1]);
    EXPECT_LT(evaluations, 300);
  }
}

TEST(Stepper, HoldsAJointUnderTorquesThatJumpInFewEvaluations) {
  // It settles within 30 us of each jump: a stable explicit method takes 20 steps and more a hold.
  const BreakAway joint{1e-3, 0.4, 5e-3, 0.1, 0.1};
  int evaluations = 0, exact_evaluations = 0;
  const State y = joint.moved(1e-8, evaluations), exact = joint.moved(1e-12, exact_evaluations);
  EXPECT_GT(exact[0], 1e-5);
  // Some forty steps of 1e-8, nearly all of one sign; it creeps by 2e-5.
  EXPECT_NEAR(y[0], exact[0], 1e-6);
  EXPECT_NEAR(y[1], exact[1], 1e-5);
  EXPECT_LT(evaluations, 300);
}

TEST(Stepper, MeetsTheRateAtWhichFrictionTurnsWithoutASearch) {
  // From 1 rad/s to rest in 2.5 ms, where friction holds it.
  const BreakAway joint{1e-3, 0.4, 5e-4, 0.0};
  int evaluations = 0, exact_evaluations = 0;
  const State y = joint.moved(1e-8, evaluations, 1.0),
              exact = joint.moved(1e-12, exact_evaluations, 1.0);
  EXPECT_NEAR(exact[0], 1.25e-3, 2e-6);
  EXPECT_NEAR(y[0], exact[0], 2e-8);
  EXPECT_LT(std::abs(y[1]), 1e-5);
  EXPECT_LT(evaluations, 200);
}

/// The accelerations that friction makes, by the equations with it and without.
Vector by_friction(detail::PlantEquations& with, detail::PlantEquations& without, const State& y,
                   const std::vector<Touch>& modes) {
  const int n = with.size();
  State dydt(y.size()), smooth(y.size());
  EXPECT_NE(with.evaluate(0.0, y, modes, dydt), nullptr);
  EXPECT_NE(without.evaluate(0.0, y, modes, smooth), nullptr);
  return Eigen::Map<const Vector>(dydt.data() + n, n) -
         Eigen::Map<const Vector>(smooth.data() + n, n);
}

TEST(FastParts, OfAPlantAreTheSlopesOfItsEquationsWithFeetOnTheFloorAndOff) {
  const model::PlanarModel model = model::read_robot(model::find_robot("minitaur", "")).planar;
  const Plant smooth = nominal_plant(model);
  Plant plant = smooth;
  plant.model.motors[1].dry_friction = 0.3;
  plant.model.motors[1].viscous_friction = 0.05;
  for (const model::PlanarMotor& motor : model.motors)
    plant.friction.push_back({.joint = motor.joint, .coulomb = 0.4, .viscous = 0.02});
  Controller controller = test::no_controller();
  controller.after_end = AfterEnd::repeat;
  controller.reference.time = Vector::Zero(1);
  controller.reference.feedforward = Vector::Zero(count_of(model.motors));
  for (const model::PlanarMotor& motor : model.motors)
    controller.reference.motors.push_back(motor.joint);
  detail::PlantEquations with(plant, controller), without(smooth, controller);
  const int n = with.size();
  std::mt19937 rng(3);

  for (const Touch foot : {Touch::open, Touch::stick, Touch::slip_plus}) {
    std::vector<Touch> modes(with.unilaterals().size(), Touch::open);
    modes[0] = foot;
    State y(with.states()), dydt(y.size());
    bool possible = false;
    for (int draw = 0; draw < 50 && !possible; ++draw) {  // until its loops can be closed
      const auto state = test_support::random_state(model, rng);
      std::copy(state.q.begin(), state.q.end(), y.begin());
      for (int i = 0; i < n; ++i) y[n + i] = 1e-3 * state.v[i];  // so slow that friction is fast
      with.take_inputs(0.0, y);
      without.take_inputs(0.0, y);
      possible = with.evaluate(0.0, y, modes, dydt) != nullptr;
    }
    ASSERT_TRUE(possible);
    const FastParts fast = with.fast_parts(y, modes);
    ASSERT_EQ(count_of(fast.parts), count_of(model.motors) + 1);

    for (int j = 0; j < n; ++j) {
      constexpr double kStep = 1e-7;
      State more = y, less = y;
      more[n + j] += kStep;
      less[n + j] -= kStep;
      const Vector slope =
          (by_friction(with, without, more, modes) - by_friction(with, without, less, modes)) /
          (2.0 * kStep);
      Vector told = Vector::Zero(n);
      for (const FastPart& part : fast.parts)
        for (int i = 0; i < n; ++i) told[i] -= part.damping * part.response[i] * part.row[j];
      EXPECT_LT((slope - told).norm(), 1e-5 * (1.0 + told.norm())) << j;
    }
  }
}

TEST(Simulate, AStiffHingeBehindHardlyAnyRotorCostsNoTinySteps) {
  const model::PlanarModel model = model::read_robot(model::find_robot("pendulum", "")).planar;
  Plant plant = nominal_plant(model);
  Controller controller;
  Reference& r = controller.reference;
  r.motors = {"swing"};
  r.time = Vector::LinSpaced(3, 0.0, 0.5);
  r.duration = 0.5;
  r.position = r.velocity = Matrix::Zero(1, 3);
  r.feedforward = (Matrix(1, 3) << 1.0, 3.0, -2.0).finished();
  r.initial["swing"] = 0.0;
  controller.kp = controller.kd = Vector::Zero(1);
  const SimulationOptions options = test::options_for(0.5, 3);
  const Simulation rigid = simulate(plant, controller, reference_start(plant, r), options);

  plant.transmissions = {{"swing", 1e-5, 0.05, 0.0}};
  const Simulation stiff = simulate(plant, controller, reference_start(plant, r), options);
  ASSERT_EQ(stiff.status, SimulationStatus::done) << stiff.message;
  EXPECT_LT(stiff.evaluations, 20 * rigid.evaluations);
  // 3 N m bend it by 3e-5 rad.
  EXPECT_NEAR(stiff.q(0, 2), rigid.q(0, 2), 1e-4);
}

}  // namespace
}  // namespace jaculus::simulation
