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

Taken take(double tolerance, double length, double damping = 0.0) {
  FastParts fast{1, {}};
  if (damping > 0.0) {
    FastPart part{.damping = damping};
    part.row[0] = part.response[0] = 1.0;
    fast.parts.push_back(part);
  }
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

TEST(ExplicitSteps, TakeThreeEvaluationsWhereThatIsExactEnough) {
  const Taken whole = take(1e-5, 1e-3), half = take(1e-5, 5e-4);
  EXPECT_EQ(whole.evaluations, 3);
  EXPECT_EQ(whole.step.end, 1e-3);
  EXPECT_EQ(whole.step.method, Method::hermite);
  EXPECT_NEAR(whole.error / half.error, 16.0, 0.5) << "of order three";
}

TEST(ExplicitSteps, TakeFourMoreWhereItIsNot) {
  const Taken whole = take(3e-8, 1e-3), half = take(2e-9, 5e-4);
  EXPECT_EQ(whole.evaluations, 3 + 4);
  EXPECT_EQ(whole.step.end, 1e-3);
  EXPECT_NEAR(whole.error / half.error, 32.0, 1.0) << "of order four";
}

TEST(ExplicitSteps, HaveTwoSlopesAtTheirMiddleWhereSomethingRubs) {
  EXPECT_EQ(take(1e-5, 1e-3, 1e-3).evaluations, 4);
}

TEST(ExplicitSteps, AreOfOrderFiveElsewhere) {
  const Taken taken = take(1e-12, 1e-3);
  EXPECT_EQ(taken.step.method, Method::dormand_prince);
  EXPECT_LT(taken.error, 1e-12);
}

TEST(ExplicitSteps, InterpolateByTheCubicOfBothEnds) {
  const Taken taken = take(1e-5, 1e-3);
  Stepper stepper(0.0, 1e-5, 1, 2, [](const State&, std::vector<FastPart>&) {});
  State middle(2);
  stepper.dense(taken.step, 5e-4, middle);
  const double at = 0.3 + kRate * 5e-4;
  EXPECT_NEAR(middle[0], std::cos(at), 1e-8);
  EXPECT_NEAR(middle[1] / kRate, -std::sin(at), 1e-8);
}

}  // namespace
}  // namespace jaculus::simulation
