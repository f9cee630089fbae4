#include "transcription/guess_from_plan.h"

#include <algorithm>

#include "jaculus/components/motor.h"

namespace jaculus::transcription {

namespace {

/// The part of an earlier plan that one phase takes.
struct Source {
  const trajectory::Trajectory& plan;
  const trajectory::PhaseSpan& span;
  const model::PlanarModel& model;

  /// Sample index and fraction for time t.
  [[nodiscard]] std::pair<int, double> locate(double t) const {
    int k = span.first;
    while (k + 1 < span.last && plan.time[k + 1] <= t) ++k;
    const double h = plan.time[std::min(k + 1, span.last)] - plan.time[k];
    return {k, h > 0.0 ? std::clamp((t - plan.time[k]) / h, 0.0, 1.0) : 0.0};
  }

  void copy_node(double t, const NodeBlock& node, Vector& x) const {
    const auto [k, f] = locate(t);
    const int next = std::min(k + 1, span.last);
    for (int c = 0; c < count_of(plan.coordinates); ++c) {
      const int i = model.coordinate_index(plan.coordinates[c]);
      if (i < 0) continue;
      x[node.q + i] = (1.0 - f) * plan.position(c, k) + f * plan.position(c, next);
      x[node.v + i] = (1.0 - f) * plan.velocity(c, k) + f * plan.velocity(c, next);
    }
  }

  /// The input of motor m at sample k: its torque without what it gives against dry friction.
  [[nodiscard]] double input(int m, int k, const model::PlanarMotor& motor) const {
    const auto joint = std::find(plan.joints.begin(), plan.joints.end(), motor.joint);
    if (joint == plan.joints.end()) return plan.torque(m, k);
    const double rate = plan.joint_velocity(joint - plan.joints.begin(), k);
    return plan.torque(m, k) - components::against_dry_friction(motor, rate).value;
  }

  /// An input that is held over an interval of the earlier plan does not change up to its end.
  void copy_input(double t, int column, Vector& x) const {
    const auto [k, along] = locate(t);
    const double f = plan.input_hold == "linear" ? along : 0.0;
    const int next = std::min(k + 1, span.last);
    for (int m = 0; m < count_of(plan.motors); ++m) {
      const int i = model.motor_index(plan.motors[m]);
      if (i < 0) continue;
      const model::PlanarMotor& motor = model.motors[i];
      x[column + i] = (1.0 - f) * input(m, k, motor) + f * input(m, next, motor);
    }
  }
};

}  // namespace

void copy_plan(const trajectory::Trajectory& earlier, const Layout& layout,
               const model::PlanarModel& model, Vector& x) {
  for (std::size_t p = 0; p < layout.phases.size() && p < earlier.phases.size(); ++p) {
    const Source source{earlier, earlier.phases[p], model};
    const PhaseBlock& phase = layout.phases[p];
    const double start = earlier.time[source.span.first];
    const double length = earlier.time[source.span.last] - start;
    x[phase.duration] = length;

    double done = 0.0;
    for (int k = phase.first_interval; k <= phase.last_interval; ++k) {
      const IntervalBlock& interval = layout.intervals[k];
      const double t0 = start + done * length;
      done += interval.fraction;
      const double t1 = start + done * length;
      source.copy_node(t0, layout.nodes[interval.first], x);
      source.copy_node(t1, layout.nodes[interval.last], x);

      const double middle_time = 0.5 * (t0 + t1);
      source.copy_input(layout.held ? middle_time : t0, interval.u_first, x);
      if (!layout.held) source.copy_input(t1, interval.u_last, x);
    }
  }
}

}  // namespace jaculus::transcription
