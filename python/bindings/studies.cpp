// Studies.

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "jaculus/report/study_report.h"
#include "jaculus/studies/study.h"

namespace jaculus::python {
namespace {

namespace fs = std::filesystem;
using Progress = std::function<void(int, int)>;

struct Study {
  studies::StudyResult result;
  bool interrupted = false;
};

Study run(const yaml::Node& node, const fs::path& folder, int jobs, bool resume,
          const Progress& progress) {
  studies::StudyOptions options;
  options.jobs = jobs;
  options.resume = resume;
  if (progress) {
    options.progress = [&](const TaskProgress& p) {
      call_user([&] { progress(p.done, p.total); });
    };
  }

  if (!folder.empty()) fs::create_directories(folder);
  return compute([&] {
    studies::StudyResult result = studies::run_study(node, folder, options);
    if (!folder.empty() && result.complete)
      report::write_report(report::study_report({result}), folder);
    return Study{std::move(result), interrupt_requested()};
  });
}

}  // namespace

void bind_studies(nb::module_& module) {
  nb::class_<Study>(module, "Study")
      .def_prop_ro("columns", [](const Study& s) { return s.result.columns; })
      .def_prop_ro("complete", [](const Study& s) { return s.result.complete; })
      .def_ro("interrupted", &Study::interrupted)
      .def_prop_ro("json", [](const Study& s) { return studies::study_json(s.result); })
      .def_prop_ro("summary", [](const Study& s) { return report::study_text(s.result); })
      .def("report_html",
           [](const Study& s) { return report::report_html(report::study_report({s.result})); });
  module.def("study", &run, nb::arg("node"), nb::arg("folder"), nb::arg("jobs"), nb::arg("resume"),
             nb::arg("progress") = nb::none());
}

}  // namespace jaculus::python
