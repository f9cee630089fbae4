// Problems whose optimum is known in closed form, through the whole transcription and Ipopt.

#include <gtest/gtest.h>

#include "jaculus/solver/ipopt.h"
#include "jaculus/solver/verify.h"
#include "transcription/example_problems.h"

namespace jaculus::solver {
namespace {

struct Solved {
  Vector x;
  trajectory::Trajectory plan;
};

Solved solve(transcription::NonlinearProgram& program) {
  SolverOptions options;
  options.tolerance = 1e-9;
  options.row_tolerance = 1e-9;
  const NlpResult result = solve_nlp(
      program, {transcription::initial_guess(program, program.problem().guess, 1), {}}, options);
  EXPECT_TRUE(result.converged()) << to_string(result.status);
  return {result.last_iterate(), transcription::to_trajectory(program, result.last_iterate())};
}

// Rest to rest over d with |u| <= 1: T = 2 sqrt(d), full force forward, then back, the switch on
// the middle node.
TEST(KnownAnswers, TimeOptimalDoubleIntegratorIsBangBang) {
  transcription::NonlinearProgram program =
      test::make_program(test::extended_problem("double_integrator", ""));
  const trajectory::Trajectory plan = solve(program).plan;
  const int last = plan.samples() - 1;
  EXPECT_NEAR(plan.time[last], 2.0, 1e-7);
  for (int k = 0; k < last; ++k)
    EXPECT_NEAR(plan.torque(0, k), k < last / 2 ? 1.0 : -1.0, 1e-5) << "sample " << k;
}

// Least integral of u^2 from rest to rest over 1 m in 1 s: u = 6 - 12 t, cost 12 (Euler-Lagrange;
// Kirk, Optimal Control Theory, section 5.1, the minimum-energy double integrator).
TEST(KnownAnswers, LeastEnergyDoubleIntegratorIsLinear) {
  transcription::NonlinearProgram program = test::make_program(test::extended_problem(
      "double_integrator",
      "override: {motors.slide.torque_limit: 100 N}\nphases: [{name: move, contacts: [], "
      "intervals: 8, duration: 1 s}]\n"
      "objective: {minimise: [{type: torque_squared}]}\ntranscription: {inputs: linear}\n"
      "guess: {kind: line, poses: [{slide: 0 m}, {slide: 1 m}]}"));
  const Solved solved = solve(program);
  double cost = 0.0;
  ASSERT_TRUE(program.objective(solved.x, cost));
  EXPECT_NEAR(cost, 12.0, 1e-7);
  for (int k = 0; k < solved.plan.samples(); ++k)
    EXPECT_NEAR(solved.plan.torque(0, k), 6.0 - 12.0 * solved.plan.time[k], 1e-5);
}

// As shipped: the plan stands on its head for a while, where errors grow, and must pass with half
// of what is allowed to spare.
TEST(KnownAnswers, PendulumSwingUpPassesItsVerificationAsShipped) {
  transcription::NonlinearProgram program =
      test::make_program(transcription::read_problem(test::problem_file("pendulum_swing_up")));
  const transcription::GuessSpec& guess = program.problem().guess;
  const NlpResult result =
      solve_nlp(program, {transcription::initial_guess(program, guess, 1), {}});
  ASSERT_TRUE(result.converged());
  const VerifyOptions allowed;
  const PlanVerification verified = verify_plan(program, result.x(), allowed);
  EXPECT_TRUE(verified.passed) << (verified.failures.empty() ? "" : verified.failures.front());
  EXPECT_LT(verified.angle_error, 0.5 * allowed.angle);
  EXPECT_LT(verified.rate_error, 0.5 * allowed.rate);
}

// Swung from hanging to upright at rest: the motor's work is the potential energy 2 m g l.
TEST(KnownAnswers, PendulumSwingUpDoesTheWorkOfTheHeight) {
  transcription::NonlinearProgram program = test::make_program(test::extended_problem(
      "pendulum_swing_up", "phases: [{name: swing, contacts: [], intervals: 100, duration: 4 s}]"));
  const trajectory::Trajectory plan = solve(program).plan;
  double work = 0.0;  // Simpson over nodes and middles
  for (int k = 0; k + 2 < plan.samples(); k += 2) {
    const auto power = [&](int i) { return plan.torque(0, i) * plan.joint_velocity(0, i); };
    work +=
        (plan.time[k + 2] - plan.time[k]) / 6.0 * (power(k) + 4.0 * power(k + 1) + power(k + 2));
  }
  const model::PlanarModel& model = program.equations().model();
  const double height = -2.0 * model.bodies[1].mass * model.bodies[1].com.y() * model.gravity;
  EXPECT_NEAR(work, height, 1e-3 * height);
}

}  // namespace
}  // namespace jaculus::solver
