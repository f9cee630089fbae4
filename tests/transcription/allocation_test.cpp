// Nothing allocates inside a callback once it has run once. Eigen takes its memory from malloc, so
// malloc itself is counted; the test needs a C library whose malloc can be replaced by one that
// calls it (glibc), and no sanitizer that replaces it as well.

#include <gtest/gtest.h>

#include <cstddef>

#include "transcription/example_problems.h"

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#define JACULUS_COUNTS_ALLOCATIONS 1
#else
#define JACULUS_COUNTS_ALLOCATIONS 0
#endif

namespace {
thread_local long allocations = 0;
}

#if JACULUS_COUNTS_ALLOCATIONS
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  ++allocations;
  return __libc_realloc(old, size);
}
}
#endif

namespace jaculus::transcription {
namespace {

/// All callbacks at x; the number of allocations that each made, in the order of the solver's
/// calls.
std::vector<long> count_callbacks(NonlinearProgram& program, const Vector& x,
                                  const Vector& lambda) {
  double objective = 0.0;
  Vector gradient(program.variables()), rows(program.rows()),
      jacobian(program.jacobian_sparsity().size()), hessian(program.hessian_sparsity().size());
  std::vector<long> counts(5, 0);
  const auto counted = [&](std::size_t k, auto&& call) {
    const long before = allocations;
    const bool defined = call();
    counts[k] = allocations - before;
    EXPECT_TRUE(defined);
  };
  counted(0, [&] { return program.objective(x, objective); });
  counted(1, [&] { return program.constraints(x, rows); });
  counted(2, [&] { return program.gradient(x, gradient); });
  counted(3, [&] { return program.jacobian(x, jacobian); });
  counted(4, [&] { return program.hessian(x, 0.7, lambda, hessian); });
  return counts;
}

class Allocation : public testing::TestWithParam<const char*> {};

TEST_P(Allocation, NoneInACallbackThatHasRunOnce) {
  if (!JACULUS_COUNTS_ALLOCATIONS) GTEST_SKIP() << "this build's malloc can't be counted";
  const long before = allocations;
  NonlinearProgram program = test::make_program(read_problem(test::problem_file(GetParam())));
  ASSERT_GT(allocations, before) << "the counter does not count";
  const Vector lambda = Vector::LinSpaced(program.rows(), -1.0, 1.0);
  Vector x = initial_guess(program, program.problem().guess, 1);
  count_callbacks(program, x, lambda);
  x += 1e-4 * program.variable_scale();
  x = x.cwiseMax(program.variable_lower()).cwiseMin(program.variable_upper());
  EXPECT_EQ(count_callbacks(program, x, lambda), std::vector<long>(5, 0));
}

// Point drag, distributed drag, impacts, a centre of mass, swing clearance, an end at rest.
INSTANTIATE_TEST_SUITE_P(Problems, Allocation,
                         testing::Values("leap_tail", "leap_tail_table1", "hop", "bound_step",
                                         "pendulum_swing_up", "double_integrator"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace jaculus::transcription
