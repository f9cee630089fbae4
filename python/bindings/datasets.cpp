// Datasets, and the simulation of experiments.

#include <nanobind/eigen/dense.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "jaculus/effects/trials.h"
#include "jaculus/report/dataset_report.h"
#include "jaculus/simulation/experiment.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::python {
namespace {

namespace fs = std::filesystem;
using simulation::Experiment;
using trajectory::Dataset;

struct Trials {
  Dataset dataset;
  nlohmann::ordered_json summary;
  std::string text;
  bool done = true;
  bool interrupted = false;
};

Trials simulate(Experiment experiment, std::optional<int> trials, std::optional<int> seed,
                const effects::EffectChoice& choice) {
  if (trials) experiment.trials = *trials;
  if (seed) experiment.seed = *seed;
  return compute([&] {
    const model::PlanarModel model = simulation::dataset_robot(experiment.setup).planar;
    const auto effects = effects::choose_effects(choice, model);
    effects::SimulatedTrials done = effects::simulate_trials(experiment, effects, model);

    std::string text = report::simulation_text(experiment, done.summary);
    return Trials{std::move(done.dataset), std::move(done.summary), std::move(text), done.done,
                  interrupt_requested()};
  });
}

report::Report report_of(const Dataset& dataset, const std::string& title) {
  return report::dataset_report(dataset, simulation::dataset_robot(dataset).planar, title);
}

void save_dataset(Dataset& dataset, const fs::path& folder, const std::string& title) {
  fs::create_directories(folder);
  trajectory::write_dataset(dataset, folder);
  report::write_report(report_of(dataset, title), folder);
}

void bind_streams(nb::module_& module) {
  using trajectory::Stream;
  nb::class_<Stream>(module, "Stream")
      .def_ro("name", &Stream::name)
      .def_ro("rate_hz", &Stream::rate_hz)
      .def_ro("time", &Stream::time)
      .def_ro("channels", &Stream::channels)
      .def_ro("units", &Stream::units)
      .def_ro("values", &Stream::values);
  nb::class_<trajectory::Trial>(module, "Trial")
      .def_ro("name", &trajectory::Trial::name)
      .def_ro("streams", &trajectory::Trial::streams);
}

}  // namespace

void bind_datasets(nb::module_& module) {
  bind_streams(module);
  nb::class_<Dataset>(module, "Dataset")
      .def_ro("folder", &Dataset::folder)
      .def_prop_ro("experiment",
                   [](const Dataset& d) { return std::string(trajectory::name_of(d.experiment)); })
      .def_ro("robot", &Dataset::robot)
      .def_ro("trials", &Dataset::trials)
      .def_ro("provenance", &Dataset::provenance)
      .def_ro("notes", &Dataset::notes)
      .def_ro("plan", &Dataset::plan)
      .def("save", &save_dataset, nb::arg("folder"), nb::arg("title"))
      .def("report_html", [](const Dataset& d, const std::string& title) {
        return report::report_html(report_of(d, title));
      });
  module.def("load_dataset", &trajectory::read_dataset, nb::arg("folder"));

  nb::class_<Trials>(module, "Trials")
      .def_ro("dataset", &Trials::dataset)
      .def_prop_ro("json", [](const Trials& t) { return t.summary.dump(1); })
      .def_ro("summary", &Trials::text)
      .def_ro("done", &Trials::done)
      .def_ro("interrupted", &Trials::interrupted);
  nb::class_<Experiment>(module, "Experiment").def_ro("name", &Experiment::name);
  module.def(
      "load_experiment", [](const yaml::Node& node) { return simulation::read_experiment(node); },
      nb::arg("node"));
  module.def("plan_experiment", &simulation::plan_experiment, nb::arg("plan"), nb::arg("robot"),
             nb::arg("controller"));
  module.def(
      "simulate",
      [](const Experiment& experiment, std::optional<int> trials, std::optional<int> seed,
         const std::vector<std::string>& effects, const std::vector<std::string>& files,
         const fs::path& augmented, const std::vector<effects::UserEffect>& own) {
        return simulate(experiment, trials, seed,
                        {.effects = effects, .files = files, .augmented = augmented, .coded = own});
      },
      nb::arg("experiment"), nb::arg("trials").none(), nb::arg("seed").none(), nb::arg("effects"),
      nb::arg("effect_files"), nb::arg("augmented"), nb::arg("own"));
}

}  // namespace jaculus::python
