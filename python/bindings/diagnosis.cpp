// Diagnosis of datasets.

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>
#include <tbb/global_control.h>

#include "bindings.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/diagnosis/diagnosis_json.h"
#include "jaculus/effects/trials.h"
#include "jaculus/report/diagnosis_report.h"

namespace jaculus::python {
namespace {

namespace fs = std::filesystem;
using diagnosis::Diagnosis;
using trajectory::Dataset;

struct DiagnosisResult {
  Diagnosis diagnosis;
  std::string title;
};

DiagnosisResult run(const std::vector<const Dataset*>& given,
                    const std::optional<yaml::Node>& settings,
                    const std::vector<std::string>& tolerances, const std::string& horizon,
                    const std::vector<std::string>& effect_files,
                    const std::vector<effects::UserEffect>& own, int jobs,
                    const StageProgress& progress) {
  std::vector<Dataset> datasets;
  for (const Dataset* dataset : given) datasets.push_back(*dataset);
  if (datasets.empty()) throw InputError("diagnose: no dataset given; allowed: one or more");

  diagnosis::DiagnoseOptions options;
  if (settings) options.settings = diagnosis::read_settings(*settings);
  options.accuracy.tolerances = tolerances;
  if (!horizon.empty()) options.accuracy.horizon = diagnosis::read_horizon(horizon, "horizon");
  options.progress = progress;  // what it throws ends the diagnosis

  options.catalogue = std::make_shared<const effects::Catalogue>(
      effects::catalogue_for(effect_files, datasets, own));

  const std::string title = fs::weakly_canonical(datasets.front().folder).filename().string();
  const tbb::global_control workers(tbb::global_control::max_allowed_parallelism, jobs);
  return {compute_whole([&] { return diagnosis::diagnose(datasets, options); }), title};
}

report::Report report_of(const DiagnosisResult& result) {
  return report::diagnosis_report(result.diagnosis, result.title);
}

void save(const DiagnosisResult& result, const fs::path& folder) {
  diagnosis::write_diagnosis(result.diagnosis, folder);
  report::write_report(report_of(result), folder);
}

}  // namespace

void bind_diagnosis(nb::module_& module) {
  using Result = DiagnosisResult;
  nb::class_<Result>(module, "Diagnosis")
      .def_prop_ro("json", [](const Result& r) { return diagnosis::diagnosis_json(r.diagnosis); })
      .def_prop_ro("summary",
                   [](const Result& r) { return diagnosis::diagnosis_text(r.diagnosis); })
      .def_prop_ro("augmented",
                   [](const Result& r) { return diagnosis::augmented_yaml(r.diagnosis); })
      .def("save", &save, nb::arg("folder"))
      .def("report_html", [](const Result& r) { return report::report_html(report_of(r)); });
  module.def("diagnose", &run, nb::arg("datasets"), nb::arg("settings").none(),
             nb::arg("tolerances"), nb::arg("horizon"), nb::arg("effect_files"), nb::arg("own"),
             nb::arg("jobs"), nb::arg("progress") = nb::none());
}

}  // namespace jaculus::python
