// Dry friction of motors: what the motor gives against it stands beside a plan's inputs.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "jaculus/components/motor.h"
#include "jaculus/transcription/derivative_check.h"
#include "support/input_error.h"
#include "transcription/example_problems.h"

namespace jaculus::transcription {
namespace {

using test::extended_problem;
using test::on_grid;

constexpr double kDry = 0.1;  // [N m]

/// The leap with linear inputs and the lines of the test, every joint with a motor rubbing.
struct Rubbing {
  explicit Rubbing(const std::string& lines, double dry = kDry)
      : problem(on_grid(extended_problem("leap_tail", lines), {3, 2})),
        smooth(test::model_of(problem)),
        model(smooth) {
    for (model::PlanarMotor& motor : model.motors) motor.dry_friction = dry;
  }
  Problem problem;
  model::PlanarModel smooth, model;
};

/// A point of the program at which joints turn slowly enough for friction to be curved.
Vector slow_point(NonlinearProgram& program) {
  const Vector guess = initial_guess(program, test::leap_guess(), 0);
  Vector x = random_point(program, guess, 0.05, 7);
  for (const NodeBlock& node : program.layout().nodes)
    x.segment(node.v, program.layout().n) *= 0.01;
  return x;
}

TEST(DryFriction, PowerAndVoltageHaveExactDerivatives) {
  for (const char* lines : {"objective: {minimise: [{type: electrical_energy}]}",
                            "constraints: [{type: voltage, sample_time: 2 ms}]"}) {
    SCOPED_TRACE(lines);
    const Rubbing robot(lines);
    NonlinearProgram program(robot.problem, robot.model);
    const DerivativeReport report = check_derivatives(program, slow_point(program));
    ASSERT_TRUE(report.defined);
    for (const auto& error : {report.gradient, report.jacobian, report.hessian})
      EXPECT_LT(error.error, 1e-6) << error.row << " by " << error.column;
  }
}

TEST(DryFriction, ChangesNoMotionAndIsPartOfTheTorque) {
  const Rubbing robot("");
  NonlinearProgram with(robot.problem, robot.model), without(robot.problem, robot.smooth);
  const Vector x = slow_point(with);
  const trajectory::Trajectory rubbing = to_trajectory(with, x), smooth = to_trajectory(without, x);
  ASSERT_EQ(rubbing.acceleration, smooth.acceleration);
  for (int m = 0; m < count_of(robot.model.motors); ++m) {
    const int body = robot.model.motors[m].body;
    for (int k = 0; k < rubbing.torque.cols(); ++k) {
      const double against = kDry * std::tanh(rubbing.joint_velocity(body - 1, k) / 0.1);
      EXPECT_NEAR(rubbing.torque(m, k) - smooth.torque(m, k), against, 1e-12);
    }
  }
}

TEST(DryFriction, AnEarlierPlanGivesItsInputsBack) {
  const Rubbing robot("");
  NonlinearProgram program(robot.problem, robot.model);
  const Vector x = slow_point(program);
  const trajectory::Trajectory earlier = to_trajectory(program, x);
  GuessSpec spec;
  spec.kind = "file";
  const Vector again = initial_guess(program, spec, 0, &earlier);
  const Layout& layout = program.layout();
  for (const IntervalBlock& interval : layout.intervals)
    EXPECT_LT((again - x).segment(interval.u_first, layout.n_u).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(DryFriction, LeavesLessOfTheTorqueAndTheVoltage) {
  const Rubbing robot("constraints: [{type: voltage}]");
  const NonlinearProgram program(robot.problem, robot.model);
  const Layout& layout = program.layout();
  for (int m = 0; m < layout.n_u; ++m) {
    const double largest = usable_torque(robot.problem, robot.model, robot.model.motors[m]);
    EXPECT_NEAR(layout.upper[layout.intervals.front().u_first + m], largest - kDry, 1e-12);
    EXPECT_NEAR(layout.lower[layout.intervals.front().u_first + m], kDry - largest, 1e-12);
  }

  // a row for friction with the torque and one for friction against it
  const std::vector<PathTerm>& terms = program.path_terms().front();
  const auto voltage = std::find_if(terms.begin(), terms.end(), [](const PathTerm& term) {
    return term.name == "front_a voltage" && term.rows.size() == 2;
  });
  ASSERT_NE(voltage, terms.end());
  EXPECT_TRUE(std::isinf(voltage->rows[0].bounds.upper));
  EXPECT_TRUE(std::isinf(voltage->rows[1].bounds.lower));
}

TEST(DryFriction, ThatLeavesNothingToMoveAJointWithIsRefused) {
  const Rubbing robot("", 1000.0);
  const std::string message =
      test::input_error_of([&] { const NonlinearProgram program(robot.problem, robot.model); });
  EXPECT_TRUE(test::holds(message, "motors.front_a: dry_friction: 1000 given"));
}

}  // namespace
}  // namespace jaculus::transcription
