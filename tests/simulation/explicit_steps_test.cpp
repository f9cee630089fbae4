// Explicit steps that a limit in time ends: their order, and what they cost.

#include <gtest/gtest.h>

#include <cmath>

#include "simulation/integrate/stepper.h"

namespace jaculus::simulation {
namespace {

using detail::FastPart;
using detail::FastParts;
using detail::Method;
using detail::State;
using detail::Step;
using detail::Stepper;

constexpr double kRate = 20.0;  ///< of a pendulum for small angles [1/s]

/// A step of an undamped oscillator to a limit, and what it takes.
struct Taken {
  Step step;
  int evaluations = 0;
  double error = 0.0;  ///< of its angle and, by the rate, of its velocity [rad]
};

Taken take(double tolerance, double length) {
  const FastParts fast{1, {}};
  Stepper stepper(0.0, tolerance, 1, 2,
                  [&](const State&, std::vector<FastPart>& out) { out = fast.parts; });
  stepper.expect(fast);

  Taken out;
  const auto rates = [&](double, const State& y, State& dydt) {
    ++out.evaluations;
    dydt = {y[1], -kRate * kRate * y[0]};
    return true;
  };
  const double phase = 0.3;
  out.step.y = {std::cos(phase), -kRate * std::sin(phase)};
  out.step.dydt.resize(2);
  rates(0.0, out.step.y, out.step.dydt);
  out.evaluations = 0;
  EXPECT_EQ(stepper.take(rates, length, out.step), detail::StepResult::accepted);

  const double at = phase + kRate * out.step.end;
  out.error =
      std::hypot(out.step.y_end[0] - std::cos(at), out.step.y_end[1] / kRate + std::sin(at));
  return out;
}

TEST(ExplicitSteps, TakeFourEvaluationsWhereThatIsExactEnough) {
  const Taken whole = take(1e-6, 1e-3), half = take(1e-6, 5e-4);
  EXPECT_EQ(whole.evaluations, 4);
  EXPECT_EQ(whole.step.end, 1e-3);
  EXPECT_EQ(whole.step.method, Method::kutta);
  EXPECT_NEAR(whole.error / half.error, 32.0, 1.0) << "of order four";
}

TEST(ExplicitSteps, AreOfOrderFiveElsewhere) {
  const Taken whole = take(1e-12, 1e-3), half = take(1e-12, 5e-4);
  EXPECT_EQ(whole.step.method, Method::dormand_prince);
  EXPECT_EQ(whole.step.end, 1e-3);
  EXPECT_LT(whole.error, 1e-12);
  EXPECT_LT(half.error, whole.error / 32.0) << "the local error is of order six";
}

TEST(ExplicitSteps, InterpolateByTheCubicOfBothEnds) {
  const Taken taken = take(1e-6, 1e-3);
  Stepper stepper(0.0, 1e-6, 1, 2, [](const State&, std::vector<FastPart>&) {});
  State middle(2);
  stepper.dense(taken.step, 5e-4, middle);
  const double at = 0.3 + kRate * 5e-4;
  EXPECT_NEAR(middle[0], std::cos(at), 1e-8);
  EXPECT_NEAR(middle[1] / kRate, -std::sin(at), 1e-8);
}

}  // namespace
}  // namespace jaculus::simulation
