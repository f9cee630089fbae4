#include "experiments.h"

#include <cmath>
#include <complex>
#include <numbers>

#include "jaculus/core/installation.h"
#include "jaculus/model/robot.h"
#include "support/shared_data.h"

namespace jaculus::test {
namespace {

using trajectory::ExperimentKind;

constexpr double kMocapRate = 120.0, kEncoderRate = 500.0;  // [Hz]
constexpr double kMocapNoise = 0.3e-3, kMocapAngleNoise = 0.15 * std::numbers::pi / 180.0,
                 kEncoderNoise = 1e-3;

/// An experiment on a robot of which `held` holds parts.
Experiment with_robot(ExperimentKind kind, const std::string& robot,
                      std::function<model::PlanarModel(const model::PlanarModel&)> held) {
  Experiment e;
  e.kind = kind;
  e.robot = robot;
  e.held = std::move(held);
  e.plant = simulation::nominal_plant(with_values(e, {}));
  return e;
}

model::PlanarModel whole(const model::PlanarModel& model) { return model; }

Vector grid(double duration, double rate) {
  const auto count = static_cast<Eigen::Index>(std::floor(duration * rate + 1e-9)) + 1;
  return Vector::LinSpaced(count, 0.0, static_cast<double>(count - 1) / rate);
}

void set_duration(Experiment& e, double duration) {
  e.options.duration = duration;
  e.options.sample_times = grid(duration, 2000.0);
  e.options.relative_tolerance = 1e-8;
  e.options.absolute_tolerance = 1e-10;
}

simulation::StartState at_rest(const model::PlanarModel& model) {
  return {Vector::Zero(model.size()), Vector::Zero(model.size())};
}

/// The tailed robot's legs held at a pose, so that only base and tail are left.
model::PlanarModel legs_held(const model::PlanarModel& whole_model) {
  model::PlanarModel model = whole_model;
  for (const char* c : {"front_extension", "rear_extension"}) model = model::lock(model, c, 1.0);
  for (const char* c : {"front_angle", "rear_angle"}) model = model::lock(model, c, 0.0);
  return model;
}

/// A script for the robot's motors: a row each.
simulation::Controller script(const model::PlanarModel& model, trajectory::Quantity quantity,
                              const Vector& time, const Matrix& value) {
  simulation::Controller controller;
  controller.quantity = quantity;
  controller.reference.time = time;
  for (const model::PlanarMotor& motor : model.motors)
    controller.reference.motors.push_back(motor.joint);
  controller.reference.feedforward = value;
  controller.reference.duration = time[time.size() - 1];
  controller.kp = controller.kd = Vector::Zero(value.rows());
  controller.after_end = simulation::AfterEnd::repeat;
  return controller;
}

Experiment leap(const std::filesystem::path& data) {
  Experiment e = with_robot(ExperimentKind::leap, "models/minitaur_tail", whole);
  const model::PlanarModel& model = e.plant.model;
  const auto file = data / "plans" / "aerotail_V7_nodes82.csv";
  e.controller.quantity = trajectory::Quantity::duty;
  e.controller.reference = simulation::plan_reference(trajectory::read_csv(file), model,
                                                      e.controller.quantity, 7.0, file);
  e.controller.reference.feedforward *= 7.0 / 16.0;  // the plan's duty is of its own 7 V
  // February's gains.
  e.controller.kp = Vector::Constant(5, 0.4);
  e.controller.kd = Vector::Constant(5, 0.01);
  e.controller.kp[4] = 1.0;
  e.stands = true;
  set_duration(e, 0.19);
  return e;
}

Experiment falling() {
  Experiment e = with_robot(ExperimentKind::self_righting, "models/minitaur_tail", legs_held);
  const model::PlanarModel& model = e.plant.model;
  e.plant.stops.push_back({"tail", {-0.5 * std::numbers::pi, 0.5 * std::numbers::pi}, 0.0});
  e.start = at_rest(model);
  e.start.q[model.coordinate_index("z")] = 2.0;
  e.start.q[model.coordinate_index("tail")] = -0.5 * std::numbers::pi;
  e.controller = script(model, trajectory::Quantity::duty, Vector::LinSpaced(2, 0.0, 0.32),
                        Matrix::Constant(1, 2, 1.0));
  set_duration(e, 0.32);
  return e;
}

Experiment bench() {
  Experiment e = with_robot(
      ExperimentKind::tail_bench, "models/minitaur_tail", [](const model::PlanarModel& model) {
        return model::lock(model::lock(model::lock(legs_held(model), "x", 0.0), "z", 1.0), "pitch",
                           0.0);
      });
  const model::PlanarModel& model = e.plant.model;
  e.start = at_rest(model);
  const Vector time = grid(1.0, 200.0);
  const Vector duty = (0.3 * (2.0 * std::numbers::pi * 2.0 * time.array()).cos() +
                       0.2 * (2.0 * std::numbers::pi * 5.3 * time.array()).cos());
  e.controller = script(model, trajectory::Quantity::duty, time, duty.transpose());
  set_duration(e, 1.0);
  return e;
}

Experiment pendulum() {
  Experiment e = with_robot(ExperimentKind::pendulum, "models/ak80_pendulum", whole);
  const model::PlanarModel& model = e.plant.model;
  e.start = at_rest(model);
  const Vector time = grid(2.0, 200.0);
  const Vector torque = 1.2 * (2.0 * std::numbers::pi * 0.9 * time.array()).sin();
  e.controller = script(model, trajectory::Quantity::torque, time, torque.transpose());
  e.controller.reference.position = Matrix::Zero(1, time.size());
  e.controller.reference.velocity = Matrix::Zero(1, time.size());
  e.controller.kp = Vector::Constant(1, 0.5);
  e.controller.kd = Vector::Constant(1, 0.02);
  set_duration(e, 2.0);
  return e;
}

/// Both motors to and fro at rates of their own, held so firmly about hanging down that the motion
/// stays a regular one.
Experiment double_pendulum() {
  Experiment e = with_robot(ExperimentKind::pendulum, "tests/effects/double_pendulum", whole);
  const model::PlanarModel& model = e.plant.model;
  e.start = at_rest(model);

  const Vector time = grid(1.0, 200.0);
  Matrix torque(2, time.size());
  torque.row(0) = 1.2 * (2.0 * std::numbers::pi * 1.1 * time.array()).sin();
  torque.row(1) = 0.5 * (2.0 * std::numbers::pi * 2.3 * time.array()).sin();
  e.controller = script(model, trajectory::Quantity::torque, time, torque);
  e.controller.reference.position = Matrix::Zero(2, time.size());
  e.controller.reference.velocity = Matrix::Zero(2, time.size());
  e.controller.kp = Vector::Constant(2, 2.0);
  e.controller.kd = Vector::Constant(2, 0.1);
  set_duration(e, 1.0);
  return e;
}

double entry(const std::map<std::string, double>& values, const std::string& key, double missing) {
  const auto found = values.find(key);
  return found == values.end() ? missing : found->second;
}

/// Samples of a row as a sensor shows them: late by its latency, scaled, offset; before the start
/// the first value.
Shown show(const std::string& channel, const std::string& stream, const Eigen::RowVectorXd& row,
           const Vector& time, const Vector& stamps, const simulation::Sensing& sensing,
           double noise) {
  Shown shown{channel, Vector(stamps.size()), noise};
  const double latency = entry(sensing.latency, stream, 0.0), step = time[1] - time[0];
  for (Eigen::Index i = 0; i < stamps.size(); ++i) {
    const double at =
        std::clamp((stamps[i] - latency) / step, 0.0, static_cast<double>(time.size() - 1));
    const auto k = std::min(static_cast<Eigen::Index>(at), time.size() - 2);
    const double share = at - static_cast<double>(k);
    const double value = (1.0 - share) * row[k] + share * row[k + 1];
    shown.values[i] =
        entry(sensing.scale, channel, 1.0) * value + entry(sensing.offset, channel, 0.0);
  }
  return shown;
}

/// x or z of what motion capture tracks, on axes as they are tilted: x - i z turns with the pitch.
Eigen::RowVectorXd tracked(const simulation::Plant& plant, const simulation::Simulation& run,
                           const std::string& channel) {
  const auto row = [&](const std::string& name, Eigen::Index k) {
    const int c = plant.model.coordinate_index(name);
    return c < 0 ? 0.0 : run.q(c, k);
  };
  const simulation::Sensing& sensing = plant.sensing;
  const std::complex<double> point(sensing.tracked_point.x(), -sensing.tracked_point.y());
  Eigen::RowVectorXd values(run.time.size());
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const std::complex<double> base(row("x", k), -row("z", k));
    const std::complex<double> seen =
        std::polar(1.0, -sensing.mocap_tilt) * (base + std::polar(1.0, row("pitch", k)) * point);
    values[k] = channel == "x" ? seen.real() : -seen.imag();
  }
  return values;
}

}  // namespace

const std::vector<Experiment>& experiments() {
  static const std::vector<Experiment> all = [] {
    std::vector<Experiment> list;
    if (std::filesystem::is_directory(shared_data())) list.push_back(leap(shared_data()));
    list.push_back(falling());
    list.push_back(bench());
    list.push_back(pendulum());
    return list;
  }();
  return all;
}

const model::PlanarModel& tailed() {
  static const model::PlanarModel model =
      model::read_robot(source_folder() / "models" / "minitaur_tail").planar;
  return model;
}

const Experiment& two_joints() {
  static const Experiment experiment = double_pendulum();
  return experiment;
}

model::PlanarModel with_values(const Experiment& experiment,
                               const std::vector<effects::ModelOverride>& values) {
  std::vector<model::Override> overrides;
  for (const auto& [path, text] : values)
    overrides.push_back({path, yaml::Node::parse("value: " + text, path).at("value")});
  const auto folder = source_folder() / experiment.robot;
  return experiment.held(model::read_robot(folder, overrides).planar);
}

std::optional<std::vector<Shown>> measure(const Experiment& experiment,
                                          const simulation::Plant& plant, std::string& why) {
  const simulation::Simulation run = simulation::simulate(
      plant, experiment.controller,
      experiment.stands ? simulation::reference_start(plant, experiment.controller.reference)
                        : experiment.start,
      experiment.options);
  if (run.status != simulation::SimulationStatus::done) {
    why = std::string(simulation::status_name(run.status)) + ": " + run.message;
    return std::nullopt;
  }
  std::vector<Shown> shown;
  const Vector mocap = grid(experiment.options.duration, kMocapRate);
  const Vector encoders = grid(experiment.options.duration, kEncoderRate);
  for (const char* channel : {"x", "z", "pitch"}) {
    const int c = plant.model.coordinate_index(channel);
    if (c < 0) continue;
    const bool angle = std::string(channel) == "pitch";
    const Eigen::RowVectorXd row = angle ? run.q.row(c) : tracked(plant, run, channel);
    shown.push_back(show(channel, "mocap", row, run.time, mocap, plant.sensing,
                         angle ? kMocapAngleNoise : kMocapNoise));
  }
  for (Eigen::Index m = 0; m < run.motor_position.rows(); ++m) {
    const std::string& joint = plant.model.motors[m].joint;
    shown.push_back(show(joint, "joints", run.motor_position.row(m), run.time, encoders,
                         plant.sensing, kEncoderNoise));
  }
  return shown;
}

std::optional<Vector> measured_in_noise(const Experiment& experiment,
                                        const simulation::Plant& plant, std::string& why) {
  const auto shown = measure(experiment, plant, why);
  if (!shown) return std::nullopt;
  Eigen::Index size = 0;
  for (const Shown& s : *shown) size += s.values.size();
  Vector all(size);
  size = 0;
  for (const Shown& s : *shown) {
    all.segment(size, s.values.size()) = s.values / s.noise;
    size += s.values.size();
  }
  return all;
}

}  // namespace jaculus::test
