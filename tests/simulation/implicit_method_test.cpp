// The implicit method against closed forms, and where it is taken.

#include "simulation/integrate/implicit_method.h"

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/model/robot.h"
#include "simulation/integrate/stepper.h"
#include "simulation/support.h"

namespace jaculus::simulation {
namespace {

using detail::ImplicitMethod;
using detail::State;
using detail::Step;
using detail::Stepper;

/// Prothero and Robinson's problem, y = cos t whatever the rate, beside z' = -y z.
struct Followed {
  double rate;  ///< [1/s]
  bool operator()(double t, const State& y, State& dydt) const {
    dydt[0] = -rate * (y[0] - std::cos(t)) - std::sin(t);
    dydt[1] = -y[0] * y[1];
    return true;
  }
  static State at(double t) { return {std::cos(t), std::exp(-std::sin(t))}; }
};

Step step_from(const Followed& f, double t, double length) {
  Step step;
  step.t = t;
  step.length = length;
  step.y = Followed::at(t);
  for (State* s : {&step.dydt, &step.y_end, &step.dydt_end}) s->resize(2);
  f(t, step.y, step.dydt);
  return step;
}

/// Error at the end of one step, and its estimate.
std::pair<double, double> errors(double rate, double length) {
  const Followed f{rate};
  Step step = step_from(f, 0.3, length);
  State estimate(2);
  ImplicitMethod().take(f, step, estimate);
  const State exact = Followed::at(0.3 + length);
  return {std::hypot(step.y_end[0] - exact[0], step.y_end[1] - exact[1]),
          std::hypot(estimate[0], estimate[1])};
}

TEST(ImplicitMethod, IsOfOrderFourAlsoWhereTheEquationsDependOnTime) {
  const auto [coarse, coarse_estimate] = errors(3.0, 0.2);
  const auto [fine, fine_estimate] = errors(3.0, 0.1);
  EXPECT_GT(std::log2(coarse / fine), 4.0);
  EXPECT_GT(std::log2(coarse_estimate / fine_estimate), 3.0);
  EXPECT_LT(coarse, coarse_estimate);
}

TEST(ImplicitMethod, LengthIsSetByTheMotionAndNotByItsFastestPart) {
  const auto [error, estimate] = errors(1e7, 0.05);
  EXPECT_LT(error, 1e-8);
  EXPECT_LT(estimate, 1e-6);
}

TEST(ImplicitMethod, InterpolatesWithinAStep) {
  const Followed f{3.0};
  Step step = step_from(f, 0.3, 0.1);
  State estimate(2), between(2);
  ImplicitMethod method;
  method.take(f, step, estimate);
  for (const double t : {0.3, 0.33, 0.38, 0.4}) {
    method.dense(step, t, between);
    EXPECT_NEAR(between[0], std::cos(t), 1e-5);
  }
}

TEST(Stepper, TakesTheImplicitMethodWhereStabilityWouldShortenSteps) {
  for (const double rate : {3.0, 1e6}) {
    const Followed f{rate};
    Stepper stepper(1e-6, 1e-8, 2);
    stepper.expect(rate);
    Step step = step_from(f, 0.0, 0.0);
    int steps = 0;
    for (; step.t < 1.0; ++steps) {
      ASSERT_EQ(stepper.take(f, 1.0, step), detail::StepResult::accepted);
      EXPECT_EQ(step.method == detail::Method::implicit, rate > 1e3);
      step.t = step.end;
      step.y = step.y_end;
      step.dydt = step.dydt_end;
    }
    EXPECT_LT(steps, 100);
    EXPECT_NEAR(step.y[1], std::exp(-std::sin(1.0)), 1e-5);
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
