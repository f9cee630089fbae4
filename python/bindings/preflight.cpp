// What a planned experiment could tell.

#include "jaculus/diagnosis/preflight.h"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>
#include <tbb/global_control.h>

#include <memory>
#include <optional>

#include "bindings.h"
#include "jaculus/effects/trials.h"
#include "jaculus/report/preflight_report.h"

namespace jaculus::python {
namespace {

namespace fs = std::filesystem;
using diagnosis::Preflight;
using simulation::Experiment;

struct PreflightChoice {
  std::optional<int> trials, seed;
  double size = 1.0;
  bool alternatives = true;
};

Preflight run(Experiment experiment, const PreflightChoice& choice,
              const std::optional<yaml::Node>& settings,
              const std::vector<std::string>& effect_files,
              const std::vector<effects::UserEffect>& own, int jobs,
              const StageProgress& progress) {
  if (choice.trials) experiment.trials = *choice.trials;
  if (choice.seed) experiment.seed = *choice.seed;

  diagnosis::PreflightOptions options;
  if (settings) options.diagnosis.settings = diagnosis::read_settings(*settings);
  options.diagnosis.catalogue = std::make_shared<const effects::Catalogue>(
      effects::catalogue_for(effect_files, {experiment.setup}, own));
  options.diagnosis.progress = progress;  // what it throws ends the preflight
  options.size = choice.size;
  options.alternatives = choice.alternatives;

  const tbb::global_control workers(tbb::global_control::max_allowed_parallelism, jobs);
  return compute_whole([&] { return diagnosis::preflight(experiment, options); });
}

void save(const Preflight& preflight, const fs::path& folder) {
  diagnosis::write_preflight(preflight, folder);
  report::write_report(report::preflight_report(preflight), folder);
}

}  // namespace

void bind_preflight(nb::module_& module) {
  nb::class_<Preflight>(module, "Preflight")
      .def_prop_ro("json", [](const Preflight& p) { return diagnosis::preflight_json(p); })
      .def_prop_ro("summary", [](const Preflight& p) { return diagnosis::preflight_text(p); })
      .def("save", &save, nb::arg("folder"))
      .def("report_html",
           [](const Preflight& p) { return report::report_html(report::preflight_report(p)); });
  module.def(
      "preflight",
      [](const Experiment& experiment, std::optional<int> trials, std::optional<int> seed,
         double size, const std::optional<yaml::Node>& settings,
         const std::vector<std::string>& effect_files, const std::vector<effects::UserEffect>& own,
         bool alternatives, int jobs, const StageProgress& progress) {
        return run(experiment, {trials, seed, size, alternatives}, settings, effect_files, own,
                   jobs, progress);
      },
      nb::arg("experiment"), nb::arg("trials").none(), nb::arg("seed").none(), nb::arg("size"),
      nb::arg("settings").none(), nb::arg("effect_files"), nb::arg("own"), nb::arg("alternatives"),
      nb::arg("jobs"), nb::arg("progress") = nb::none());
}

}  // namespace jaculus::python
