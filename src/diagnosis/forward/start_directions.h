#pragma once
// Directions in which the start of a segment may differ from the stated one.

#include <string>
#include <vector>

#include "diagnosis/data/observations.h"
#include "jaculus/simulation/simulate.h"

namespace jaculus::diagnosis {

/// One direction: a step of `scale` along it is one prior standard deviation.
struct StartDirection {
  std::string name;  ///< "tail", "pitch_velocity"
  std::string unit;
  double scale = 0.0;
  Vector q, v;          ///< unit step of coordinates and rates
  bool stands = false;  ///< the base then moves so that both feet touch; q has it to first order
};

/// Feet that stand on the floor stay there: z and pitch follow the legs. A start in the air may
/// also differ in pitch, and in its rate. Windows of a measured input start with any position and
/// rate.
std::vector<StartDirection> start_directions(const ObservedDataset& observed,
                                             const simulation::StartState& start,
                                             const Settings& settings);

/// Whether a robot stands otherwise than the nominal one does.
bool moves_start(const simulation::Plant& plant);

}  // namespace jaculus::diagnosis
