#include "jaculus/studies/reorientation.h"

#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <numbers>

#include "studies/reorientation_systems.h"

namespace jaculus::studies {
namespace {

using detail::Motion;

constexpr int kMostSteps = 200000;

// A run in progress: what the systems hand on to one another.
struct Run {
  const ReorientationCase& c;
  double tolerance;
  std::vector<ReorientationSample>* history;
  ReorientationResult result;
  double time = 0.0;
  bool stopped = false;

  void record(const Motion& m) const {
    if (history)
      history->push_back(
          {time, m.body_angle, m.body_rate, m.tail_angle, m.tail_rate, m.joint_torque});
  }
};

// The size in (0, high] of the step at which value(state) passes zero: Newton's method held in a
// shrinking bracket. value returns the function and its time derivative; it is negative at 0 and
// not at `high`.
template <class Stepper, class Value>
double step_to_root(const Stepper& stepper, double high, typename Stepper::State& y,
                    const Value& value) {
  typename Stepper::State error;
  double low = 0.0;
  double h = high;
  for (int i = 0; i < 60; ++i) {
    const auto [f, slope] = value(y);
    (f < 0.0 ? low : high) = h;
    const double newton = slope > 0.0 ? h - f / slope : low;
    const double next = newton > low && newton < high ? newton : 0.5 * (low + high);
    const bool done = std::abs(next - h) <= 1e-15 * high || f == 0.0;
    if (done) break;
    h = next;
    y = stepper.step(h, error);
  }
  return h;
}

std::pair<double, double> to_stop(const ReorientationCase& c, const Motion& m) {
  return {m.tail_angle - c.stroke, m.tail_rate};
}

std::pair<double, double> to_target(const ReorientationCase& c, const Motion& m) {
  return {std::abs(m.body_angle) - c.target_angle, std::copysign(1.0, m.body_angle) * m.body_rate};
}

// Integrates until the end, or the stop where `may_stop`. Returns the last state; run.time,
// run.stopped and the result's time_to_target and steps are brought up to date. A failure leaves
// run.time short of the end.
template <class System>
typename System::State drive(const System& system, typename System::State y, bool may_stop,
                             Run& run) {
  using State = typename System::State;

  const double end = run.c.duration;
  const State scale = run.tolerance * system.scale(end);
  double h = 0.02 * end;
  State error;

  for (int tries = 0; run.time < end && tries < kMostSteps;) {
    const detail::RosenbrockStep<System> stepper(system, y);
    const bool last = run.time + 1.0001 * h >= end;
    double size = last ? end - run.time : h;
    State next;

    for (;; ++tries) {
      next = stepper.step(size, error);
      const double e = (error.array().abs() /
                        (scale.array() + run.tolerance * y.array().abs().max(next.array().abs())))
                           .maxCoeff();
      const bool good = next.allFinite() && std::isfinite(e);
      const double factor =
          good ? std::clamp(0.9 / std::sqrt(std::sqrt(std::max(e, 1e-12))), 0.2, 6.0) : 0.1;
      h = size * factor;
      if (good && e <= 1.0) break;
      size = h;
      if (tries >= kMostSteps || size < 1e-15 * end) return y;
    }

    bool stop = false;
    if (may_stop && to_stop(run.c, system.motion(next)).first >= 0.0) {
      size = step_to_root(stepper, size, next,
                          [&](const State& x) { return to_stop(run.c, system.motion(x)); });
      stop = true;
    }

    if (!run.result.time_to_target && to_target(run.c, system.motion(next)).first >= 0.0) {
      State at = next;
      run.result.time_to_target = run.time + step_to_root(stepper, size, at, [&](const State& x) {
                                    return to_target(run.c, system.motion(x));
                                  });
    }

    y = next;
    run.time = last && !stop && size >= end - run.time ? end : run.time + size;
    ++run.result.steps;
    ++tries;
    run.record(system.motion(y));
    run.stopped = stop;
    if (stop) break;
  }
  return y;
}

// The plastic impact: the tail's rate to the body vanishes, the sum of momenta stays.
StopEvent impact(const detail::Bodies& in, double time, const Motion& m) {
  StopEvent stop;
  stop.time = time;
  stop.body_angle = m.body_angle;
  stop.tail_rate = m.tail_rate;
  stop.body_rate_before = m.body_rate;
  stop.momentum_before = in.body * m.body_rate + in.tail * (m.body_rate + m.tail_rate);
  stop.body_rate_after = m.body_rate + in.tail * m.tail_rate / in.total;
  stop.momentum_after = in.total * stop.body_rate_after;
  stop.impulse = in.tail * (stop.body_rate_after - (m.body_rate + m.tail_rate));
  return stop;
}

// The locked pair in still air, in closed form.
Motion coast(const detail::Bodies& in, double b, const Motion& from, Run& run) {
  const double rest = run.c.duration - run.time;
  const double rate = std::abs(from.body_rate);
  const double decay = b / in.total;  // 1/rad

  const auto angle = [&](double s) {
    const double swept = decay > 0.0 ? std::log1p(decay * rate * s) / decay : rate * s;
    return from.body_angle + std::copysign(swept, from.body_rate);
  };

  const double missing = run.c.target_angle - std::abs(from.body_angle);
  if (!run.result.time_to_target && missing > 0.0 && from.body_angle * from.body_rate > 0.0) {
    const double s = decay > 0.0 ? std::expm1(decay * missing) / (decay * rate) : missing / rate;
    if (s <= rest) run.result.time_to_target = run.time + s;
  }

  const double start = run.time;
  const int samples = run.history ? 32 : 1;
  Motion m = from;
  for (int i = 1; i <= samples; ++i) {
    const double s = rest * i / samples;
    m.body_angle = angle(s);
    m.body_rate = from.body_rate / (1.0 + decay * rate * s);
    run.time = start + s;
    run.record(m);
  }

  run.time = run.c.duration;
  return m;
}

Motion after_stop(const detail::Bodies& in, const detail::Air& air, const Motion& before,
                  Run& run) {
  run.result.stop = impact(in, run.time, before);
  const Motion after{before.body_angle, run.result.stop->body_rate_after, before.tail_angle, 0.0,
                     0.0};
  run.record(after);
  if (run.time >= run.c.duration) return after;
  if (air.still) return coast(in, air.b, after, run);
  const detail::Locked locked{in, air, before.tail_angle};
  return locked.motion(
      drive(locked, {after.body_rate, after.body_angle + after.tail_angle}, false, run));
}

template <class System>
void play(const System& system, const detail::Bodies& in, const detail::Air& air, Run& run) {
  const typename System::State start = system.start();
  run.record(system.motion(start));
  Motion m = system.motion(drive(system, start, true, run));
  if (run.stopped) m = after_stop(in, air, m, run);
  ReorientationResult& r = run.result;
  r.converged = run.time >= run.c.duration;
  r.body_angle = m.body_angle;
  r.body_rate = m.body_rate;
  r.tail_angle = m.tail_angle;
  r.tail_rate = m.tail_rate;
  r.effectiveness = std::abs(m.body_angle) / m.tail_angle;
  if (r.stop) r.rotation_after_stop = std::abs(m.body_angle) - std::abs(r.stop->body_angle);
}

}  // namespace

ReorientationResult simulate_reorientation(const ReorientationCase& c, double tolerance,
                                           std::vector<ReorientationSample>* history) {
  assert(check_case(c).empty());
  assert(tolerance > 0.0);
  const detail::Bodies in(c);
  const detail::MotorCurve motor(c);
  const detail::Air air(c);
  Run run{c, tolerance, history, {}};
  if (std::isfinite(c.root_stiffness)) {
    play(detail::Sprung{in, motor, air, c.root_stiffness}, in, air, run);
  } else if (air.still) {
    play(detail::RigidStill{in, motor, air}, in, air, run);
  } else {
    play(detail::RigidWind{in, motor, air}, in, air, run);
  }
  return run.result;
}

std::string check_case(const ReorientationCase& c) {
  struct Check {
    const char* name;
    double value;
  };

  for (const Check& k :
       {Check{"body inertia", c.body_inertia}, Check{"tail inertia", c.tail_inertia},
        Check{"stroke", c.stroke}, Check{"duration", c.duration},
        Check{"target angle", c.target_angle}, Check{"gear", c.motor.gear},
        Check{"gear efficiency", c.motor.efficiency},
        Check{"torque constant", c.motor.torque_constant}, Check{"resistance", c.motor.resistance},
        Check{"voltage", c.motor.voltage}}) {
    if (!std::isfinite(k.value) || k.value <= 0.0)
      return fmt::format("{} is {}; it must be above 0", k.name, k.value);
  }

  const model::PlanarMotor& m = c.motor;
  if (!(m.saturation_linear > 0.0 && m.saturation_cubic >= 0.0)) {
    return fmt::format(
        "the motor's saturation is {} and {}; linear must be above 0, cubic 0 or more",
        m.saturation_linear, m.saturation_cubic);
  }
  if (c.motor_limits && !(components::largest_joint_torque(m).value > 0.0)) {
    return "the motor's limits leave no torque; current and torque limit must be above 0";
  }

  if (!(c.root_stiffness > 0.0))
    return fmt::format("root stiffness is {}; it must be above 0", c.root_stiffness);

  const model::PlanarDrag& d = c.drag;
  if (d.kind == model::DragKind::none) return "";
  if (!(d.density >= 0.0 && d.coefficient >= 0.0))
    return "density and drag coefficient must be 0 or more";
  if (d.kind == model::DragKind::point) {
    if (!(d.point_distance > 0.0 && d.point_area >= 0.0))
      return "a point drag needs a distance above 0 and an area";
    return "";
  }

  if (!(d.end > 0.0)) return fmt::format("tail length is {} m; it must be above 0", d.end);
  if (!(d.start >= 0.0)) return fmt::format("shaft length is {} m; it must be 0 or more", d.start);
  if (d.start > d.end)
    return fmt::format("shaft length is {} m; it can't exceed the tail's {} m", d.start, d.end);
  if (!(d.width >= 0.0)) return fmt::format("tail width is {} m; it must be 0 or more", d.width);
  return "";
}

double fall_time(double height) { return std::sqrt(2.0 * height / kGravity); }

ReorientationCase paper_case() {
  ReorientationCase c;

  c.body_inertia = 0.23;
  c.tail_inertia = 0.058;

  c.motor.joint = "tail";
  c.motor.torque_constant = 0.0954;
  c.motor.resistance = 0.186;
  c.motor.saturation_linear = 8.93;
  c.motor.saturation_cubic = 0.539;
  c.motor.voltage = 16.0;
  c.motor.gear = 4.0;

  c.drag.name = "tail";
  c.drag.kind = model::DragKind::rotation;
  c.drag.coefficient = 2.0;
  c.drag.width = 0.18;
  c.drag.start = 0.6;
  c.drag.end = 1.0;

  c.stroke = std::numbers::pi;
  c.duration = fall_time(0.5);
  c.target_angle = 0.5 * std::numbers::pi;
  return c;
}

}  // namespace jaculus::studies
