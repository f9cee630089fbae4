// The leap on a coarse grid: it solves, the rows active at the solution are independent, and the
// same start gives the same bits.

#include <gtest/gtest.h>

#include <Eigen/SVD>

#include "jaculus/solver/ipopt.h"
#include "transcription/example_problems.h"

namespace jaculus::solver {
namespace {

transcription::Problem coarse_leap() {
  transcription::Problem problem =
      test::on_grid(test::extended_problem("leap_tail_as_published", ""), {6, 4});
  problem.guess = test::leap_guess();
  return problem;
}

NlpResult solve_leap(transcription::NonlinearProgram& program) {
  SolverOptions options;
  options.row_tolerance = 1e-6;
  return solve_nlp(program, {transcription::initial_guess(program, program.problem().guess, 1), {}},
                   options);
}

/// Gradients of the equalities and of the inequalities at their bounds, by the variables that are
/// not at theirs; scaled.
Matrix active_jacobian(transcription::NonlinearProgram& program, const Vector& x) {
  Vector g(program.rows()), values(program.jacobian_sparsity().size());
  EXPECT_TRUE(program.constraints(x, g) && program.jacobian(x, values));
  Matrix J = Matrix::Zero(program.rows(), program.variables());
  for (int k = 0; k < values.size(); ++k) {
    const int i = program.jacobian_sparsity().rows[k];
    const int j = program.jacobian_sparsity().columns[k];
    J(i, j) += values[k] * program.variable_scale()[j] / program.row_scale()[i];
  }
  const auto at = [](double v, double lower, double upper, double scale) {
    return std::min(v - lower, upper - v) < 1e-5 * scale;
  };
  std::vector<int> rows, columns;
  for (int i = 0; i < program.rows(); ++i)
    if (at(g[i], program.row_lower()[i], program.row_upper()[i], program.row_scale()[i]))
      rows.push_back(i);
  for (int j = 0; j < program.variables(); ++j)
    if (!at(x[j], program.variable_lower()[j], program.variable_upper()[j],
            program.variable_scale()[j]))
      columns.push_back(j);
  return J(rows, columns);
}

TEST(Leap, RowsActiveAtTheSolutionAreIndependent) {
  transcription::NonlinearProgram program = test::make_program(coarse_leap());
  const NlpResult result = solve_leap(program);
  ASSERT_TRUE(result.converged()) << to_string(result.status);
  const Matrix active = active_jacobian(program, result.x());
  ASSERT_LE(active.rows(), active.cols());
  const Vector singular = active.bdcSvd().singularValues();
  EXPECT_GT(singular.minCoeff(), 1e-7 * singular.maxCoeff());
}

TEST(Leap, SameStartGivesTheSameBits) {
  transcription::NonlinearProgram first = test::make_program(coarse_leap()),
                                  second = test::make_program(coarse_leap());
  const NlpResult a = solve_leap(first), b = solve_leap(second);
  ASSERT_TRUE(a.converged());
  EXPECT_TRUE((a.x().array() == b.x().array()).all());
  EXPECT_EQ(a.iterations, b.iterations);
}

TEST(Leap, HopLandsAndStands) {
  transcription::NonlinearProgram program =
      test::make_program(test::on_grid(test::extended_problem("hop", ""), {8, 6, 8}));
  const NlpResult result = solve_leap(program);
  ASSERT_TRUE(result.converged()) << to_string(result.status);
  const trajectory::Trajectory plan = transcription::to_trajectory(program, result.x());
  // At rest in all joints although only the rates that stance leaves free are fixed; the rest is
  // integration error.
  EXPECT_LT(plan.velocity.col(plan.samples() - 1).cwiseAbs().maxCoeff(), 0.3);
}

}  // namespace
}  // namespace jaculus::solver
