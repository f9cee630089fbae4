#pragma once
// Forward model of a diagnosis: parameters in, predicted channels out, by simulation of the plant.
//
// One simulation serves all runs of a condition that share command and start; they differ in nuisances that are linear:
//   y_c(t_i) = f_c(t_i - shift; p) + sum_k (df_c/ds_k) s_k + offset_c.
// f stands on a uniform grid of model time and is interpolated; before the start it keeps its first value (the robot is held),
// so that data from before the command count as rest.

#include <functional>
#include <string>
#include <vector>

#include "jaculus/diagnosis/data.h"
#include "jaculus/diagnosis/hypotheses.h"
#include "jaculus/simulation/simulate.h"

namespace jaculus {

/// Channels of one condition on a uniform grid of model time.
struct Prediction {
  bool valid = false;
  std::string message;            ///< why not valid: the simulation's own
  double step = 1e-3;             ///< of the grid [s]
  Matrix values;                  ///< channels x grid points
  std::vector<double> impacts{};  ///< of stops and landing feet, in order, model time [s]
  std::vector<double> steps{};    ///< of a scripted command and the end of any, where they arrive, model time [s]
  double first = 0.0;             ///< of the grid, model time [s]
  std::vector<double> stamped{};  ///< a channel each: by which its sensor stamps late [s]; empty: 0
  std::vector<double> late{};  ///< a channel each: by which its command and its stamps are late together [s]; empty: 0

  /// By which a channel is late [s].
  [[nodiscard]] double lateness(std::size_t channel) const { return late.empty() ? 0.0 : late[channel]; }
  /// Value of a channel at a model time, linear between grid points, constant beyond the ends.
  [[nodiscard]] double at(int channel, double time) const;
  /// Mean over the samples that a run averages into a row whose mean time, in the model, is `time`.
  [[nodiscard]] double row(const Run& run, int channel, double time) const;
};

/// Predicts run `run` of condition `condition` at the flat parameters `p`. Pure: may be called from several threads.
using ForwardModel = std::function<Prediction(int condition, int run, const Vector& p)>;

/// How a condition is simulated, for those who need more than channels (localisation, next experiments).
struct RunSetup {
  Plant plant;
  Controller controller;
  StartState start;
  SimulationOptions options;
};

/// Builds hypotheses (which effects these robots can have, unknown gains, starts) and the forward model of `observations`.
/// The observations must outlive what is returned.
struct PlantForward {
  Hypotheses hypotheses;
  ForwardModel predict;
  /// Set-up of a run at parameters p.
  std::function<RunSetup(int condition, int run, const Vector& p)> setup;
};
PlantForward plant_forward(const Observations& observations, const std::vector<const Effect*>& effects);

/// Channels of a condition as its sensors show them: joints on the motor's side, scale and offset of the plant's sensing, and by how much
/// they are late. A logged input that drives the joints comes with its own clock, so that nothing is late there.
Prediction prediction_of(const Condition& condition, const Plant& plant, const Simulation& simulation);

/// Predictions at the rows of a condition (data.h), given those of its runs. Runs that share a prediction repeat it.
/// A clock's shift is a nuisance with one slope, f(t - s) = f(t) - s f'(t), good for a part of a millisecond. A prediction that is later
/// than the one by which the runs were aligned, by d, is therefore unrolled as the same motion later: f(t + d) - d f'(t + d). A body that
/// falls meanwhile does not wait: its height is off by g d^2/2, 0.12 mm at 5 ms.
Vector predicted_rows(const Condition& condition, const std::vector<const Prediction*>& runs);

}  // namespace jaculus
