#include "jaculus/solver/multi_start.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <stdexcept>

#include "jaculus/solver/ipopt.h"
#include "solver/plan_solve.h"
#include "solver/small_nlps.h"

namespace jaculus::solver {
namespace {

using testing::DenseNlp;
using testing::hs071;

void expect_same(const NlpResult& a, const NlpResult& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.message, b.message);
  EXPECT_EQ(a.last_iterate(), b.last_iterate());
  EXPECT_EQ(a.row_multipliers, b.row_multipliers);
  EXPECT_EQ(a.lower_multipliers, b.lower_multipliers);
  EXPECT_EQ(a.upper_multipliers, b.upper_multipliers);
  EXPECT_EQ(a.objective, b.objective);
  EXPECT_EQ(a.max_violation, b.max_violation);
  EXPECT_EQ(a.max_scaled_violation, b.max_scaled_violation);
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_EQ(a.evaluations.objective, b.evaluations.objective);
  EXPECT_EQ(a.evaluations.gradient, b.evaluations.gradient);
  EXPECT_EQ(a.evaluations.constraints, b.evaluations.constraints);
  EXPECT_EQ(a.evaluations.jacobian, b.evaluations.jacobian);
  EXPECT_EQ(a.evaluations.hessian, b.evaluations.hessian);
  ASSERT_EQ(a.history.size(), b.history.size());
  for (std::size_t i = 0; i < a.history.size(); ++i) {
    EXPECT_EQ(a.history[i].iteration, b.history[i].iteration);
    EXPECT_EQ(a.history[i].objective, b.history[i].objective);
    EXPECT_EQ(a.history[i].infeasibility, b.history[i].infeasibility);
    EXPECT_EQ(a.history[i].dual_infeasibility, b.history[i].dual_infeasibility);
    EXPECT_EQ(a.history[i].barrier, b.history[i].barrier);
    EXPECT_EQ(a.history[i].restoration, b.history[i].restoration);
  }
}

TEST(Result, BytesRoundTripExactly) {
  DenseNlp nlp = hs071();
  const NlpResult result = solve_nlp(nlp, {Eigen::Vector4d(1, 5, 5, 1)});
  const NlpResult back = deserialise_result(serialise(result));
  expect_same(result, back);
  EXPECT_EQ(result.wall_seconds.total, back.wall_seconds.total);
  EXPECT_EQ(result.wall_seconds.functions, back.wall_seconds.functions);
  EXPECT_EQ(result.wall_seconds.linear_solver, back.wall_seconds.linear_solver);
  EXPECT_EQ(serialise(back), serialise(result));
}

TEST(Result, ConflictsAndNaNsSurvive) {
  NlpResult result;
  result.status = Status::contradictory_bounds;
  result.conflicts = {{"x", "m", 2.0, kNaN}};
  const NlpResult back = deserialise_result(serialise(result));
  EXPECT_EQ(back.status, Status::contradictory_bounds);
  ASSERT_EQ(back.conflicts.size(), 1u);
  EXPECT_EQ(back.conflicts[0].name, "x");
  EXPECT_EQ(back.conflicts[0].unit, "m");
  EXPECT_EQ(back.conflicts[0].lower, 2.0);
  EXPECT_TRUE(std::isnan(back.conflicts[0].upper));
  EXPECT_TRUE(std::isnan(back.objective));
}

TEST(Result, BrokenBytesAreRefused) {
  DenseNlp nlp = hs071();
  const std::string bytes = serialise(solve_nlp(nlp, {Eigen::Vector4d(1, 5, 5, 1)}));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(deserialise_result(bytes.substr(0, size)), std::runtime_error) << size;
  }
  EXPECT_THROW(deserialise_result(bytes + "x"), std::runtime_error);
}

TEST(Result, StatusNames) {
  for (int i = 0; i <= static_cast<int>(Status::failed); ++i) {
    EXPECT_EQ(status_from_string(to_string(static_cast<Status>(i))), static_cast<Status>(i));
  }
  EXPECT_THROW(status_from_string("fine"), std::invalid_argument);
}

/// f = x^4/4 - x^2/2 + x/10: a global minimum near -1.047 and a local one near 0.947.
NlpResult solve_double_well(double start) {
  DenseNlp nlp(1, 0);
  nlp.f = [](const Vector& x, double& f) {
    f = std::pow(x[0], 4) / 4 - x[0] * x[0] / 2 + x[0] / 10;
    return true;
  };
  nlp.df = [](const Vector& x) -> Vector {
    return Vector::Constant(1, std::pow(x[0], 3) - x[0] + 0.1);
  };
  nlp.h = [](const Vector& x, double s, const Vector&) -> Matrix {
    return Matrix::Constant(1, 1, s * (3 * x[0] * x[0] - 1));
  };
  return solve_nlp(nlp, {Vector::Constant(1, start)});
}

NlpResult random_start(int start, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const double u = static_cast<double>(random() >> 11) * 0x1p-53;
  return solve_double_well(start == 0 ? 1.0 : 4 * u - 2);
}

TEST(MultiStart, FindsTheGlobalMinimumTheSameWayForAnyWorkers) {
  MultiStartOptions options{.seed = 11};
  options.tasks.workers = 1;
  const MultiStart one = multi_start(12, random_start, options);
  options.tasks.workers = 3;
  const MultiStart three = multi_start(12, random_start, options);
  EXPECT_EQ(one.converged, 12);
  EXPECT_GT(one.starts[0].result.x()[0], 0.5);  // the guess leads to the local one
  EXPECT_NEAR(one.best_result().x()[0], -1.0467, 1e-3);
  EXPECT_GT(one.near_share, 0.0);
  EXPECT_LT(one.near_share, 1.0);
  EXPECT_EQ(one.best, three.best);
  EXPECT_EQ(one.near_share, three.near_share);
  for (std::size_t i = 0; i < 12; ++i) expect_same(one.starts[i].result, three.starts[i].result);
}

NlpResult made_up(Status status, double objective, double violation) {
  NlpResult result;
  result.status = status;
  result.objective = objective;
  result.max_scaled_violation = violation;
  result.set_iterate(Vector::Zero(1));
  return result;
}

TEST(MultiStart, BestIsConvergedAndTiesGoToTheEarliest) {
  const auto solve = [](int start, std::uint64_t) {
    switch (start) {
      case 0:
        return made_up(Status::iteration_limit, -50.0, 0.3);
      case 1:
        return made_up(Status::optimal, -10.02, 1e-7);
      case 2:
        return made_up(Status::acceptable, -10.05, 1e-8);
      case 3:
        return made_up(Status::optimal, -10.05 * (1 + 1e-9), 1e-6);
      case 4:
        throw std::runtime_error("no guess");
      case 5:
        return made_up(Status::optimal, -9.0, 1e-6);
      default:
        return made_up(Status::infeasible, -11.0, kNaN);
    }
  };
  const MultiStart all = multi_start(7, solve);
  EXPECT_EQ(all.best, 2);
  EXPECT_EQ(all.least_bad, 2);
  EXPECT_EQ(all.converged, 4);
  EXPECT_DOUBLE_EQ(all.converged_share, 4.0 / 7);
  EXPECT_DOUBLE_EQ(all.near_share, 3.0 / 7);
  EXPECT_EQ(all.starts[4].task, TaskState::failed);
  EXPECT_EQ(all.starts[4].error, "no guess");

  EXPECT_EQ(optima(all, 1e-7), (std::vector<int>{2, 1, 5}));
  EXPECT_EQ(optima(all, 1e-12), (std::vector<int>{3, 2, 1, 5}));
}

TEST(MultiStart, NoneConverged) {
  const MultiStart all = multi_start(
      3, [](int start, std::uint64_t) { return made_up(Status::infeasible, 0.0, 3.0 - start); });
  EXPECT_EQ(all.best, -1);
  EXPECT_EQ(all.least_bad, 2);
  EXPECT_EQ(all.near_share, 0.0);
  EXPECT_THROW(static_cast<void>(all.best_result()), std::logic_error);
}

TEST(MultiStart, ResumesFromItsJournalAndRefusesAnotherSeed) {
  std::string folder = (std::filesystem::temp_directory_path() / "jaculus_starts_XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  MultiStartOptions options{.seed = 5};
  options.tasks.journal = std::filesystem::path(folder) / "journal";
  const MultiStart first = multi_start(4, random_start, options);
  const MultiStart again = multi_start(
      4, [](int, std::uint64_t) -> NlpResult { throw std::runtime_error("must not run"); },
      options);
  EXPECT_EQ(again.converged, 4);
  for (std::size_t i = 0; i < 4; ++i) expect_same(first.starts[i].result, again.starts[i].result);
  options.seed = 6;
  EXPECT_ANY_THROW(multi_start(4, random_start, options));
  std::filesystem::remove_all(folder);
}

TEST(MultiStart, OrderOnTheFirstMeshCountsAsLongAsFinerMeshesKeepTheOptimum) {
  using detail::worth_refining;
  // maximised accelerations, so negative objectives; what was taken kept its optimum
  EXPECT_FALSE(worth_refining(-18.59, {-18.6, -18.6}));
  EXPECT_FALSE(worth_refining(-18.59, {-18.6, -18.9}));
  EXPECT_TRUE(worth_refining(-18.59, {-18.2, -18.2}));
}

TEST(MultiStart, AnOptimumThatFinerMeshesLoseIsNoMeasureOfTheOthers) {
  using detail::worth_refining;
  EXPECT_TRUE(worth_refining(-18.59, {-18.6, -6.7}));
  // worse on the first mesh than the plan that was lost there, and than what it fell to
  EXPECT_TRUE(worth_refining(-6.4, {-18.6, -6.7}));
  EXPECT_FALSE(worth_refining(-6.4, {-6.7, -6.7}));
}

}  // namespace
}  // namespace jaculus::solver
