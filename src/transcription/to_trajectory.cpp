#include "jaculus/components/motor.h"
#include "jaculus/transcription/guess.h"

namespace jaculus::transcription {

namespace {

struct SamplePoint {
  const components::EquationsPoint* point;
  const Vector* input;
  double time;
};

void name_channels(const model::PlanarModel& model, trajectory::Trajectory& t) {
  for (const model::Coordinate& c : model.coordinates) {
    t.coordinates.push_back(c.name);
    t.angular.push_back(c.angular);
  }
  for (std::size_t b = 1; b < model.bodies.size(); ++b) t.joints.push_back(model.bodies[b].joint);
  for (const model::PlanarMotor& motor : model.motors) t.motors.push_back(motor.joint);
  for (const model::PlanarPoint& foot : model.feet) t.feet.push_back(foot.name);
}

void resize(trajectory::Trajectory& t, int samples) {
  const auto rows = [](const auto& names) { return count_of(names); };
  t.time.resize(samples);
  for (Matrix* m : {&t.position, &t.velocity, &t.acceleration})
    m->resize(rows(t.coordinates), samples);
  for (Matrix* m : {&t.joint_position, &t.joint_velocity}) m->resize(rows(t.joints), samples);
  for (Matrix* m : {&t.torque, &t.motor_torque, &t.current, &t.voltage})
    m->resize(rows(t.motors), samples);
  t.force_x.setZero(rows(t.feet), samples);
  t.force_z.setZero(rows(t.feet), samples);
}

void put_sample(const components::Equations& equations, const SamplePoint& s, int k,
                trajectory::Trajectory& t) {
  const dynamics::AbsoluteTree& tree = equations.tree();
  const components::EquationsPoint& p = *s.point;
  t.time[k] = s.time;
  t.position.col(k) = p.q;
  t.velocity.col(k) = p.v;
  t.acceleration.col(k) = p.a;
  t.joint_position.col(k) =
      dynamics::joint_positions(tree, p.q, p.motion).tail(t.joint_position.rows());
  t.joint_velocity.col(k) =
      dynamics::joint_velocities(tree, p.v, p.motion).tail(t.joint_velocity.rows());

  for (int m = 0; m < t.torque.rows(); ++m) {
    const model::PlanarMotor& motor = equations.model().motors[m];
    const double rate = t.joint_velocity(motor.body - 1, k);
    const double torque = (*s.input)[m] + components::against_dry_friction(motor, rate).value;
    t.torque(m, k) = torque;
    t.motor_torque(m, k) = torque / (motor.gear * motor.efficiency);
    t.current(m, k) = components::motor_current(motor, torque);
    t.voltage(m, k) = components::motor_voltage(motor, torque, rate).value;
  }

  for (int i = 0; i < count_of(p.feet); ++i) {
    t.force_x(p.feet[i], k) = p.force[2 * i];
    t.force_z(p.feet[i], k) = p.force[2 * i + 1];
  }
}

}  // namespace

trajectory::Trajectory to_trajectory(NonlinearProgram& program, const ConstVectorRef& x) {
  trajectory::Trajectory t;
  name_channels(program.equations().model(), t);
  t.input_hold = program.layout().held ? "held" : "linear";
  if (!program.evaluate_at(x)) return t;

  std::vector<SamplePoint> samples;
  double start = 0.0;
  for (const PhaseBlock& phase : program.layout().phases) {
    trajectory::PhaseSpan span{phase.name, {}, count_of(samples), 0};
    for (int foot : phase.feet) span.contacts.push_back(t.feet[foot]);

    double begin = start;
    for (int k = phase.first_interval; k <= phase.last_interval; ++k) {
      const Interval& interval = program.intervals()[k];
      t.interval_start.push_back(count_of(samples));
      samples.push_back({&interval.point(0), &interval.input(0), begin});
      if (interval.has_middle())
        samples.push_back(
            {&interval.point(1), &interval.input(1), begin + 0.5 * interval.length()});
      begin += interval.length();
      if (k == phase.last_interval)
        samples.push_back({&interval.point(2), &interval.input(2), begin});
    }

    start = begin;
    span.last = count_of(samples) - 1;
    t.phases.push_back(span);
  }

  resize(t, count_of(samples));
  for (int k = 0; k < count_of(samples); ++k) put_sample(program.equations(), samples[k], k, t);
  return t;
}

}  // namespace jaculus::transcription
