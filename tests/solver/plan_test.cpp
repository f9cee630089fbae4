// make_plan: feasibility stages before random starts, finer meshes, and what is said where they
// fail.

#include "jaculus/solver/plan.h"

#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "jaculus/components/motor.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/solver/summary.h"
#include "transcription/example_problems.h"

namespace jaculus::solver {
namespace {

Plan solve(const transcription::Problem& problem) {
  const model::Robot robot = model::read_robot(problem.robot_folder, problem.overrides);
  return make_plan(problem, robot.planar);
}

transcription::Problem coarse_leap(const std::string& lines) {
  transcription::Problem problem = test::extended_problem("leap_tail_as_published", lines);
  problem.phases[0].intervals = 6;
  problem.phases[0].mesh = {1, 1, 1, 1, 1, 0.6};
  problem.phases[1].intervals = 4;
  return problem;
}

TEST(Plan, RandomStartsPassThroughAFeasibilityStage) {
  transcription::Problem problem = coarse_leap("solver: {starts: 5}");
  const Plan plan = solve(problem);
  ASSERT_TRUE(plan.converged());
  EXPECT_EQ(plan.starts.converged, 5);
  EXPECT_GE(plan.starts.near_best, 1);
  problem.solver.starts = 1;
  problem.guess.kind = "random";
  const Plan random = solve(problem);
  ASSERT_TRUE(random.converged());
  EXPECT_GT(random.result.feasibility_iterations, 0);
  EXPECT_LT(random.result.feasibility_iterations, random.result.iterations);
}

std::string warnings_of(const Plan& plan, const transcription::Problem& problem) {
  return fmt::format("{}", fmt::join(summarise(plan, problem).warnings, "\n"));
}

TEST(Plan, AnInterruptBetweenStartsIsSaidWithHowManyHadEnded) {
  transcription::Problem problem = coarse_leap("solver: {starts: 5}");
  const model::Robot robot = model::read_robot(problem.robot_folder, problem.overrides);
  PlanOptions options;
  options.starts_progress = [](const TaskProgress& p) {
    if (p.done == 2) request_interrupt();
  };
  const Plan plan = make_plan(problem, robot.planar, options);
  clear_interrupt();
  ASSERT_TRUE(plan.converged());
  EXPECT_EQ(plan.starts.ended, 2);
  const std::string said = warnings_of(plan, problem);
  EXPECT_NE(said.find("interrupted: 2 of 5 starts had ended"), std::string::npos) << said;
  EXPECT_NE(said.find("2 of 2 starts converged (100 %)"), std::string::npos) << said;

  const Plan whole = make_plan(problem, robot.planar);
  EXPECT_EQ(whole.starts.ended, 5);
  EXPECT_EQ(warnings_of(whole, problem).find("interrupted"), std::string::npos);
}

TEST(Plan, AnEndAtTheLeastSpeedThatIsAskedForIsSaid) {
  // v/T grows as leaps get shorter, so that the problem's least speed decides: [1.3, 20] m/s
  const transcription::Problem bounded = coarse_leap("");
  const Plan plan = solve(bounded);
  ASSERT_TRUE(plan.converged());
  EXPECT_NE(warnings_of(plan, bounded)
                .find("v/T stands at a bound: at the plan's end the velocity of the base's x is "
                      "the least that the problem allows, 1.3 m/s"),
            std::string::npos)
      << warnings_of(plan, bounded);

  // what is imposed is no bound
  const transcription::Problem imposed = coarse_leap("final: {velocity: {x: 1.4 m/s}}");
  const Plan other = solve(imposed);
  ASSERT_TRUE(other.converged());
  EXPECT_EQ(warnings_of(other, imposed).find("v/T stands at a bound"), std::string::npos);
}

TEST(Plan, ALeapWithoutFlightIsSaid) {
  const transcription::Problem rising = coarse_leap("final: {velocity: {x: 1.4 m/s}}");
  const Plan leap = solve(rising);
  ASSERT_TRUE(leap.converged());
  EXPECT_EQ(warnings_of(leap, rising).find("no flight follows"), std::string::npos);

  const transcription::Problem falling =
      coarse_leap("final: {velocity: {x: 1.4 m/s, z: -0.3 m/s}}");
  const Plan fall = solve(falling);
  ASSERT_TRUE(fall.converged());
  EXPECT_NE(warnings_of(fall, falling)
                .find("no flight follows: at the plan's end the centre of "
                      "mass falls"),
            std::string::npos)
      << warnings_of(fall, falling);
}

/// Times [s] at which the least normal force of the front foot is asked for.
std::vector<double> window_times(transcription::NonlinearProgram& program, const Vector& x) {
  std::vector<double> times;
  double start = 0.0;
  EXPECT_TRUE(program.evaluate_at(x));
  for (const transcription::Interval& interval : program.intervals()) {
    for (const transcription::PathRows& rows : interval.path)
      if (rows.term->name == "front_foot normal force")
        times.push_back(start + 0.5 * rows.point * interval.length());
    start += interval.length();
  }
  return times;
}

TEST(Plan, RefinementKeepsTheWindowOfALimitInTime) {
  transcription::Problem problem = coarse_leap("refinement: {max_rounds: 1, tolerance: 1e-12}");
  const Plan plan = solve(problem);
  ASSERT_TRUE(plan.converged());
  ASSERT_EQ(plan.refinements, 1) << plan.refinement_failure;
  ASSERT_EQ(plan.mesh_rounds.size(), 2u);
  EXPECT_EQ(plan.mesh_rounds[1].intervals, (std::vector<int>{12, 8}));
  const double first_phase = plan.result.x()[plan.program->layout().phases[0].duration];
  const std::vector<double> times = window_times(*plan.program, plan.result.x());
  ASSERT_FALSE(times.empty());
  // The file leaves out three points of a grid of six intervals: everything from the start of its
  // last one, 5/5.6 of the phase. On the finer grid the last point before that is the middle of the
  // tenth interval, 4.75/5.6.
  EXPECT_NEAR(times.back() / first_phase, 4.75 / 5.6, 1e-9);
}

/// The leap with inputs that are linear, on few intervals.
transcription::Problem strict_leap(const std::string& lines) {
  return coarse_leap("transcription: {inputs: linear, check_interval_end: true}\n" + lines);
}

TEST(Plan, RefinementEndsWhereLimitsHoldBetweenNodes) {
  const Plan loose = solve(strict_leap("refinement: {max_rounds: 0}"));
  ASSERT_TRUE(loose.converged());
  EXPECT_GT(loose.verification->interval_excess.maxCoeff(), 5e-3) << "nothing is left to refine";

  const Plan held = solve(strict_leap("refinement: {max_rounds: 6, tolerance: 1, limits: 0.1 %}"));
  ASSERT_TRUE(held.converged());
  EXPECT_TRUE(held.verification->passed);
  EXPECT_LE(held.verification->interval_excess.maxCoeff(), 1e-3);
  EXPECT_GT(held.refinements, 0);
  // only where a limit was passed
  EXPECT_LT(held.mesh_rounds.back().intervals[0], 6 << held.refinements);
}

TEST(Plan, AFinerMeshMayDoWorseWhereTheCoarserOnePassedItsLimits) {
  // Eight intervals let the slider pass 0.3 m/s on the way from node to node, so that finer meshes,
  // which split those intervals, take longer: 1/0.3 + 0.3 s are the best. (Two can hold it with a
  // plan of 5 s, one of many that are as short there: nothing is left to refine then.)
  transcription::Problem problem =
      test::extended_problem("double_integrator",
                             "bounds: {velocity: {slide: [-0.3 m/s, 0.3 m/s]}}\n"
                             "transcription: {inputs: linear}\n"
                             "refinement: {max_rounds: 10, tolerance: 1, limits: 0.5 %}");
  problem.phases[0].intervals = 4;
  const Plan plan = solve(problem);
  ASSERT_TRUE(plan.converged());
  EXPECT_EQ(plan.refinement_failure, "");
  double largest_rise = 0.0;
  for (std::size_t k = 1; k < plan.mesh_rounds.size(); ++k)
    largest_rise = std::max(largest_rise,
                            plan.mesh_rounds[k].duration / plan.mesh_rounds[k - 1].duration - 1.0);
  EXPECT_GT(largest_rise, 0.01) << "no round did worse than the one before";
  const double best = 1.0 / 0.3 + 0.3, last = plan.mesh_rounds.back().duration;
  EXPECT_GT(last, 0.995 * best);
  EXPECT_LT(last, 1.03 * best) << "intervals that pass no limit stay long";
}

TEST(Plan, LimitsThatAreAskedForAndDontHoldFailTheVerification) {
  const Plan plan = solve(strict_leap("refinement: {max_rounds: 0, limits: 0.1 %}"));
  ASSERT_TRUE(plan.converged());
  EXPECT_FALSE(plan.verification->passed);
  const std::vector<std::string>& failures = plan.verification->failures;
  EXPECT_TRUE(std::any_of(failures.begin(), failures.end(), [](const std::string& failure) {
    return failure.find("between nodes") != std::string::npos;
  }));
  const Plan same = solve(strict_leap("refinement: {max_rounds: 0}"));
  EXPECT_LT(same.verification->failures.size(), failures.size()) << "nothing was asked for";
}

TEST(Plan, VoltageWithASampleTimeIsThatAtTheEndsOfTheSample) {
  const transcription::Problem problem =
      strict_leap("constraints: [{type: voltage, sample_time: 4 ms}]");
  const Plan plan = solve(problem);
  ASSERT_TRUE(plan.converged());
  const components::Equations& equations = plan.program->equations();
  const model::PlanarModel& model = equations.model();
  double highest = 0.0;
  ASSERT_TRUE(plan.program->evaluate_at(plan.result.x()));
  for (const transcription::Interval& interval : plan.program->intervals()) {
    for (int point = 0; point < 3; ++point) {
      const components::EquationsPoint& at = interval.point(point);
      for (int m = 0; m < count_of(model.motors); ++m) {
        const auto row = model.joint_map.row(model.motors[m].body);
        for (const double t : {-2e-3, 2e-3}) {
          const double rate = row.dot(at.v) + t * row.dot(at.a);
          const double volts =
              components::motor_voltage(model.motors[m], interval.input(point)[m], rate).value;
          highest = std::max(highest, std::abs(volts));
        }
      }
    }
  }
  EXPECT_LE(highest, 7.0 * (1.0 + 1e-6));
  EXPECT_GT(highest, 7.0 * (1.0 - 1e-4)) << "the limit holds nothing back";
}

TEST(Plan, AFinerSolveThatFailsIsTold) {
  transcription::Problem problem = coarse_leap("refinement: {max_rounds: 0}");
  const test::TemporaryFolder folder;
  problem.guess.file = folder.write("solution.json", solution_json(solve(problem)).dump());
  problem.guess.kind = "file";
  // As many iterations as the first mesh takes from its own solution, which the finer one does not
  // get by with.
  const Plan first = solve(problem);
  problem.refinement.max_rounds = 1;
  problem.refinement.tolerance = 1e-12;
  const Plan whole = solve(problem);
  ASSERT_EQ(whole.refinements, 1) << whole.refinement_failure;
  problem.solver.max_iterations = std::max(first.result.iterations, 1);
  ASSERT_GT(whole.mesh_rounds[1].iterations, problem.solver.max_iterations);

  const Plan cut = solve(problem);
  EXPECT_TRUE(cut.converged());
  EXPECT_EQ(cut.refinements, 0);
  EXPECT_NE(cut.refinement_failure.find("12 + 8 intervals, ended 'iteration_limit'"),
            std::string::npos)
      << cut.refinement_failure;
}

const PlanLimit* find_limit(const Plan& plan, const std::string& name) {
  for (const PlanLimit& limit : plan.limits)
    if (limit.name == name) return &limit;
  return nullptr;
}

TEST(Plan, ActiveLimitsNameBoundsInputsAndDurations) {
  const Plan plan = solve(coarse_leap(""));
  ASSERT_TRUE(plan.converged());
  const PlanLimit* velocity = find_limit(plan, "bound on x velocity");
  ASSERT_NE(velocity, nullptr);  // v >= 1.3 makes the leap one of least time
  EXPECT_EQ(velocity->phase, "rear_feet");
  EXPECT_NE(find_limit(plan, "rear_foot friction forward"), nullptr);
  EXPECT_EQ(find_limit(plan, "bound on duration"), nullptr);
  transcription::Problem brief = coarse_leap("");
  brief.phases[1].duration.lower = 0.02;
  const Plan longer = solve(brief);
  ASSERT_TRUE(longer.converged());
  const PlanLimit* duration = find_limit(longer, "bound on duration");
  ASSERT_NE(duration, nullptr);
  EXPECT_EQ(duration->phase, "rear_feet");
}

TEST(Plan, EnergyBalancesWithTheFrictionOfTheMotors) {
  // Work at the joint is the potential energy gained, 2 x 9.81 J; the motor itself makes more.
  const Plan plan = solve(test::extended_problem(
      "pendulum_swing_up", "override: {motors.swing.viscous_friction: 0.05}"));
  ASSERT_TRUE(plan.converged());
  ASSERT_TRUE(plan.verification.has_value());
  const PlanVerification& v = *plan.verification;
  EXPECT_TRUE(v.passed);
  EXPECT_LT(v.motion_energy_balance, 1e-8);
  EXPECT_NEAR(v.motor_work, 2.0 * 9.81, 0.02);
}

TEST(Plan, VerificationFailsWhatIsNoNumberAndWhatIsFarBeyondALimit) {
  transcription::NonlinearProgram program = test::make_program(coarse_leap(""));
  const Plan plan = solve(coarse_leap(""));
  ASSERT_TRUE(plan.converged());
  VerifyOptions options;
  options.length = options.angle = options.velocity = options.rate =
      1.0;  // a coarse grid; limits are what this is about
  options.balance = 1.0;
  options.between = 0.5;
  EXPECT_TRUE(verify_plan(program, plan.result.x(), options).passed);
  options.between = 1e-3;
  const PlanVerification strict = verify_plan(program, plan.result.x(), options);
  EXPECT_FALSE(strict.passed);
  ASSERT_FALSE(strict.failures.empty());
  EXPECT_NE(strict.failures.front().find("between nodes"), std::string::npos)
      << strict.failures.front();
  options.between = kNaN;
  EXPECT_FALSE(verify_plan(program, plan.result.x(), options).passed);
  options.between = 0.5;
  options.rate = 0.0;
  EXPECT_FALSE(verify_plan(program, plan.result.x(), options).passed);
}

TEST(Plan, GuessFromAnotherRobotNamesItsGaps) {
  const Plan tailless = solve(test::on_grid(test::extended_problem("leap_tailless", ""), {6, 4}));
  ASSERT_TRUE(tailless.trajectory.has_value());
  const transcription::NonlinearProgram program = test::make_program(coarse_leap(""));
  const std::vector<std::string> gaps = transcription::guess_gaps(program, *tailless.trajectory);
  ASSERT_EQ(gaps.size(), 2u);  // its coordinate and its motor
  EXPECT_NE(gaps[0].find("coordinate 'tail'"), std::string::npos) << gaps[0];
  EXPECT_NE(gaps[1].find("motor 'tail'"), std::string::npos) << gaps[1];
}

}  // namespace
}  // namespace jaculus::solver
