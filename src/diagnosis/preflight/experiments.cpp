#include "diagnosis/preflight/experiments.h"

#include <fmt/format.h>

#include <numbers>

#include "diagnosis/preflight/other_commands.h"
#include "jaculus/core/error.h"

namespace jaculus::diagnosis {
namespace {

using model::PlanarDrag;
using model::PlanarModel;
using model::PlanarMotor;
using simulation::Experiment;
using simulation::SensorStream;
using trajectory::ControllerKind;
using trajectory::Dataset;
using trajectory::ExperimentKind;
using trajectory::InputScript;
using trajectory::Quantity;
using trajectory::StatedController;
using trajectory::Table;

/// Noise of a channel as the present sensors have it, else `usual`.
double noise_of(const Experiment& present, const std::string& channel, double usual) {
  for (const SensorStream& stream : present.streams)
    if (const auto own = stream.noise.find(channel); own != stream.noise.end()) return own->second;
  return usual;
}

SensorStream encoders(const Experiment& present, const std::vector<std::string>& joints,
                      const Settings& settings) {
  SensorStream stream;
  stream.name = trajectory::kJointStream;
  stream.rate_hz = settings.new_encoder_rate;
  for (const std::string& joint : joints) {
    stream.channels.push_back(joint);
    stream.noise[joint] = noise_of(present, joint, settings.new_encoder_noise);
    const std::string rate = channel_name(joint, Quantity::velocity);
    stream.channels.push_back(rate);
    stream.noise[rate] = noise_of(present, rate, settings.new_rate_noise);
  }
  return stream;
}

SensorStream motion_capture(const Experiment& present, const Settings& settings) {
  SensorStream stream;
  stream.name = trajectory::kMocapStream;
  stream.rate_hz = settings.new_mocap_rate;
  stream.channels = {"x", "z", "pitch"};
  stream.noise = {{"x", noise_of(present, "x", settings.new_place_noise)},
                  {"z", noise_of(present, "z", settings.new_place_noise)},
                  {"pitch", noise_of(present, "pitch", settings.new_pitch_noise)}};
  return stream;
}

std::vector<std::string> motor_joints(const PlanarModel& model) {
  std::vector<std::string> joints;
  for (const PlanarMotor& motor : model.motors) joints.push_back(motor.joint);
  return joints;
}

/// The motor whose body carries drag; null where there is none.
const PlanarMotor* tail_motor(const PlanarModel& model) {
  for (const PlanarMotor& motor : model.motors)
    for (const PlanarDrag& drag : model.drags)
      if (drag.body == motor.body && drag.coefficient > 0.0) return &motor;
  return nullptr;
}

NamedExperiment again(const Experiment& present) {
  return {
      fmt::format("{} as now, {} more trials", name_of(present.setup.experiment), present.trials),
      present};
}

/// The same plan by the other quantity, gains as the same stiffness at stall.
NamedExperiment switched(const Experiment& present, const PlanarModel& model) {
  const Dataset& setup = present.setup;
  const bool by_torque = setup.controller.quantity == Quantity::torque;
  const Quantity other = by_torque ? Quantity::duty : Quantity::torque;
  NamedExperiment named{fmt::format("{} by {} instead of {}", name_of(setup.experiment),
                                    name_of(other), name_of(setup.controller.quantity)),
                        present};
  StatedController& controller = named.experiment.setup.controller;
  controller.quantity = other;

  for (const PlanarMotor& motor : model.motors) {
    if (!setup.plan || setup.plan->column(channel_name(motor.joint, other)) < 0)
      throw InputError(fmt::format("the plan has no {} for {}", name_of(other), motor.joint));
    const double stall = motor.torque_constant * motor.voltage / motor.resistance;
    for (auto* gains : {&controller.kp, &controller.kd}) {
      auto found = gains->find(motor.joint);
      if (found == gains->end() && gains->contains("*"))
        found = gains->emplace(motor.joint, gains->at("*")).first;
      if (found == gains->end()) continue;
      const double factor = by_torque ? 1.0 / stall : stall;
      found->second.range = {found->second.range.lower * factor,
                             found->second.range.upper * factor};
    }
  }

  return named;
}

/// Half the battery to and fro on the tail, base held.
NamedExperiment bench(const Experiment& present, const PlanarMotor& tail,
                      const Settings& settings) {
  NamedExperiment named{
      "tail_bench: base held, " + tail.joint + " to and fro at half the battery's voltage",
      present};
  Dataset& setup = named.experiment.setup;
  setup.experiment = ExperimentKind::tail_bench;
  setup.plan.reset();
  setup.stops.clear();
  setup.initial = {{tail.joint, 0.0}};
  InputScript script;
  script.joints = {tail.joint};
  script.time = Vector(6);
  script.time << 0.0, 0.05, 0.15, 0.25, 0.35, 0.4;
  const double half = 0.5 * tail.voltage;
  script.values = Matrix(1, 6);
  script.values << half, -half, half, -half, half, 0.0;
  setup.script = script;
  setup.controller = {};
  setup.controller.kind = ControllerKind::voltage;
  setup.controller.quantity = Quantity::voltage;
  setup.controller.bus_voltage = tail.voltage;
  named.experiment.plan_file.clear();
  named.experiment.duration = 0.5;
  named.experiment.streams = {encoders(present, {tail.joint}, settings)};

  return named;
}

/// Full command on the tail from straight back, legs held as the present controller holds them.
NamedExperiment drop(const Experiment& present, const PlanarModel& model, const PlanarMotor& tail,
                     const Settings& settings) {
  NamedExperiment named{fmt::format("self_righting: drop from {} m, full command on {}",
                                    settings.fall_height, tail.joint),
                        present};
  Dataset& setup = named.experiment.setup;
  const double back = -0.5 * std::numbers::pi;
  setup.experiment = ExperimentKind::self_righting;
  setup.script.reset();
  setup.initial = {{"x", 0.0}, {"z", settings.fall_height}, {"pitch", 0.0}};
  setup.stops = {{tail.joint, {{back, -back}, 0.0}}};
  setup.controller.after_end = trajectory::AfterEnd::repeat;
  setup.controller.kp[tail.joint] = setup.controller.kd[tail.joint] = {{0.0, 0.0}};
  const Quantity quantity = setup.controller.quantity;
  Table plan;
  plan.columns.push_back({"time", "s"});

  std::vector<double> row{0.0};
  for (const PlanarMotor& motor : model.motors) {
    const bool is_tail = motor.joint == tail.joint;
    const Dataset& now = present.setup;
    const int column = now.plan ? now.plan->column(motor.joint) : -1;
    if (!is_tail && column < 0)
      throw InputError("the present plan gives no pose for " + motor.joint);
    const double full = quantity == Quantity::torque
                            ? tail.torque_limit * tail.gear
                            : (quantity == Quantity::duty ? 1.0 : tail.voltage);
    plan.columns.insert(plan.columns.end(),
                        {{motor.joint, "rad"},
                         {channel_name(motor.joint, Quantity::velocity), "rad/s"},
                         {channel_name(motor.joint, quantity), unit_of(quantity)}});
    row.insert(row.end(),
               {is_tail ? back : now.plan->values(0, column), 0.0, is_tail ? full : 0.0});
  }

  plan.values.resize(2, count_of(row));
  plan.values.row(0) = plan.values.row(1) =
      Eigen::Map<const Eigen::RowVectorXd>(row.data(), plan.values.cols());
  plan.values(1, 0) = settings.fall_time;
  setup.plan = plan;
  named.experiment.duration = settings.fall_time;
  named.experiment.plan_file.clear();
  named.experiment.streams = {motion_capture(present, settings),
                              encoders(present, motor_joints(model), settings)};

  return named;
}

}  // namespace

Experiment present_experiment(const Dataset& present, const Problem& problem,
                              const NoiseModel& noise) {
  const Settings& settings = problem.settings;
  const PlanarModel model = simulation::dataset_robot(present).planar;
  Experiment experiment;
  experiment.setup = present;
  experiment.setup.trials.clear();
  experiment.trials = settings.simulated_trials;
  experiment.duration = simulation::command_duration(present);

  Experiment sensors;  // noise of every channel that the data have
  sensors.streams.resize(1);
  for (int d = 0; d < count_of(noise.datasets); ++d) {
    const std::vector<Channel>& channels = problem.observations.datasets[d].channels;
    for (int c = 0; c < count_of(channels); ++c)
      sensors.streams[0].noise.try_emplace(channels[c].name,
                                           noise.datasets[d].channels[c].noise_floor);
  }
  if (model.coordinate_index("x") >= 0)
    experiment.streams.push_back(motion_capture(sensors, settings));
  experiment.streams.push_back(encoders(sensors, motor_joints(model), settings));
  return experiment;
}

std::vector<ExperimentMaker> possible_experiments(const Experiment& present,
                                                  const Settings& settings) {
  const Dataset& setup = present.setup;
  const PlanarModel model = simulation::dataset_robot(setup).planar;
  std::vector<ExperimentMaker> makers{[present] { return again(present); }};
  if (setup.controller.kind == ControllerKind::feedforward_pd)
    makers.emplace_back([present, model] { return switched(present, model); });
  for (ExperimentMaker& maker : other_commands(present, model, settings))
    makers.push_back(std::move(maker));

  if (const PlanarMotor* tail = tail_motor(model)) {
    if (setup.experiment != ExperimentKind::tail_bench)
      makers.emplace_back(
          [present, tail = *tail, settings] { return bench(present, tail, settings); });
    if (setup.experiment != ExperimentKind::self_righting && model.coordinate_index("z") >= 0)
      makers.emplace_back([present, model, tail = *tail, settings] {
        return drop(present, model, tail, settings);
      });
  }
  return makers;
}

}  // namespace jaculus::diagnosis
