// The leap on a coarse grid: it solves, the rows active at the solution are independent, and the same start gives the same bits.

#include <gtest/gtest.h>

#include <Eigen/SVD>

#include "jaculus/solver/ipopt.h"
#include "transcription/programmes.h"

namespace jaculus {
namespace {

Problem coarse_leap() {
  Problem problem = test::on_grid(test::extended_problem("leap_tail", ""), {6, 4});
  problem.guess = test::leap_guess();
  return problem;
}

NlpResult solve(Programme& programme) {
  SolverOptions options;
  options.row_tolerance = 1e-6;
  return solve_nlp(programme, {initial_guess(programme, programme.problem().guess, 1), {}}, options);
}

/// Gradients of the equalities and of the inequalities at their bounds, by the variables that are not at theirs; scaled.
Matrix active_jacobian(Programme& programme, const Vector& x) {
  Vector g(programme.rows()), values(programme.jacobian_sparsity().size());
  EXPECT_TRUE(programme.constraints(x, g) && programme.jacobian(x, values));
  Matrix J = Matrix::Zero(programme.rows(), programme.variables());
  for (int k = 0; k < values.size(); ++k) {
    const int i = programme.jacobian_sparsity().rows[static_cast<size_t>(k)];
    const int j = programme.jacobian_sparsity().columns[static_cast<size_t>(k)];
    J(i, j) += values[k] * programme.variable_scale()[j] / programme.row_scale()[i];
  }
  const auto at = [](double v, double lower, double upper, double scale) {
    return std::min(v - lower, upper - v) < 1e-5 * scale;
  };
  std::vector<int> rows, columns;
  for (int i = 0; i < programme.rows(); ++i)
    if (at(g[i], programme.row_lower()[i], programme.row_upper()[i], programme.row_scale()[i])) rows.push_back(i);
  for (int j = 0; j < programme.variables(); ++j)
    if (!at(x[j], programme.variable_lower()[j], programme.variable_upper()[j], programme.variable_scale()[j]))
      columns.push_back(j);
  return J(rows, columns);
}

TEST(Leap, RowsActiveAtTheSolutionAreIndependent) {
  Programme programme = test::make_programme(coarse_leap());
  const NlpResult result = solve(programme);
  ASSERT_TRUE(result.converged()) << to_string(result.status);
  const Matrix active = active_jacobian(programme, result.x());
  ASSERT_LE(active.rows(), active.cols());
  const Vector singular = active.bdcSvd().singularValues();
  EXPECT_GT(singular.minCoeff(), 1e-7 * singular.maxCoeff());
}

TEST(Leap, SameStartGivesTheSameBits) {
  Programme first = test::make_programme(coarse_leap()), second = test::make_programme(coarse_leap());
  const NlpResult a = solve(first), b = solve(second);
  ASSERT_TRUE(a.converged());
  EXPECT_TRUE((a.x().array() == b.x().array()).all());
  EXPECT_EQ(a.iterations, b.iterations);
}

TEST(Leap, HopLandsAndStands) {
  Programme programme = test::make_programme(test::on_grid(test::extended_problem("hop", ""), {8, 6, 8}));
  const NlpResult result = solve(programme);
  ASSERT_TRUE(result.converged()) << to_string(result.status);
  const Trajectory plan = to_trajectory(programme, result.x());
  // At rest in all joints although only the rates that stance leaves free are fixed; the rest is integration error.
  EXPECT_LT(plan.velocity.col(plan.samples() - 1).cwiseAbs().maxCoeff(), 0.3);
}

}  // namespace
}  // namespace jaculus
