// What is said about a solve that failed, and about the limits of one that did not.

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "jaculus/solver/elastic.h"
#include "jaculus/solver/sensitivities.h"
#include "jaculus/solver/violations.h"
#include "solver/small_nlps.h"

namespace jaculus::solver {
namespace {

using testing::DenseNlp;
using testing::hs071;
using testing::kHs071Start;
using testing::projection;

TEST(Violations, RankedByScaledAmountWithNamesAndUnits) {
  DenseNlp nlp = hs071();
  nlp.g_scale << 25.0, 1.0;
  nlp.x_scale[2] = 0.1;
  nlp.x_unit[2] = "rad";
  Vector x(4);
  x << 1, 1, 5.5, 1;  // product 5.5 of 25, squares 33.25 of 40, x2 over its 5
  const auto found = ranked_violations(nlp, x, 10);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->size(), 3u);
  EXPECT_EQ((*found)[0].name, "row 1");
  EXPECT_NEAR((*found)[0].amount, 6.75, 1e-12);
  EXPECT_EQ((*found)[1].name, "x2");
  EXPECT_EQ((*found)[1].unit, "rad");
  EXPECT_FALSE((*found)[1].is_row);
  EXPECT_NEAR((*found)[1].amount, 0.5, 1e-12);
  EXPECT_NEAR((*found)[1].scaled, 5.0, 1e-12);
  EXPECT_EQ((*found)[2].name, "row 0");
  EXPECT_NEAR((*found)[2].amount, 19.5, 1e-12);
  EXPECT_NEAR((*found)[2].scaled, 0.78, 1e-12);
  EXPECT_EQ((*found)[2].value, 5.5);
  EXPECT_EQ((*found)[2].lower, 25.0);
  EXPECT_EQ(ranked_violations(nlp, x, 1)->size(), 1u);
  const auto worst = worst_violation(nlp, x);
  ASSERT_TRUE(worst);
  EXPECT_NEAR(worst->absolute, 19.5, 1e-12);
  EXPECT_NEAR(worst->scaled, 6.75, 1e-12);
}

TEST(Violations, NoneWhereTheConstraintsAreUndefined) {
  DenseNlp nlp = hs071();
  nlp.g = [](const Vector&, Vector&) { return false; };
  EXPECT_FALSE(ranked_violations(nlp, kHs071Start, 3));
  EXPECT_FALSE(worst_violation(nlp, kHs071Start));
}

TEST(Elastic, DerivativesAgreeWithDifferences) {
  DenseNlp nlp = hs071();
  nlp.g_scale << 3.0, 0.5;
  ElasticNlp elastic(nlp, kHs071Start, {}, 0.3);
  ASSERT_EQ(elastic.variables(), 4 + 1 + 2);  // row 0 has a lower bound only
  Vector x(7);
  x << 1.5, 2.5, 3.5, 1.2, 0.7, 0.4, 0.9;
  const Vector lambda = Eigen::Vector2d(0.8, -1.7);
  const double sigma = 1.3, h = 1e-5;
  const auto lagrange_gradient = [&](const Vector& at) {
    Vector gradient = Vector::Constant(7, kNaN);
    Vector values = Vector::Constant(elastic.jacobian_sparsity().size(), kNaN);
    EXPECT_TRUE(elastic.gradient(at, gradient));
    EXPECT_TRUE(elastic.jacobian(at, values));
    Matrix jacobian = Matrix::Zero(2, 7);
    for (int k = 0; k < values.size(); ++k) {
      jacobian(elastic.jacobian_sparsity().rows[k], elastic.jacobian_sparsity().columns[k]) +=
          values[k];
    }
    return std::pair<Vector, Matrix>(gradient, jacobian);
  };
  Matrix hessian = Matrix::Zero(7, 7);
  Vector values = Vector::Constant(elastic.hessian_sparsity().size(), kNaN);
  ASSERT_TRUE(elastic.hessian(x, sigma, lambda, values));
  for (int k = 0; k < values.size(); ++k) {
    hessian(elastic.hessian_sparsity().rows[k], elastic.hessian_sparsity().columns[k]) += values[k];
  }
  const auto [gradient, jacobian] = lagrange_gradient(x);
  for (int j = 0; j < 7; ++j) {
    Vector ahead = x, behind = x, g_ahead(2), g_behind(2);
    ahead[j] += h;
    behind[j] -= h;
    double f_ahead = 0, f_behind = 0;
    ASSERT_TRUE(elastic.objective(ahead, f_ahead) && elastic.objective(behind, f_behind));
    ASSERT_TRUE(elastic.constraints(ahead, g_ahead) && elastic.constraints(behind, g_behind));
    EXPECT_NEAR(gradient[j], (f_ahead - f_behind) / (2 * h), 1e-7);
    EXPECT_LT((jacobian.col(j) - (g_ahead - g_behind) / (2 * h)).cwiseAbs().maxCoeff(), 1e-6);
    const auto [df_ahead, dg_ahead] = lagrange_gradient(ahead);
    const auto [df_behind, dg_behind] = lagrange_gradient(behind);
    const Vector column =
        (sigma * (df_ahead - df_behind) + (dg_ahead - dg_behind).transpose() * lambda) / (2 * h);
    for (int i = j; i < 7; ++i) EXPECT_NEAR(hessian(i, j), column[i], 1e-6) << i << "," << j;
  }
}

TEST(Elastic, NamesTheRowsThatCannotHoldTogether) {
  // x0 + x1 <= 1 and x0 - x1 = 0 hold with x0 >= 2 never; x2's rows have nothing to do with it.
  Matrix a(4, 3);
  a << 1, 1, 0, 1, -1, 0, 0, 0, 1, 0, 0, 2;
  DenseNlp nlp = projection(Vector::Zero(3), a);
  nlp.g_upper << 1.0, 0.0, 5.0, 6.0;
  nlp.g_lower << -kInfinity, 0.0, 1.0, -kInfinity;
  nlp.x_lower[0] = 2.0;
  EXPECT_EQ(solve_nlp(nlp, {Vector::Zero(3)}).status, Status::infeasible);
  // Cheapest: x = (2, -1), the equality off by 3, or (2, 2), the sum over by 3: weights decide.
  nlp.g_scale << 100.0, 1.0, 1.0, 1.0;
  Conflict conflict = find_conflict(nlp, Vector::Zero(3));
  ASSERT_EQ(conflict.status, Status::optimal);
  EXPECT_FALSE(conflict.feasible);
  ASSERT_EQ(conflict.relaxed.size(), 1u);
  EXPECT_EQ(conflict.relaxed[0].name, "row 0");
  EXPECT_EQ(conflict.relaxed[0].unit, "V");
  EXPECT_NEAR(conflict.relaxed[0].amount, 3.0, 1e-4);
  EXPECT_NEAR(conflict.x[1], 2.0, 1e-4);
  ASSERT_EQ(conflict.against.size(), 2u);  // the lower bound of x0 and the equality, not x2's rows
  for (const LimitSensitivity& limit : conflict.against)
    EXPECT_TRUE(limit.name == "x0" || limit.name == "row 1");

  nlp.g_scale << 1.0, 100.0, 1.0, 1.0;
  conflict = find_conflict(nlp, Vector::Zero(3));
  ASSERT_EQ(conflict.relaxed.size(), 1u);
  EXPECT_EQ(conflict.relaxed[0].name, "row 1");
  EXPECT_NEAR(conflict.relaxed[0].amount, 3.0, 1e-4);
}

TEST(Elastic, OnlyChosenRowsGiveWay) {
  Matrix a(2, 1);
  a << 1, 1;
  DenseNlp nlp = projection(Vector::Zero(1), a);
  nlp.g_lower << 3.0, -kInfinity;
  nlp.g_upper << kInfinity, 1.0;
  ElasticOptions options;
  options.may_relax = [](int row) { return row == 0; };
  const Conflict conflict = find_conflict(nlp, Vector::Zero(1), options);
  ASSERT_EQ(conflict.relaxed.size(), 1u);
  EXPECT_EQ(conflict.relaxed[0].row, 0);
  EXPECT_NEAR(conflict.relaxed[0].amount, -2.0, 1e-5);  // two short of its lower bound
  ASSERT_EQ(conflict.against.size(), 1u);
  EXPECT_EQ(conflict.against[0].name, "row 1");
  EXPECT_EQ(conflict.against[0].side, Side::upper);
  EXPECT_NEAR(conflict.against[0].rate, -1.0, 1e-4);  // raising the limit by one saves one
}

TEST(Elastic, AFeasibleProblemHasNoConflict) {
  DenseNlp nlp = hs071();
  const Conflict conflict = find_conflict(nlp, Vector::Constant(4, 1.0));
  EXPECT_TRUE(conflict.feasible);
  EXPECT_TRUE(conflict.relaxed.empty());
  EXPECT_TRUE(conflict.against.empty());
  EXPECT_LT(worst_violation(nlp, conflict.x)->absolute, 1e-4);
}

TEST(Elastic, NonlinearConflict) {
  DenseNlp nlp = hs071();
  nlp.g_lower[1] = nlp.g_upper[1] = 120.0;  // four squares of at most 25: twenty short
  const Conflict conflict = find_conflict(nlp, kHs071Start);
  ASSERT_TRUE(conflict.status == Status::optimal) << to_string(conflict.status);
  ASSERT_EQ(conflict.relaxed.size(), 1u);
  EXPECT_EQ(conflict.relaxed[0].name, "row 1");
  EXPECT_NEAR(conflict.relaxed[0].amount, -20.0, 1e-3);
  ASSERT_EQ(conflict.against.size(), 4u);  // the upper bounds of all four variables
  for (const LimitSensitivity& limit : conflict.against) {
    EXPECT_FALSE(limit.is_row);
    EXPECT_EQ(limit.side, Side::upper);
    EXPECT_NEAR(limit.rate, -10.0, 1e-2);  // d(x^2)/dx at 5
  }
}

/// The objective with one bound moved, solved anew.
double resolve(DenseNlp nlp, const std::function<void(DenseNlp&)>& change) {
  change(nlp);
  const NlpResult result = solve_nlp(nlp, {kHs071Start}, {.tolerance = 1e-10});
  EXPECT_TRUE(result.converged());
  return result.objective;
}

TEST(Sensitivities, AgreeWithSolvingAgain) {
  DenseNlp nlp = hs071();
  nlp.x_scale << 0.5, 2.0, 3.0, 4.0;
  nlp.g_scale << 25.0, 4.0;
  nlp.f_scale = 10.0;
  nlp.x_lower[2] = nlp.x_upper[2] = 3.5;
  const NlpResult result = solve_nlp(nlp, {kHs071Start}, {.tolerance = 1e-10});
  ASSERT_TRUE(result.converged());
  const auto sensitivities = limit_sensitivities(nlp, result, {.equalities = true});
  const double h = 1e-4;
  int checked = 0;
  for (const LimitSensitivity& limit : sensitivities) {
    const auto moved = [&](double by) {
      return resolve(nlp, [&](DenseNlp& n) {
        Vector& lower = limit.is_row ? n.g_lower : n.x_lower;
        Vector& upper = limit.is_row ? n.g_upper : n.x_upper;
        if (limit.side != Side::upper) lower[limit.index] += by;
        if (limit.side != Side::lower) upper[limit.index] += by;
      });
    };
    EXPECT_NEAR(limit.rate, (moved(h) - moved(-h)) / (2 * h), 2e-3 * (1 + std::abs(limit.rate)))
        << limit.name;
    ++checked;
  }
  EXPECT_EQ(checked, 4);  // both rows, x0's lower bound, x2 where it is fixed
  EXPECT_EQ(limit_sensitivities(nlp, result).size(), 2u);
  const auto maximised = limit_sensitivities(nlp, result, {.maximise = true, .equalities = true});
  ASSERT_EQ(maximised.size(), sensitivities.size());
  for (std::size_t i = 0; i < sensitivities.size(); ++i) {
    EXPECT_EQ(maximised[i].rate, -sensitivities[i].rate);
    EXPECT_EQ(maximised[i].name, sensitivities[i].name);
    EXPECT_LE(std::abs(sensitivities[i].scaled), std::abs(sensitivities[i > 0 ? i - 1 : 0].scaled));
  }
}

TEST(Sensitivities, RangeRowsKnowTheirSide) {
  for (const double target : {9.0, -9.0}) {
    DenseNlp nlp = projection(Vector::Constant(1, target), Matrix::Constant(1, 1, 2.0));
    nlp.g_lower << -4.0;
    nlp.g_upper << 6.0;
    const auto sensitivities =
        limit_sensitivities(nlp, solve_nlp(nlp, {Vector::Zero(1)}, {.tolerance = 1e-10}));
    ASSERT_EQ(sensitivities.size(), 1u);
    EXPECT_EQ(sensitivities[0].side, target > 0 ? Side::upper : Side::lower);
    EXPECT_EQ(sensitivities[0].limit, target > 0 ? 6.0 : -4.0);
    // f = 1/2 (limit/2 - target)^2, so df/dlimit = (limit/2 - target)/2.
    EXPECT_NEAR(sensitivities[0].rate, target > 0 ? -3.0 : 3.5, 1e-5);
  }
}

TEST(Sensitivities, NoneWithoutASolution) {
  DenseNlp nlp = hs071();
  const NlpResult result = solve_nlp(nlp, {kHs071Start}, {.max_iterations = 1});
  EXPECT_THROW(static_cast<void>(limit_sensitivities(nlp, result)), std::logic_error);
}

}  // namespace
}  // namespace jaculus::solver
