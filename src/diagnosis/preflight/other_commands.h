#pragma once
// The present experiment with other commands, or with a known payload.
//
// Of a script, on its joints and within its largest values c:
//   chirp   c sin(2 pi (f0 + (f1 - f0) t/(2 T)) t), settings.chirp_lowest to chirp_highest, T its
//           duration
//   holds   c times 1/2, 1, 1/2, 0, -1/2, -1, -1/2, 0, an eighth of the time each: slow, so that
//           friction and weight show apart
//   stronger  settings.stronger_command times its values
// Of a plan: the same on a bus of settings.lower_voltage. Of either: settings.payload of the mass
// of the base, or of the last body where the base is fixed, known and at its centre of mass.

#include "diagnosis/preflight/experiments.h"

namespace jaculus::diagnosis {

std::vector<ExperimentMaker> other_commands(const simulation::Experiment& present,
                                            const model::PlanarModel& model,
                                            const Settings& settings);

}  // namespace jaculus::diagnosis
