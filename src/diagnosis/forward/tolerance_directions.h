#pragma once
// Ways in which a robot may be off its files without anything being wrong (model/tolerances.h), as
// moves of plant and controller: e = 1 is one standard deviation of the builder's tolerance. Links
// and motors that are lumped move alike.

#include <functional>
#include <string>
#include <vector>

#include "diagnosis/data/observations.h"
#include "jaculus/diagnosis/settings.h"
#include "jaculus/model/tolerances.h"
#include "jaculus/simulation/controller.h"
#include "jaculus/simulation/plant.h"

namespace jaculus::diagnosis {

/// Nothing within tolerance is off by more than two deviations (model/tolerances.h).
constexpr Bounds kWithin{-2.0, 2.0};

struct ToleranceDirection {
  std::string name;       ///< "mass of trunk"
  Bounds range{};         ///< of e
  bool geometry = false;  ///< whether the robot stands otherwise
  std::function<void(double e, simulation::Plant& plant, simulation::Controller& controller)> move;
  /// The quantities that it moves, as a plant has them [deviations]: one, or one for each direction
  /// of motion where an effect may part these; none where effects move no such one.
  std::vector<std::function<double(const simulation::Plant& plant)>> reads;
};

/// Those that can matter for a robot; gains only where a loop has them.
/// `lever` [m]: of a friction at a motor without a limit (large_force in missing_forces.h).
std::vector<ToleranceDirection> tolerance_directions(const model::PlanarModel& model,
                                                     const model::Tolerances& tolerances,
                                                     bool measured_input, double lever);

/// Those of a dataset's robot, and of its clock where an input was logged.
std::vector<ToleranceDirection> tolerances_of(const ObservedDataset& observed,
                                              const Settings& settings);

/// The stamps of a logged input beside those of the motion: the log acts `deviation` [s] later.
ToleranceDirection input_clock(double deviation);

}  // namespace jaculus::diagnosis
