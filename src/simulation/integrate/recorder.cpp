#include "simulation/integrate/recorder.h"

namespace jaculus::simulation::detail {

Recorder::Recorder(const PlantEquations& equations, const Vector& sample_times) {
  const auto samples = sample_times.size();
  const int n = equations.model_size(), motors = count_of(equations.motors());
  out_.time = sample_times;
  out_.q.resize(n, samples);
  out_.v.resize(n, samples);

  for (Matrix* m :
       {&out_.motor_position, &out_.motor_velocity, &out_.torque, &out_.current, &out_.voltage})
    m->resize(motors, samples);
  out_.bus_voltage.resize(samples);
  out_.force.setZero(2 * count_of(equations.plant().model.feet), samples);
}

double Recorder::next() const {
  return sample_ < out_.time.size() ? out_.time[sample_] : kInfinity;
}

void Recorder::record(const PlantEquations& equations, const State& y, const Evaluation* at) {
  const Eigen::Index k = sample_++;
  for (int i = 0; i < equations.model_size(); ++i) {
    out_.q(i, k) = y[i];
    out_.v(i, k) = y[equations.size() + i];
  }
  for (int m = 0; m < count_of(equations.motors()); ++m) {
    out_.motor_position(m, k) = equations.motor_position(m, y);
    out_.motor_velocity(m, k) = equations.motor_velocity(m, y);
  }
  if (at == nullptr) {
    for (Matrix* m : {&out_.torque, &out_.current, &out_.voltage, &out_.force})
      m->col(k).setConstant(kNaN);
    out_.bus_voltage[k] = kNaN;
    return;
  }

  for (int m = 0; m < count_of(equations.motors()); ++m) {
    const MotorState& motor = equations.motors()[m];
    out_.torque(m, k) = motor.torque;
    out_.current(m, k) = motor.current;
    out_.voltage(m, k) = motor.voltage;
  }
  out_.bus_voltage[k] = at->bus;

  for (int i = 0; i < count_of(equations.unilaterals()); ++i) {
    const int foot = equations.unilaterals()[i].foot;
    if (foot < 0) continue;
    out_.force(2 * foot, k) = at->lambda[2 * i];
    out_.force(2 * foot + 1, k) = at->lambda[2 * i + 1];
  }
}

Simulation Recorder::take() {
  out_.time.conservativeResize(sample_);
  for (Matrix* m : {&out_.q, &out_.v, &out_.motor_position, &out_.motor_velocity, &out_.torque,
                    &out_.current, &out_.voltage, &out_.force})
    m->conservativeResize(Eigen::NoChange, sample_);
  out_.bus_voltage.conservativeResize(sample_);
  return std::move(out_);
}

}  // namespace jaculus::simulation::detail
