#pragma once
// What every effect must do, tried in an experiment: nominal changes nothing, bit for bit; the
// influence fades smoothly to nothing; simulated data give the first parameter back. The tests of
// the catalogue and `jaculus check my_effect.yaml` run these.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/effects/effect.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::effects {

/// What sensors show with an effect's parameters, each sample over the sensor's noise; nothing
/// where the simulation does not end (`why` says so).
using DataOf = std::function<std::optional<Vector>(const Vector& theta, std::string& why)>;

/// Data of an experiment without its scatter, noise and gaps: positions and rates, and channels
/// that the effect itself reads wrongly. Torques, currents and voltages jump with the commands,
/// where a sample falls on either side. InputError where experiment and robot don't fit.
DataOf data_of(const simulation::Experiment& experiment, const Effect& effect);

/// Nominal, with a share of the probing step in one parameter.
Vector part_of_step(const Effect& effect, double share, int parameter = 0);

/// Root mean square of a share of the probing step's influence [noise].
struct Influence {
  double share = 0.0;  ///< [-]
  double size = 0.0;   ///< [noise]; NaN: the simulation did not end
};
/// At shares 1, 1/4, 1/16, 1/64.
std::vector<Influence> influences(const Effect& effect, const DataOf& data);

/// The first parameter by Gauss-Newton with halved steps, from the probed value, and its standard
/// error for data of unit noise.
struct FirstParameter {
  double value = kNaN, deviation = kNaN;
};
FirstParameter fit_first(const Effect& effect, const DataOf& data, const Vector& measured);

/// One thing that was tried.
struct Check {
  std::string what;   ///< "nominal changes nothing"
  std::string found;  ///< "bit for bit, 1500 samples"
  bool passed = false;
};
/// All of them, in order; those behind one that fails for good are missing.
std::vector<Check> check_effect(const Effect& effect, const simulation::Experiment& experiment);

/// A sentence for each parameter whose scale, as a step beside the others, this experiment can't
/// see or is drowned by, with one that it could judge.
std::vector<std::string> scale_hints(const Effect& effect,
                                     const simulation::Experiment& experiment);

}  // namespace jaculus::effects
