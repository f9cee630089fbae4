#include "simulation/integrate/recorder.h"

namespace jaculus::simulation::detail {

Recorder::Recorder(const PlantEquations& equations, const Vector& sample_times, Sampled sampled)
    : sampled_(sampled) {
  const auto samples = sample_times.size();
  const int n = equations.model_size(), motors = count_of(equations.motors());
  out_.time = sample_times;
  out_.q.resize(n, samples);
  out_.v.resize(n, samples);
  out_.motor_position.resize(motors, samples);
  out_.motor_velocity.resize(motors, samples);

  for (Matrix* m : {&out_.torque, &out_.current, &out_.voltage})
    m->setConstant(motors, samples, kNaN);
  out_.bus_voltage.setConstant(samples, kNaN);
  out_.force.setConstant(2 * count_of(equations.plant().model.feet), samples, kNaN);
}

double Recorder::next() const {
  return sample_ < out_.time.size() ? out_.time[sample_] : kInfinity;
}

void Recorder::record_motion(const PlantEquations& equations, const State& y) {
  for (int i = 0; i < equations.model_size(); ++i) {
    out_.q(i, sample_) = y[i];
    out_.v(i, sample_) = y[equations.size() + i];
  }
  for (int m = 0; m < count_of(equations.motors()); ++m) {
    out_.motor_position(m, sample_) = equations.motor_position(m, y);
    out_.motor_velocity(m, sample_) = equations.motor_velocity(m, y);
  }
}

void Recorder::record_motors(const std::vector<MotorState>& motors, double bus) {
  for (int m = 0; m < count_of(motors); ++m) {
    out_.torque(m, sample_) = motors[m].torque;
    out_.current(m, sample_) = motors[m].current;
    out_.voltage(m, sample_) = motors[m].voltage;
  }
  out_.bus_voltage[sample_] = bus;
}

void Recorder::record(const PlantEquations& equations, const State& y, const Evaluation* at) {
  record_motion(equations, y);
  if (at != nullptr && sampled_ != Sampled::motion) record_motors(equations.motors(), at->bus);

  if (at != nullptr && sampled_ == Sampled::all) {
    out_.force.col(sample_).setZero();
    for (int i = 0; i < count_of(equations.unilaterals()); ++i) {
      const int foot = equations.unilaterals()[i].foot;
      if (foot < 0) continue;
      out_.force(2 * foot, sample_) = at->lambda[2 * i];
      out_.force(2 * foot + 1, sample_) = at->lambda[2 * i + 1];
    }
  }
  ++sample_;
}

void Recorder::record(const PlantEquations& equations, const State& y, const DriveSample& drive) {
  record_motion(equations, y);
  record_motors(drive.motors, drive.bus);
  ++sample_;
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
