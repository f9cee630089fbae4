#include "diagnosis/preflight/simulated_data.h"

namespace jaculus::diagnosis {

std::optional<trajectory::Dataset> simulated_data(const simulation::Experiment& experiment,
                                                  const Explanation& explanation) {
  const model::PlanarModel model = simulation::dataset_robot(experiment.setup).planar;
  simulation::Plant plant = simulation::dataset_plant(experiment.setup, model);
  for (std::size_t i = 0; i < explanation.effects.size(); ++i)
    if (explanation.effects[i]->applies(model))
      explanation.effects[i]->apply(explanation.theta[i], plant);

  const simulation::Controller controller = experiment_controller(experiment, model);
  trajectory::Dataset dataset = experiment.setup;
  const auto seed = static_cast<std::uint64_t>(experiment.seed);
  for (int k = 0; k < experiment.trials; ++k) {
    const simulation::TrialRun run = run_trial(experiment, plant, controller, k, seed);
    if (run.truth.status != simulation::SimulationStatus::done) return std::nullopt;
    dataset.trials.push_back(run.trial);
  }
  return dataset;
}

}  // namespace jaculus::diagnosis
