#include "jaculus/components/motor.h"
#include "jaculus/transcription/guess.h"

namespace jaculus {

namespace {

struct SamplePoint {
  const EquationsPoint* point;
  const Vector* input;
  double time;
};

void name_channels(const PlanarModel& model, Trajectory& t) {
  for (const Coordinate& c : model.coordinates) {
    t.coordinates.push_back(c.name);
    t.angular.push_back(c.angular);
  }
  for (size_t b = 1; b < model.bodies.size(); ++b) t.joints.push_back(model.bodies[b].joint);
  for (const PlanarMotor& motor : model.motors) t.motors.push_back(motor.joint);
  for (const PlanarPoint& foot : model.feet) t.feet.push_back(foot.name);
}

void resize(Trajectory& t, int samples) {
  const auto rows = [](const auto& names) { return static_cast<int>(names.size()); };
  t.time.resize(samples);
  for (Matrix* m : {&t.position, &t.velocity, &t.acceleration}) m->resize(rows(t.coordinates), samples);
  for (Matrix* m : {&t.joint_position, &t.joint_velocity}) m->resize(rows(t.joints), samples);
  for (Matrix* m : {&t.torque, &t.motor_torque, &t.current, &t.voltage}) m->resize(rows(t.motors), samples);
  t.force_x.setZero(rows(t.feet), samples);
  t.force_z.setZero(rows(t.feet), samples);
}

void put_sample(const Equations& equations, const SamplePoint& s, int k, Trajectory& t) {
  const AbsoluteTree& tree = equations.tree();
  const EquationsPoint& p = *s.point;
  t.time[k] = s.time;
  t.position.col(k) = p.q;
  t.velocity.col(k) = p.v;
  t.acceleration.col(k) = p.a;
  t.joint_position.col(k) = joint_positions(tree, p.q, p.motion).tail(t.joint_position.rows());
  t.joint_velocity.col(k) = joint_velocities(tree, p.v, p.motion).tail(t.joint_velocity.rows());
  for (int m = 0; m < t.torque.rows(); ++m) {
    const PlanarMotor& motor = equations.model().motors[static_cast<size_t>(m)];
    const double torque = (*s.input)[m], rate = t.joint_velocity(motor.body - 1, k);
    t.torque(m, k) = torque;
    t.motor_torque(m, k) = torque / (motor.gear * motor.efficiency);
    t.current(m, k) = motor_current(motor, torque);
    t.voltage(m, k) = motor_voltage(motor, torque, rate).value;
  }
  for (size_t i = 0; i < p.feet.size(); ++i) {
    t.force_x(p.feet[i], k) = p.force[2 * static_cast<int>(i)];
    t.force_z(p.feet[i], k) = p.force[2 * static_cast<int>(i) + 1];
  }
}

}  // namespace

Trajectory to_trajectory(Programme& programme, const ConstVectorRef& x) {
  Trajectory t;
  name_channels(programme.equations().model(), t);
  t.input_hold = programme.layout().held ? "held" : "linear";
  if (!programme.evaluate_at(x)) return t;
  std::vector<SamplePoint> samples;
  double start = 0.0;
  for (const PhaseBlock& phase : programme.layout().phases) {
    PhaseSpan span{phase.name, {}, static_cast<int>(samples.size()), 0};
    for (int foot : phase.feet) span.contacts.push_back(t.feet[static_cast<size_t>(foot)]);
    double begin = start;
    for (int k = phase.first_interval; k <= phase.last_interval; ++k) {
      const Interval& interval = programme.intervals()[static_cast<size_t>(k)];
      t.interval_start.push_back(static_cast<int>(samples.size()));
      samples.push_back({&interval.point(0), &interval.input(0), begin});
      if (interval.has_middle())
        samples.push_back({&interval.point(1), &interval.input(1), begin + 0.5 * interval.length()});
      begin += interval.length();
      if (k == phase.last_interval) samples.push_back({&interval.point(2), &interval.input(2), begin});
    }
    start = begin;
    span.last = static_cast<int>(samples.size()) - 1;
    t.phases.push_back(span);
  }
  resize(t, static_cast<int>(samples.size()));
  for (size_t k = 0; k < samples.size(); ++k) put_sample(programme.equations(), samples[k], static_cast<int>(k), t);
  return t;
}

}  // namespace jaculus
