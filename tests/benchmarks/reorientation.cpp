// Simulations a second over the whole of Fig. 3, and the error of the effectiveness against a tight
// tolerance.

#include "jaculus/studies/reorientation.h"

#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

namespace jaculus {
namespace {

// Three lengths, 60 inertias, gears 1 to 50, with and without drag.
const std::vector<studies::ReorientationCase>& fig3_cases() {
  static const std::vector<studies::ReorientationCase> cases = [] {
    std::vector<studies::ReorientationCase> list;
    for (double length : {0.5, 0.75, 1.0}) {
      for (int k = 0; k < 60; ++k) {
        for (int gear = 1; gear <= 50; ++gear) {
          for (model::DragKind drag : {model::DragKind::rotation, model::DragKind::none}) {
            studies::ReorientationCase c = studies::paper_case();
            const double share = 0.01 + 0.01 * k;
            c.tail_inertia = c.body_inertia * share / (1.0 - share);
            c.drag.kind = drag;
            c.drag.start = 0.0;
            c.drag.end = length;
            c.motor.gear = gear;
            list.push_back(c);
          }
        }
      }
    }
    return list;
  }();
  return cases;
}

void Fig3(benchmark::State& state) {
  const double tolerance = std::pow(10.0, -static_cast<double>(state.range(0)));
  const std::vector<studies::ReorientationCase>& cases = fig3_cases();
  std::vector<double> found(cases.size());
  for (auto _ : state) {
    for (std::size_t i = 0; i < cases.size(); ++i) {
      found[i] = studies::simulate_reorientation(cases[i], tolerance).effectiveness;
    }
    benchmark::DoNotOptimize(found.data());
  }
  double worst = 0.0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    worst = std::max(
        worst, std::abs(found[i] - studies::simulate_reorientation(cases[i], 1e-10).effectiveness));
  }
  state.counters["simulations_per_second"] = benchmark::Counter(
      static_cast<double>(cases.size()) * static_cast<double>(state.iterations()),
      benchmark::Counter::kIsRate);
  state.counters["worst_effectiveness_error"] = worst;
}
BENCHMARK(Fig3)
    ->ArgName("minus_log10_tolerance")
    ->Arg(3)
    ->Arg(4)
    ->Arg(5)
    ->Arg(7)
    ->Unit(benchmark::kMillisecond);

void StiffestCase(benchmark::State& state) {
  studies::ReorientationCase c = studies::paper_case();
  c.tail_inertia = 0.0023;
  c.drag.start = 0.0;
  c.motor.gear = 50.0;
  for (auto _ : state) benchmark::DoNotOptimize(studies::simulate_reorientation(c));
}
BENCHMARK(StiffestCase);

}  // namespace
}  // namespace jaculus
