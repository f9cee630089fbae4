// One evaluation of each callback, whole solves of the four leaps with their split, and the cost of
// an iteration by grid size.

#include <benchmark/benchmark.h>

#include "jaculus/solver/ipopt.h"
#include "transcription/example_problems.h"

namespace jaculus {
namespace {

enum Callback { kConstraints, kJacobian, kHessian };

void callback(benchmark::State& state, Callback which) {
  transcription::NonlinearProgram program =
      test::make_program(transcription::read_problem(test::problem_file("leap_tail_as_published")));
  const Vector start = transcription::initial_guess(program, program.problem().guess, 1);
  const Vector lambda = Vector::Ones(program.rows());
  Vector g(program.rows()), J(program.jacobian_sparsity().size()),
      H(program.hessian_sparsity().size());
  Vector x = start;
  for (auto _ : state) {
    // a new point each time, or the cache would answer
    x[0] = x[0] == start[0] ? start[0] + 1e-9 : start[0];
    if (which == kConstraints) program.constraints(x, g);
    if (which == kJacobian) program.jacobian(x, J);
    if (which == kHessian) program.hessian(x, 1.0, lambda, H);
  }
}
BENCHMARK_CAPTURE(callback, constraints, kConstraints)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(callback, jacobian_and_constraints, kJacobian)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(callback, hessian_and_all_before, kHessian)->Unit(benchmark::kMicrosecond);

void report(benchmark::State& state, const solver::NlpResult& result) {
  state.counters["iterations"] = result.iterations;
  state.counters["functions_ms"] = 1e3 * result.wall_seconds.functions;
  state.counters["linear_ms"] = 1e3 * result.wall_seconds.linear_solver;
  state.counters["objective"] = result.objective;
}

void leap(benchmark::State& state, const char* name) {
  transcription::NonlinearProgram program =
      test::make_program(transcription::read_problem(test::problem_file(name)));
  const Vector start = transcription::initial_guess(program, program.problem().guess, 1);
  solver::NlpResult result;
  for (auto _ : state) result = solver::solve_nlp(program, {start, {}});
  report(state, result);
}
BENCHMARK_CAPTURE(leap, tailless, "leap_tailless_as_published")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(leap, inactive, "leap_inactive")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(leap, inertial, "leap_inertial")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(leap, tail, "leap_tail_as_published")->Unit(benchmark::kMillisecond);

/// Ten iterations on a grid: the time should grow in proportion to the number of intervals.
void iterations_by_grid(benchmark::State& state) {
  const int intervals = static_cast<int>(state.range(0));
  transcription::NonlinearProgram program = test::make_program(
      test::on_grid(transcription::read_problem(test::problem_file("leap_tail_as_published")),
                    {intervals, intervals}));
  const Vector start = transcription::initial_guess(program, program.problem().guess, 1);
  solver::SolverOptions options;
  options.max_iterations = 10;
  solver::NlpResult result;
  for (auto _ : state) result = solver::solve_nlp(program, {start, {}}, options);
  report(state, result);
  state.SetComplexityN(intervals);
}
BENCHMARK(iterations_by_grid)
    ->RangeMultiplier(2)
    ->Range(10, 160)
    ->Unit(benchmark::kMillisecond)
    ->Complexity();

}  // namespace
}  // namespace jaculus
