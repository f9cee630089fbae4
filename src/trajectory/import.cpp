#include "jaculus/trajectory/import.h"

#include <fmt/format.h>

#include "jaculus/core/error.h"
#include "trajectory/dataset_yaml.h"

namespace jaculus::trajectory {

Dataset begin_dataset(const ImportSetup& setup) {
  if (setup.controller.empty() && setup.plan.empty())
    throw InputError(
        "neither --plan nor --controller is given; allowed: what was commanded, or --controller "
        "\"{kind: measured, input: torque}\" where a logged quantity drove the joints");
  Dataset dataset;
  if (!setup.plan.empty()) dataset.plan = read_plan(setup.plan);

  // The keys of dataset.yaml, so that their faults are told in the same words; texts are read by
  // themselves, not pasted in.
  const std::string text =
      setup.controller.empty() ? "{kind: feedforward_pd, rate_hz: 1000}" : setup.controller;
  const yaml::Node controller = yaml::Node::parse(text, "--controller");
  dataset.controller = read_stated_controller(controller, dataset.notes);
  note_places(controller, "controller", dataset);
  if (dataset.controller.kind != ControllerKind::measured && !dataset.plan)
    throw InputError(fmt::format(
        "--controller: of kind {} without --plan; allowed: with a plan, or kind measured",
        name_of(dataset.controller.kind)));
  dataset.experiment = setup.experiment;
  dataset.robot = setup.robot;
  dataset.folder = ".";

  return dataset;
}

}  // namespace jaculus::trajectory
