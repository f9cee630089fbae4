#include "cli/plan.h"

#include <fmt/format.h>

#include <cctype>
#include <chrono>
#include <cstdio>
#include <memory>

#include "cli/reporting.h"
#include "jaculus/model/describe.h"
#include "jaculus/solver/plan.h"

namespace jaculus::cli {
namespace {

using Progress = std::function<void(const solver::IterationInfo&)>;

Progress progress_line(const Common& common, const std::string& name) {
  if (!shows_progress(common)) return {};
  const auto start = std::chrono::steady_clock::now();
  const auto last = std::make_shared<std::chrono::steady_clock::time_point>();

  return [name, start, last](const solver::IterationInfo& info) {
    constexpr std::chrono::milliseconds kPause(50);  // a terminal can't show more
    const auto now = std::chrono::steady_clock::now();
    if (info.iteration > 0 && now - *last < kPause) return;
    *last = now;
    fmt::print(
        stderr, "\r\x1b[K{}: iteration {}, objective {:.6g}, infeasibility {:.1e}{}, {:.1f} s",
        name, info.iteration, info.objective, info.infeasibility,
        info.restoration ? " (restoring)" : "", std::chrono::duration<double>(now - start).count());
    std::fflush(stderr);
  };
}

}  // namespace

std::string stage_of(const transcription::Problem& problem) {
  std::string name = problem.name;  // of any letters; a folder is named by it
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '-') c = '_';
  return "starts_" + name;
}

solver::SolvedPlan solve_loaded(const Loaded& loaded, const Common& common,
                                const std::shared_ptr<const Executor>& executor) {
  solver::PlanOptions options;
  options.jobs = common.jobs;
  options.progress = progress_line(common, loaded.problem.name);
  options.executor = executor;
  options.stage = stage_of(loaded.problem);
  options.notice = notices(common);
  options.starts_progress = progress_bar(common, loaded.problem.name + ", starts");

  solver::Plan plan = solver::make_plan(loaded.problem, loaded.robot.planar, options);
  for (const std::string& left_out : model::friction_left_out(loaded.robot))
    plan.notes.push_back(left_out);
  return solver::solved_plan(plan, loaded.problem);
}

}  // namespace jaculus::cli
