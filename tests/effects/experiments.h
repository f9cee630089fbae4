#pragma once
// Experiments in small that excite the catalogue's effects: a leap, a falling robot that turns
// over, a tail on the bench, a pendulum. What sensors would show of them: motion capture and
// encoders, with the plant's own latency, scale and offset.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/effects/effect.h"
#include "jaculus/simulation/simulate.h"

namespace jaculus::test {

struct Experiment {
  trajectory::ExperimentKind kind = trajectory::ExperimentKind::leap;
  std::string robot;  ///< its folder, from the source tree's root
  std::function<model::PlanarModel(const model::PlanarModel&)>
      held;                 ///< what the experiment holds of the robot
  simulation::Plant plant;  ///< without effects
  simulation::Controller controller;
  bool stands = false;  ///< starts on its feet, at rest in the reference's pose; else from `start`
  simulation::StartState start;
  simulation::SimulationOptions options;
};

/// One of each kind that can be set up here: the leap needs the authors' plan.
const std::vector<Experiment>& experiments();
/// The Minitaur with its tail.
const model::PlanarModel& tailed();
/// A robot of two plain joints, shoulder and elbow, both driven.
const Experiment& two_joints();

/// One channel's samples and the noise of its sensor.
struct Shown {
  std::string channel;
  Vector values;
  double noise = 0.0;  ///< standard deviation
};

/// What the sensors show of an experiment on a plant; nothing where the simulation did not finish
/// (`why` says so).
std::optional<std::vector<Shown>> measure(const Experiment& experiment,
                                          const simulation::Plant& plant, std::string& why);

/// The experiment's robot, read again with values of the model.
model::PlanarModel with_values(const Experiment& experiment,
                               const std::vector<effects::ModelOverride>& values);

/// The same as one vector, every channel in its noise.
std::optional<Vector> measured_in_noise(const Experiment& experiment,
                                        const simulation::Plant& plant, std::string& why);

}  // namespace jaculus::test
