#pragma once
// Experiments that could follow the present one.
//
// The present one once more; the same by duty instead of torque, or the other way round, where the
// plan has both; other commands and a payload (other_commands.h); and, for a robot with a tail that
// has drag and a motor, the tail on a bench (base held, half the battery's voltage to and fro) and
// a drop (full command on the tail from straight back, legs as now).

#include <functional>
#include <string>
#include <vector>

#include "diagnosis/forward/problem.h"
#include "diagnosis/noise/noise_model.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::diagnosis {

struct NamedExperiment {
  std::string name;
  simulation::Experiment experiment;
};
/// InputError where the robot or its stated controller does not allow the experiment.
using ExperimentMaker = std::function<NamedExperiment()>;

/// What was done where only its data are known: motion capture and encoders with the noise that
/// these show, settings.simulated_trials trials. The data must have a plan or a script.
simulation::Experiment present_experiment(const trajectory::Dataset& present,
                                          const Problem& problem, const NoiseModel& noise);

/// Sensors are as the present one has them.
std::vector<ExperimentMaker> possible_experiments(const simulation::Experiment& present,
                                                  const Settings& settings);

}  // namespace jaculus::diagnosis
