#pragma once
// What an experiment and its controller are, as dataset.yaml names them.

#include "jaculus/core/names.h"

namespace jaculus::trajectory {

enum class ExperimentKind { leap, self_righting, tail_bench, pendulum };

/// How the commands became torques.
enum class ControllerKind {
  feedforward_pd,  ///< feed-forward and joint PD, in one quantity
  voltage,         ///< a script of voltages
  torque,          ///< a script of torques
  measured         ///< no commands: a logged quantity drove the joints
};

/// What a controller does after its plan.
enum class AfterEnd {
  hold,    ///< last reference pose, feed-forward zero
  relax,   ///< no command
  repeat,  ///< last command goes on
  pose     ///< a pose to land in, feed-forward zero
};

const NameTable<ExperimentKind>& experiment_kinds();
const NameTable<ControllerKind>& controller_kinds();
const NameTable<AfterEnd>& after_ends();

/// "self_righting", "feedforward_pd", "hold".
const char* name_of(ExperimentKind kind);
const char* name_of(ControllerKind kind);
const char* name_of(AfterEnd end);

}  // namespace jaculus::trajectory
