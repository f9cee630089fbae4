// Solving and comparing.

#include <nanobind/eigen/dense.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <set>

#include "bindings.h"
#include "jaculus/core/error.h"
#include "jaculus/export/export.h"
#include "jaculus/model/describe.h"
#include "jaculus/report/compare_report.h"
#include "jaculus/report/plan_report.h"
#include "jaculus/solver/plan_files.h"
#include "jaculus/studies/comparison.h"

namespace jaculus::python {
namespace {

namespace fs = std::filesystem;
using transcription::LoadedProblem;
using Progress = std::function<void(int, double, double)>;

struct PlanResult {
  LoadedProblem loaded;
  solver::SolvedPlan solved;
  bool interrupted = false;  ///< Ctrl-C came, whatever the plan that it left

  [[nodiscard]] report::PlanRecord record() const {
    return report::plan_record(loaded.problem, loaded.robot.planar, solved.summary,
                               solver::plan_tables(solved));
  }
};

PlanResult solve(const LoadedProblem& given, std::optional<int> seed, std::optional<int> starts,
                 int jobs, const Progress& progress) {
  PlanResult result{given, {}};
  transcription::Problem& problem = result.loaded.problem;
  if (seed) problem.solver.seed = *seed;
  if (starts) problem.solver.starts = *starts;

  solver::PlanOptions options;
  options.jobs = jobs;
  if (progress) {
    options.progress = [&](const solver::IterationInfo& info) {
      call_user([&] { progress(info.iteration, info.objective, info.infeasibility); });
    };
  }

  compute([&] {
    solver::Plan plan = solver::make_plan(problem, result.loaded.robot.planar, options);
    for (const std::string& left_out : model::friction_left_out(result.loaded.robot))
      plan.notes.push_back(left_out);
    result.solved = solver::solved_plan(plan, problem);
    result.interrupted = interrupt_requested();
  });
  return result;
}

void save_plan(const PlanResult& result, const fs::path& folder) {
  fs::create_directories(folder);
  solver::write_plan(result.solved, folder);
  report::write_report(report::solve_report(result.record()), folder);
}

/// A matrix of the trajectory, empty where there is none.
template <Matrix trajectory::Trajectory::*field>
Matrix of_trajectory(const PlanResult& result) {
  return result.solved.trajectory ? Matrix((*result.solved.trajectory).*field) : Matrix();
}

template <std::vector<std::string> trajectory::Trajectory::*field>
std::vector<std::string> names_of(const PlanResult& result) {
  if (!result.solved.trajectory) return {};
  return (*result.solved.trajectory).*field;
}

std::vector<studies::ComparisonRow> rows_of(const std::vector<const PlanResult*>& plans) {
  std::vector<studies::ComparisonRow> rows;
  for (const PlanResult* plan : plans)
    rows.push_back(studies::comparison_row(plan->loaded.problem, plan->loaded.robot.planar,
                                           plan->solved.summary));
  return rows;
}

report::Report comparison_report(const std::vector<const PlanResult*>& plans) {
  std::vector<report::PlanRecord> records;
  for (const PlanResult* plan : plans) records.push_back(plan->record());
  return report::compare_report(records, rows_of(plans));
}

/// What `jaculus compare --out` writes.
void save_comparison(const std::vector<const PlanResult*>& plans, const fs::path& folder) {
  std::set<std::string> names;
  for (const PlanResult* plan : plans) {
    const std::string& name = plan->loaded.problem.name;
    if (!names.insert(name).second)
      throw InputError({.key = "name"}, "'" + name +
                                            "' names two of these plans; allowed: unique names, "
                                            "since they name folders");
  }

  for (const PlanResult* plan : plans) {
    const fs::path own = folder / plan->loaded.problem.name;
    fs::create_directories(own);
    solver::write_plan(plan->solved, own);
  }
  studies::write_comparison(rows_of(plans), folder);
  report::write_report(comparison_report(plans), folder);
}

void bind_comparison(nb::module_& module) {
  using Plans = std::vector<const PlanResult*>;
  module.def(
      "comparison_json",
      [](const Plans& plans) { return studies::comparison_json(rows_of(plans)).dump(1); },
      nb::arg("plans"), "compare.json of plans, the reference first.");
  module.def(
      "comparison_csv", [](const Plans& plans) { return studies::comparison_csv(rows_of(plans)); },
      nb::arg("plans"), "compare.csv of plans.");
  module.def(
      "comparison_text",
      [](const Plans& plans) { return report::comparison_text(rows_of(plans), false); },
      nb::arg("plans"), "What `jaculus compare` prints.");
  module.def(
      "comparison_html",
      [](const Plans& plans) { return report::report_html(comparison_report(plans)); },
      nb::arg("plans"), "report.html of a comparison.");
  module.def("save_comparison", &save_comparison, nb::arg("plans"), nb::arg("folder"),
             "Writes what `jaculus compare --out` writes.");
}

}  // namespace

void bind_plans(nb::module_& module) {
  using Motion = trajectory::Trajectory;
  nb::class_<PlanResult>(module, "Plan")
      .def_prop_ro("problem", [](const PlanResult& r) { return r.loaded; })
      .def_prop_ro(
          "summary",
          [](const PlanResult& r) { return report::summary_text(r.solved.summary, false); })
      .def_prop_ro("json",
                   [](const PlanResult& r) { return solver::to_json(r.solved.summary).dump(1); })
      .def_prop_ro("solution", [](const PlanResult& r) { return r.solved.solution.dump(1); })
      .def_prop_ro("status",
                   [](const PlanResult& r) { return solver::to_string(r.solved.summary.status); })
      .def_ro("interrupted", &PlanResult::interrupted)
      .def_prop_ro("converged", [](const PlanResult& r) { return r.solved.summary.converged(); })
      .def_prop_ro("table", [](const PlanResult& r) { return solver::plan_tables(r.solved).plan; })
      .def_prop_ro("history",
                   [](const PlanResult& r) { return solver::plan_tables(r.solved).history; })
      .def_prop_ro("time",
                   [](const PlanResult& r) {
                     return r.solved.trajectory ? r.solved.trajectory->time : Vector();
                   })
      .def_prop_ro("coordinates", &names_of<&Motion::coordinates>)
      .def_prop_ro("motors", &names_of<&Motion::motors>)
      .def_prop_ro("feet", &names_of<&Motion::feet>)
      .def_prop_ro("position", &of_trajectory<&Motion::position>)
      .def_prop_ro("velocity", &of_trajectory<&Motion::velocity>)
      .def_prop_ro("torque", &of_trajectory<&Motion::torque>)
      .def_prop_ro("force_x", &of_trajectory<&Motion::force_x>)
      .def_prop_ro("force_z", &of_trajectory<&Motion::force_z>)
      .def("save", &save_plan, nb::arg("folder"))
      .def(
          "export_json",
          [](const PlanResult& r, double rate) {
            const exporting::Source source = exporting::source(r.solved);
            return exporting::to_json(exporting::resample(source, rate, exporting::Side::joint));
          },
          nb::arg("rate"))
      .def("report_html", [](const PlanResult& r) {
        return report::report_html(report::solve_report(r.record()));
      });
  module.def("solve", &solve, nb::arg("problem"), nb::arg("seed") = nb::none(),
             nb::arg("starts") = nb::none(), nb::arg("jobs") = 1, nb::arg("progress") = nb::none());
  bind_comparison(module);
}

}  // namespace jaculus::python
