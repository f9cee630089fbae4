#include "jaculus/trajectory/kinds.h"

namespace jaculus::trajectory {

const NameTable<ExperimentKind>& experiment_kinds() {
  static const NameTable<ExperimentKind> table({{ExperimentKind::leap, "leap"},
                                                {ExperimentKind::self_righting, "self_righting"},
                                                {ExperimentKind::tail_bench, "tail_bench"},
                                                {ExperimentKind::pendulum, "pendulum"}});
  return table;
}

const NameTable<ControllerKind>& controller_kinds() {
  static const NameTable<ControllerKind> table({{ControllerKind::feedforward_pd, "feedforward_pd"},
                                                {ControllerKind::voltage, "voltage"},
                                                {ControllerKind::torque, "torque"},
                                                {ControllerKind::measured, "measured"}});
  return table;
}

const NameTable<AfterEnd>& after_ends() {
  static const NameTable<AfterEnd> table({{AfterEnd::hold, "hold"},
                                          {AfterEnd::relax, "relax"},
                                          {AfterEnd::repeat, "repeat"},
                                          {AfterEnd::pose, "pose"}});
  return table;
}

const char* name_of(ExperimentKind kind) { return experiment_kinds().name(kind); }
const char* name_of(ControllerKind kind) { return controller_kinds().name(kind); }
const char* name_of(AfterEnd end) { return after_ends().name(end); }

}  // namespace jaculus::trajectory
