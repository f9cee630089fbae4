// Coarse meshes as the way to fine ones: multipliers that are carried over, few iterations, the
// same optimum.

#include "solver/prolong.h"

#include <gtest/gtest.h>

#include "jaculus/solver/plan.h"
#include "transcription/example_problems.h"

namespace jaculus::solver {
namespace {

transcription::Problem leap(int intervals) {
  return test::on_grid(test::extended_problem("leap_tailless", ""), {intervals, intervals});
}

/// Largest scaled element of grad f + J' rows - lower + upper over all variables that are free.
double stationarity(transcription::NonlinearProgram& program, const Vector& x, const Duals& duals) {
  const transcription::Sparsity& sparsity = program.jacobian_sparsity();
  Vector rate(program.variables()), jacobian(sparsity.size());
  EXPECT_TRUE(program.gradient(x, rate) && program.jacobian(x, jacobian));
  for (int k = 0; k < sparsity.size(); ++k)
    rate[sparsity.columns[k]] += jacobian[k] * duals.rows[sparsity.rows[k]];
  rate += duals.upper - duals.lower;
  double largest = 0.0;
  for (int i = 0; i < rate.size(); ++i)
    if (program.variable_lower()[i] < program.variable_upper()[i])
      largest = std::max(largest, std::abs(rate[i]) * program.variable_scale()[i]);
  return largest;
}

/// A leap on a coarse mesh, and its mesh halved with what the solution becomes there.
struct TwoMeshes {
  explicit TwoMeshes(int intervals)
      : coarse(test::make_program(leap(intervals))),
        fine(test::make_program(halved(intervals))),
        solution(solve_nlp(coarse, {transcription::initial_guess(coarse, leap(1).guess, 0)})),
        start(detail::prolong(coarse, solution, fine)) {}

  static transcription::Problem halved(int intervals) {
    transcription::Problem problem = leap(2 * intervals);
    for (transcription::PhaseSpec& phase : problem.phases) phase.stated_mesh.assign(intervals, 1.0);
    return problem;
  }

  transcription::NonlinearProgram coarse, fine;
  NlpResult solution;
  Start start;
};

TEST(Prolong, MultipliersAreNearlyStationaryOnTheFinerMesh) {
  TwoMeshes meshes(20);
  ASSERT_TRUE(meshes.solution.converged());
  const Duals none{Vector::Zero(meshes.fine.rows()), Vector::Zero(meshes.fine.variables()),
                   Vector::Zero(meshes.fine.variables())};
  const double without = stationarity(meshes.fine, meshes.start.x, none);
  EXPECT_LT(stationarity(meshes.fine, meshes.start.x, *meshes.start.duals), 0.5 * without);

  // Those of path rows as they stand, without the step's length, are no better than none.
  Duals unscaled = *meshes.start.duals;
  for (int i = 0; i < unscaled.rows.size(); ++i)
    if (meshes.fine.row_lower()[i] < meshes.fine.row_upper()[i]) unscaled.rows[i] *= 2.0;
  EXPECT_GT(stationarity(meshes.fine, meshes.start.x, unscaled), 0.5 * without);
}

TEST(Prolong, ALimitWeighsTheSameOnBothMeshes) {
  TwoMeshes meshes(20);
  const auto whole = [](const transcription::NonlinearProgram& program, const Vector& multipliers) {
    double sum = 0.0;
    for (const transcription::Interval& interval : program.intervals())
      for (const transcription::PathRows& rows : interval.path)
        if (rows.term->name.find("voltage") != std::string::npos)
          sum += multipliers.segment(rows.row, count_of(rows.term->rows)).cwiseAbs().sum();
    return sum;
  };
  const double coarse = whole(meshes.coarse, meshes.solution.row_multipliers);
  ASSERT_GT(coarse, 0.0) << "no voltage limit is active";
  EXPECT_NEAR(whole(meshes.fine, meshes.start.duals->rows), coarse, 0.05 * coarse);
}

TEST(Prolong, TheEndOfAPhaseKeepsItsOwnTorque) {
  TwoMeshes meshes(12);
  Vector rows(meshes.fine.rows());
  ASSERT_TRUE(meshes.fine.constraints(meshes.start.x, rows));
  int found = 0;
  for (int i = 0; i < rows.size(); ++i) {
    if (meshes.fine.row_name(i).find("force at the end") == std::string::npos) continue;
    EXPECT_NEAR(rows[i], 0.0, 1e-4) << meshes.fine.row_name(i);
    ++found;
  }
  EXPECT_EQ(found, 2);
}

TEST(Prolong, ComplementarityGoesWithTheMultipliers) {
  TwoMeshes meshes(20);
  const Start same = warm_start(meshes.solution);
  const double own = detail::mean_complementarity(meshes.coarse, same);
  EXPECT_GT(own, 0.0);
  EXPECT_LT(own, 1e-6) << "the solution is nearly complementary";

  Start doubled = same;
  doubled.duals->rows *= 2.0;
  doubled.duals->lower *= 2.0;
  doubled.duals->upper *= 2.0;
  EXPECT_NEAR(detail::mean_complementarity(meshes.coarse, doubled), 2.0 * own, 1e-9 * own);
}

TEST(Prolong, AFineMeshTakesNoMoreIterationsThanACoarseOne) {
  const auto solve = [](int intervals) {
    const transcription::Problem problem = leap(intervals);
    return make_plan(problem, test::model_of(problem));
  };
  const Plan coarse = solve(15), fine = solve(60);
  ASSERT_TRUE(coarse.converged() && fine.converged());
  ASSERT_EQ(fine.program->layout().intervals.size(), 120u);

  EXPECT_LE(fine.result.history.back().iteration, coarse.result.iterations);
  EXPECT_LE(fine.result.iterations, 1.5 * coarse.result.iterations) << "over all meshes";
  EXPECT_GT(fine.result.iterations, fine.result.history.back().iteration);

  // from the same guess on the fine mesh alone
  transcription::NonlinearProgram& program = *fine.program;
  SolverOptions options;
  options.row_tolerance = 1e-6;
  const NlpResult direct = solve_nlp(
      program, {transcription::initial_guess(program, program.problem().guess, 0)}, options);
  ASSERT_TRUE(direct.converged());
  EXPECT_LT(fine.result.history.back().iteration, direct.iterations / 2);
  EXPECT_NEAR(fine.result.objective, direct.objective, 1e-3 * std::abs(direct.objective));
}

}  // namespace
}  // namespace jaculus::solver
