#include "jaculus/solver/plan_files.h"

namespace jaculus::solver {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

trajectory::Table iteration_table(const std::vector<IterationInfo>& history) {
  trajectory::Table table;
  table.columns = {{"iteration", ""},          {"objective", ""}, {"infeasibility", ""},
                   {"dual_infeasibility", ""}, {"barrier", ""},   {"restoration", ""}};
  table.values.resize(std::ssize(history), std::ssize(table.columns));

  for (int i = 0; i < count_of(history); ++i) {
    const IterationInfo& h = history[i];
    table.values.row(i) << h.iteration, h.objective, h.infeasibility, h.dual_infeasibility,
        h.barrier, h.restoration ? 1.0 : 0.0;
  }

  return table;
}

Json timing_json(const SolvedPlan& solved) {
  return {{"wall_seconds",
           {{"total", solved.wall_seconds.total},
            {"functions", solved.wall_seconds.functions},
            {"linear_solver", solved.wall_seconds.linear_solver}}},
          {"iterations", solved.summary.iterations}};
}

void write_json(const fs::path& file, const Json& json) {
  trajectory::write_file(file, json.dump(1) + "\n");
}

}  // namespace

SolvedPlan solved_plan(const Plan& plan, const transcription::Problem& problem) {
  return {summarise(plan, problem), plan.trajectory, solution_json(plan), plan.result.history,
          plan.result.wall_seconds};
}

void write_plan(const SolvedPlan& solved, const fs::path& folder) {
  const PlanTables tables = plan_tables(solved);
  if (!tables.plan.columns.empty()) trajectory::write_csv(tables.plan, folder / "plan.csv");
  if (!tables.history.columns.empty())
    trajectory::write_csv(tables.history, folder / "iterations.csv");
  if (!solved.solution.is_null()) write_json(folder / "solution.json", solved.solution);

  write_json(folder / "timing.json", timing_json(solved));

  solver::Summary summary = solved.summary;
  if (!summary.robot_folder.empty())
    summary.robot_folder =
        fs::relative(fs::absolute(summary.robot_folder), fs::absolute(folder)).generic_string();
  write_json(folder / "summary.json", to_json(summary));
}

PlanTables plan_tables(const SolvedPlan& solved) {
  PlanTables tables;
  if (solved.trajectory) tables.plan = trajectory::to_table(*solved.trajectory);
  if (!solved.history.empty()) tables.history = iteration_table(solved.history);
  return tables;
}

PlanTables read_plan_tables(const fs::path& folder) {
  const auto read = [&folder](const char* name) {
    const fs::path file = folder / name;
    return fs::exists(file) ? trajectory::read_csv(file) : trajectory::Table();
  };
  return {read("plan.csv"), read("iterations.csv")};
}

}  // namespace jaculus::solver
