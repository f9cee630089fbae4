#include "jaculus/solver/ipopt.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "jaculus/core/error.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/solver/violations.h"
#include "solver/small_nlps.h"

namespace jaculus::solver {
namespace {

using testing::DenseNlp;
using testing::hs071;
using testing::kHs071Start;
using testing::projection;
using testing::rosenbrock;

const Vector kHs071Solution = Eigen::Vector4d(1.0, 4.742999637, 3.821149979, 1.379408293);

/// Largest entry of grad f + J' lambda - z_lower + z_upper, evaluated here and not by the solver.
double stationarity(DenseNlp& nlp, const NlpResult& r) {
  Vector residual = nlp.df(r.x()) - r.lower_multipliers + r.upper_multipliers;
  if (nlp.rows() > 0) residual += nlp.dg(r.x()).transpose() * r.row_multipliers;
  return residual.cwiseAbs().maxCoeff();
}

TEST(Ipopt, SolvesHs071) {
  DenseNlp nlp = hs071();
  const NlpResult result = solve_nlp(nlp, {kHs071Start, {}});
  ASSERT_EQ(result.status, Status::optimal) << result.message;
  EXPECT_NEAR(result.objective, 17.0140173, 1e-5);
  EXPECT_LT((result.x() - kHs071Solution).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_LT(result.max_violation, 1e-6);
  EXPECT_LT(stationarity(nlp, result), 1e-5);
  EXPECT_GT(result.iterations, 3);
  EXPECT_EQ(count_of(result.history), result.iterations + 1);
  EXPECT_GT(result.evaluations.hessian, 3);
  EXPECT_GT(result.wall_seconds.total, 0.0);
  EXPECT_GE(result.wall_seconds.total,
            result.wall_seconds.functions + result.wall_seconds.linear_solver);
  EXPECT_GT(result.wall_seconds.linear_solver, 0.0);
}

TEST(Ipopt, ScalesChangeThePathButNotTheUnitsOfTheAnswer) {
  DenseNlp nlp = hs071();
  nlp.x_scale << 0.01, 10.0, 3.0, 100.0;
  nlp.g_scale << 25.0, 0.4;
  nlp.f_scale = 170.0;
  const NlpResult result = solve_nlp(nlp, {kHs071Start, {}}, {.tolerance = 1e-9});
  ASSERT_EQ(result.status, Status::optimal) << result.message;
  EXPECT_LT((result.x() - kHs071Solution).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_LT(stationarity(nlp, result), 1e-4);
}

TEST(Ipopt, SolvesWithoutRows) {
  DenseNlp nlp = rosenbrock();
  const NlpResult result = solve_nlp(nlp, {Eigen::Vector2d(-1.2, 1.0), {}}, {.tolerance = 1e-9});
  ASSERT_EQ(result.status, Status::optimal);
  EXPECT_LT((result.x() - Vector::Ones(2)).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(Ipopt, SolvesWithoutExactHessian) {
  DenseNlp nlp = rosenbrock();
  nlp.h = [](const Vector&, double, const Vector&) -> Matrix {
    throw std::logic_error("must not be called");
  };
  SolverOptions options;
  options.exact_hessian = false;
  const NlpResult result = solve_nlp(nlp, {Eigen::Vector2d(-1.2, 1.0), {}}, options);
  ASSERT_EQ(result.status, Status::optimal);
  EXPECT_EQ(result.evaluations.hessian, 0);
  EXPECT_LT((result.x() - Vector::Ones(2)).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(Ipopt, HistoryReportsTheUnscaledRowViolationOfItsOwnIterate) {
  DenseNlp nlp = hs071();
  nlp.g_scale << 1000.0, 1000.0;
  nlp.x_scale.setConstant(7.0);
  const NlpResult result = solve_nlp(nlp, {Vector::Constant(4, 2.0), {}});
  ASSERT_TRUE(result.converged());
  // Away from its bounds the start is taken as it is: the product is 16, the sum of squares 16.
  EXPECT_NEAR(result.history.front().infeasibility, 24.0, 1e-9);
  EXPECT_NEAR(result.history.front().objective, 2 * 2 * 6 + 2, 1e-9);
  EXPECT_LT(result.history.back().infeasibility, 1e-4);
}

TEST(Ipopt, SameInputsGiveTheSameBits) {
  DenseNlp nlp = hs071();
  const NlpResult a = solve_nlp(nlp, {kHs071Start, {}});
  const NlpResult b = solve_nlp(nlp, {kHs071Start, {}});
  EXPECT_EQ(a.x(), b.x());
  EXPECT_EQ(a.row_multipliers, b.row_multipliers);
  EXPECT_EQ(a.evaluations.objective, b.evaluations.objective);
}

TEST(Ipopt, KnownMultipliersOfAProjection) {
  // Nearest point to (3, 4) with x0 + x1 = 1, x1 <= 0.5: x = (0.5, 0.5), lambda = 2.5, upper
  // multiplier of x1 = 1.
  DenseNlp nlp = projection(Eigen::Vector2d(3, 4), Matrix::Ones(1, 2));
  nlp.g_lower << 1.0;
  nlp.g_upper << 1.0;
  nlp.x_upper[1] = 0.5;
  const NlpResult result = solve_nlp(nlp, {Vector::Zero(2), {}}, {.tolerance = 1e-10});
  ASSERT_EQ(result.status, Status::optimal);
  EXPECT_NEAR(result.x()[0], 0.5, 1e-7);
  EXPECT_NEAR(result.row_multipliers[0], 2.5, 1e-6);
  EXPECT_NEAR(result.upper_multipliers[1], 1.0, 1e-6);
  EXPECT_NEAR(result.lower_multipliers[1], 0.0, 1e-6);
}

TEST(Ipopt, FixedVariablesKeepTheirValueAndGetTheirMultiplier) {
  DenseNlp nlp = projection(Eigen::Vector3d(3, 4, -1), Matrix::Ones(1, 3));
  nlp.g_lower << 1.0;
  nlp.g_upper << 1.0;
  nlp.x_lower[1] = nlp.x_upper[1] = 0.25;
  const NlpResult result = solve_nlp(nlp, {Vector::Zero(3), {}}, {.tolerance = 1e-10});
  ASSERT_EQ(result.status, Status::optimal);
  EXPECT_EQ(result.x()[1], 0.25);
  EXPECT_LT(stationarity(nlp, result), 1e-6);
  // 4 - 0.25 minus the row's share: a larger value would be better
  EXPECT_GT(result.upper_multipliers[1], 1.0);
}

TEST(Ipopt, AllVariablesFixed) {
  DenseNlp nlp = projection(Eigen::Vector2d(3, 4), Matrix::Ones(1, 2));
  nlp.g_upper << 1.0;
  nlp.x_lower = nlp.x_upper = Vector::Constant(2, 0.5);
  EXPECT_EQ(solve_nlp(nlp, {Vector::Zero(2), {}}).status, Status::optimal);
  nlp.x_lower = nlp.x_upper = Vector::Constant(2, 0.6);
  EXPECT_EQ(solve_nlp(nlp, {Vector::Zero(2), {}}).status, Status::infeasible);
}

TEST(Ipopt, InfeasibleProblemIsCalledSo) {
  DenseNlp nlp = hs071();
  nlp.g_lower[1] = nlp.g_upper[1] = 120.0;  // the squares of four numbers up to 5 don't reach it
  const NlpResult result = solve_nlp(nlp, {kHs071Start, {}});
  EXPECT_EQ(result.status, Status::infeasible) << result.message;
  EXPECT_FALSE(result.converged());
  EXPECT_THROW(static_cast<void>(result.x()), std::logic_error);
  EXPECT_EQ(result.last_iterate().size(), 4);
  EXPECT_NEAR(result.max_violation, 20.0, 1e-3);
  int restorations = 0;
  for (const IterationInfo& info : result.history) {
    restorations += info.restoration;
    // The problem's own rows, not the restoration's relaxed ones. While it runs Ipopt widens bounds
    // by 1e-8 of their size, which makes room for 4 * 2 * 5 * 5e-8 here.
    EXPECT_GE(info.infeasibility, 20.0 - 2.1e-6);
  }
  EXPECT_GT(restorations, 0);
}

TEST(Ipopt, ContradictoryBoundsAreNamedBeforeAnythingRuns) {
  DenseNlp nlp = hs071();
  nlp.x_lower[2] = 6.0;
  nlp.g_lower[1] = kNaN;
  nlp.f = [](const Vector&, double&) -> bool { throw std::logic_error("must not be called"); };
  const NlpResult result = solve_nlp(nlp, {kHs071Start, {}});
  ASSERT_EQ(result.status, Status::contradictory_bounds);
  ASSERT_EQ(result.conflicts.size(), 2u);
  EXPECT_EQ(result.conflicts[0].name, "x2");
  EXPECT_EQ(result.conflicts[0].lower, 6.0);
  EXPECT_EQ(result.conflicts[1].name, "row 1");
  EXPECT_NE(result.message.find("x2 in [6, 5] m"), std::string::npos) << result.message;
}

TEST(Ipopt, TooManyEquations) {
  Matrix a(3, 2);
  a << 1, 0, 0, 1, 1, 1;
  DenseNlp nlp = projection(Vector::Zero(2), a);
  nlp.g_lower = nlp.g_upper = Eigen::Vector3d(1, 1, 3);
  EXPECT_EQ(solve_nlp(nlp, {Vector::Zero(2), {}}).status, Status::no_freedom);
}

TEST(Ipopt, IterationLimit) {
  DenseNlp nlp = rosenbrock();
  const NlpResult result = solve_nlp(nlp, {Eigen::Vector2d(-1.2, 1.0), {}}, {.max_iterations = 3});
  EXPECT_EQ(result.status, Status::iteration_limit);
  EXPECT_EQ(result.iterations, 3);
  double f = kNaN;
  ASSERT_TRUE(nlp.f(result.last_iterate(), f));
  EXPECT_EQ(f, result.objective);
}

TEST(Ipopt, TimeLimit) {
  DenseNlp nlp = rosenbrock();
  EXPECT_EQ(solve_nlp(nlp, {Eigen::Vector2d(-1.2, 1.0), {}}, {.time_limit_s = 0.0}).status,
            Status::time_limit);
}

TEST(Ipopt, CallbackStopsAndKeepsTheIterate) {
  DenseNlp nlp = rosenbrock();
  SolverOptions options;
  options.progress = [](const IterationInfo& info) { return info.iteration < 5; };
  const NlpResult result = solve_nlp(nlp, {Eigen::Vector2d(-1.2, 1.0), {}}, options);
  EXPECT_EQ(result.status, Status::stopped);
  EXPECT_EQ(result.iterations, 5);
  EXPECT_EQ(result.history.back().objective, result.objective);
  EXPECT_LT(result.objective, 24.2);  // the start's is 24.2
}

TEST(Ipopt, InterruptStopsAtTheNextIteration) {
  DenseNlp nlp = rosenbrock();
  SolverOptions options;
  options.progress = [](const IterationInfo& info) {
    if (info.iteration == 4) request_interrupt();
    return true;
  };
  const NlpResult result = solve_nlp(nlp, {Eigen::Vector2d(-1.2, 1.0), {}}, options);
  clear_interrupt();
  EXPECT_EQ(result.status, Status::interrupted);
  EXPECT_EQ(result.iterations, 4);
}

TEST(Ipopt, UnboundedProblemDiverges) {
  DenseNlp nlp = projection(Vector::Zero(2), Matrix::Ones(1, 2));
  nlp.f = [](const Vector& x, double& f) {
    f = -x.sum();
    return true;
  };
  nlp.df = [](const Vector&) -> Vector { return -Vector::Ones(2); };
  nlp.h = [](const Vector&, double, const Vector&) -> Matrix { return Matrix::Zero(2, 2); };
  EXPECT_EQ(solve_nlp(nlp, {Vector::Zero(2), {}}).status, Status::diverged);
}

TEST(Ipopt, StepsBackWhereFunctionsAreUndefined) {
  // minimise x - log x: defined for x > 0 only, and a full Newton step from 3 leaves that half
  // line.
  DenseNlp nlp(1, 0);
  int undefined = 0;
  nlp.f = [&](const Vector& x, double& f) {
    if (x[0] <= 0.0) {
      ++undefined;
      return false;
    }
    f = x[0] - std::log(x[0]);
    return true;
  };
  nlp.df = [](const Vector& x) -> Vector { return Vector::Constant(1, 1 - 1 / x[0]); };
  nlp.h = [](const Vector& x, double s, const Vector&) -> Matrix {
    return Matrix::Constant(1, 1, s / (x[0] * x[0]));
  };
  const NlpResult result = solve_nlp(nlp, {Vector::Constant(1, 3.0), {}});
  ASSERT_EQ(result.status, Status::optimal) << result.message;
  EXPECT_NEAR(result.x()[0], 1.0, 1e-5);
  EXPECT_GT(undefined, 0);
}

TEST(Ipopt, UndefinedOrNotFiniteAtTheStart) {
  DenseNlp nlp = hs071();
  nlp.g = [](const Vector&, Vector&) { return false; };
  const NlpResult result = solve_nlp(nlp, {kHs071Start, {}});
  EXPECT_EQ(result.status, Status::evaluation_failed);
  EXPECT_NE(result.message.find("constraints"), std::string::npos) << result.message;
  EXPECT_TRUE(std::isnan(result.max_violation));
  EXPECT_EQ(result.last_iterate(), kHs071Start);

  DenseNlp other = hs071();
  other.df = [](const Vector&) -> Vector { return Vector::Constant(4, kNaN); };
  EXPECT_EQ(solve_nlp(other, {kHs071Start, {}}).status, Status::evaluation_failed);
}

TEST(Ipopt, ExceptionsOfTheFunctionsPassThrough) {
  DenseNlp nlp = hs071();
  int calls = 0;
  nlp.h = [&](const Vector&, double, const Vector&) -> Matrix {
    if (++calls == 3) throw std::domain_error("from the model");
    return Matrix::Identity(4, 4);
  };
  EXPECT_THROW(solve_nlp(nlp, {kHs071Start, {}}), std::domain_error);
  DenseNlp again = hs071();  // and leave the solver usable
  EXPECT_EQ(solve_nlp(again, {kHs071Start, {}}).status, Status::optimal);
}

TEST(Ipopt, WarmStartNeedsFewerIterations) {
  DenseNlp nlp = hs071();
  const NlpResult cold = solve_nlp(nlp, {kHs071Start, {}});
  ASSERT_TRUE(cold.converged());
  const NlpResult warm = solve_nlp(nlp, warm_start(cold));
  ASSERT_EQ(warm.status, Status::optimal);
  EXPECT_LE(warm.iterations, 3);
  EXPECT_LT(warm.iterations, cold.iterations);
  EXPECT_NEAR(warm.objective, cold.objective, 1e-5);
}

TEST(Ipopt, OptionsByNameAreChecked) {
  DenseNlp nlp = hs071();
  SolverOptions options;
  options.ipopt = {{"mu_strategy", "monotone"}, {"max_iter", "2"}, {"bound_push", "1e-3"}};
  EXPECT_EQ(solve_nlp(nlp, {kHs071Start, {}}, options).status, Status::iteration_limit);
  for (const std::map<std::string, std::string>& bad :
       std::vector<std::map<std::string, std::string>>{{{"no_such_option", "1"}},
                                                       {{"max_iter", "2.5"}},
                                                       {{"max_iter", "-3"}},
                                                       {{"mu_strategy", "magic"}},
                                                       {{"print_level", "5"}},
                                                       {{"tol", "1e-6x"}}}) {
    options.ipopt = bad;
    EXPECT_THROW(solve_nlp(nlp, {kHs071Start, {}}, options), InputError) << bad.begin()->first;
  }
  options.ipopt.clear();
  options.linear_solver = "ma57";
  EXPECT_THROW(solve_nlp(nlp, {kHs071Start, {}}, options), InputError);
}

TEST(Ipopt, EnvironmentAddsOptions) {
  DenseNlp nlp = hs071();
  ASSERT_EQ(setenv("JACULUS_IPOPT_OPTIONS", " max_iter 2 ; mu_strategy monotone;", 1), 0);
  EXPECT_EQ(solve_nlp(nlp, {kHs071Start, {}}).status, Status::iteration_limit);
  ASSERT_EQ(setenv("JACULUS_IPOPT_OPTIONS", "max_iter", 1), 0);
  EXPECT_THROW(solve_nlp(nlp, {kHs071Start, {}}), InputError);
  unsetenv("JACULUS_IPOPT_OPTIONS");
}

TEST(Ipopt, PrintsNothing) {
  ::testing::internal::CaptureStdout();
  DenseNlp nlp = hs071();
  solve_nlp(nlp, {kHs071Start, {}});
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
}

}  // namespace
}  // namespace jaculus::solver
