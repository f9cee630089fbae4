// The re-integration error at the nodes falls at the order of the scheme, and a plan that is not
// one is told.

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/solver/ipopt.h"
#include "jaculus/solver/verify.h"
#include "transcription/example_problems.h"

namespace jaculus::solver {
namespace {

Vector solution(transcription::NonlinearProgram& program) {
  SolverOptions options;
  options.tolerance = 1e-9;
  options.row_tolerance = 1e-11;
  const NlpResult result = solve_nlp(
      program, {transcription::initial_guess(program, program.problem().guess, 1), {}}, options);
  EXPECT_TRUE(result.converged()) << to_string(result.status);
  return result.last_iterate();
}

/// Largest angle by which the re-integrated swing-up misses its nodes on a grid [rad].
double node_error(const std::string& scheme, int intervals) {
  transcription::NonlinearProgram program = test::make_program(test::on_grid(
      test::extended_problem("pendulum_swing_up",
                             "transcription: {scheme: " + scheme + ", inputs: linear}"),
      {intervals}));
  const Vector x = solution(program);
  return verify_plan(program, x).angle_error;
}

TEST(Order, HermiteSimpsonIsOfFourthOrder) {
  const double order =
      std::log2(node_error("hermite_simpson", 60) / node_error("hermite_simpson", 120));
  EXPECT_NEAR(order, 4.0, 0.4);
}

TEST(Order, TrapezoidalIsOfSecondOrder) {
  const double order = std::log2(node_error("trapezoidal", 60) / node_error("trapezoidal", 120));
  EXPECT_NEAR(order, 2.0, 0.4);
}

TEST(Verify, PassesAPlanFromRestToRestAndTellsAPerturbedOne) {
  transcription::NonlinearProgram program =
      test::make_program(test::extended_problem("double_integrator", ""));
  Vector x = solution(program);
  const PlanVerification good = verify_plan(program, x);
  EXPECT_TRUE(good.passed) << (good.failures.empty() ? "" : good.failures.front());
  EXPECT_LT(good.energy_balance, 1e-6);
  x[program.layout().nodes[10].q] += 0.005;
  const PlanVerification bad = verify_plan(program, x);
  EXPECT_FALSE(bad.passed);
  EXPECT_NEAR(bad.length_error, 0.005, 1e-4);
}

TEST(Verify, LeapAgreesWithItsNodes) {
  transcription::NonlinearProgram program =
      test::make_program(transcription::read_problem(test::problem_file("leap_tail_as_published")));
  const PlanVerification leap = verify_plan(program, solution(program));
  EXPECT_TRUE(leap.passed) << (leap.failures.empty() ? "" : leap.failures.front());
  EXPECT_LT(leap.length_error, 1e-3);
  EXPECT_LT(leap.angle_error, 0.1 * 3.14159265358979 / 180.0);
  EXPECT_LT(leap.velocity_error, 0.02);
}

}  // namespace
}  // namespace jaculus::solver
