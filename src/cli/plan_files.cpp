#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <memory>

#include "cli/plan.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::cli {

void write_solved(const std::filesystem::path& folder, const SolvedProblem& solved) {
  if (solved.trajectory) write_csv(to_table(*solved.trajectory), folder / "plan.csv");
  if (!solved.history.empty()) write_csv(iteration_table(solved.history), folder / "iterations.csv");
  if (!solved.solution.is_null()) write_file(folder / "solution.json", solved.solution.dump(1) + "\n");
  if (!solved.timing.is_null()) write_file(folder / "timing.json", solved.timing.dump(1) + "\n");
  write_file(folder / "summary.json", to_json(solved.summary).dump(1) + "\n");
}

PlanRecord plan_record(const Loaded& loaded, const Summary& summary, const std::filesystem::path& folder) {
  PlanRecord record{
      summary, loaded.robot.planar, loaded.problem.friction.value_or(loaded.robot.planar.friction), {}, {}};
  const auto read = [&folder](const char* name) {
    const std::filesystem::path file = folder / name;
    return std::filesystem::exists(file) ? read_csv(file) : Table();
  };
  record.plan = read("plan.csv");
  record.history = read("iterations.csv");
  return record;
}

Progress progress_line(const Common& common, const std::string& name) {
  if (!shows_progress(common)) return {};
  const auto start = std::chrono::steady_clock::now();
  const auto last = std::make_shared<std::chrono::steady_clock::time_point>();
  return [name, start, last](const IterationInfo& info) {
    constexpr std::chrono::milliseconds kPause(50);  // a terminal can't show more
    const auto now = std::chrono::steady_clock::now();
    if (info.iteration > 0 && now - *last < kPause) return;
    *last = now;
    fmt::print(stderr, "\r\x1b[K{}: iteration {}, objective {:.6g}, infeasibility {:.1e}{}, {:.1f} s", name,
               info.iteration, info.objective, info.infeasibility, info.restoration ? " (restoring)" : "",
               std::chrono::duration<double>(now - start).count());
    std::fflush(stderr);
  };
}

ComparisonRow comparison_row(const Loaded& loaded, const Summary& summary) {
  return {summary, tail_kind(loaded.problem, loaded.robot.planar), conditions(loaded.problem)};
}

}  // namespace jaculus::cli
