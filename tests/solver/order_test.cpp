// The re-integration error at the nodes falls at the order of the scheme, and a plan that is not one is told.

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/solver/ipopt.h"
#include "jaculus/solver/verify.h"
#include "transcription/programmes.h"

namespace jaculus {
namespace {

Vector solve(Programme& programme) {
  SolverOptions options;
  options.tolerance = 1e-9;
  options.row_tolerance = 1e-11;
  const NlpResult result = solve_nlp(programme, {initial_guess(programme, programme.problem().guess, 1), {}}, options);
  EXPECT_TRUE(result.converged()) << to_string(result.status);
  return result.last_iterate();
}

/// Largest angle by which the re-integrated swing-up misses its nodes on a grid [rad].
double node_error(const std::string& scheme, int intervals) {
  Programme programme = test::make_programme(test::on_grid(
      test::extended_problem("pendulum_swing_up", "transcription: {scheme: " + scheme + ", inputs: linear}"),
      {intervals}));
  const Vector x = solve(programme);
  return verify_plan(programme, x).angle_error;
}

TEST(Order, HermiteSimpsonIsOfFourthOrder) {
  const double order = std::log2(node_error("hermite_simpson", 60) / node_error("hermite_simpson", 120));
  EXPECT_NEAR(order, 4.0, 0.4);
}

TEST(Order, TrapezoidalIsOfSecondOrder) {
  const double order = std::log2(node_error("trapezoidal", 60) / node_error("trapezoidal", 120));
  EXPECT_NEAR(order, 2.0, 0.4);
}

TEST(Verify, PassesAPlanFromRestToRestAndTellsAPerturbedOne) {
  Programme programme = test::make_programme(test::extended_problem("double_integrator", ""));
  Vector x = solve(programme);
  const PlanVerification good = verify_plan(programme, x);
  EXPECT_TRUE(good.passed) << (good.failures.empty() ? "" : good.failures.front());
  EXPECT_LT(good.energy_balance, 1e-6);
  x[programme.layout().nodes[10].q] += 0.005;
  const PlanVerification bad = verify_plan(programme, x);
  EXPECT_FALSE(bad.passed);
  EXPECT_NEAR(bad.length_error, 0.005, 1e-4);
}

TEST(Verify, LeapAgreesWithItsNodes) {
  Programme programme = test::make_programme(read_problem(test::problem_file("leap_tail")));
  const PlanVerification leap = verify_plan(programme, solve(programme));
  EXPECT_TRUE(leap.passed) << (leap.failures.empty() ? "" : leap.failures.front());
  EXPECT_LT(leap.length_error, 1e-3);
  EXPECT_LT(leap.angle_error, 0.1 * 3.14159265358979 / 180.0);
  EXPECT_LT(leap.velocity_error, 0.02);
}

}  // namespace
}  // namespace jaculus
