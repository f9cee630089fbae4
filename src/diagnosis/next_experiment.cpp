#include "jaculus/diagnosis/next_experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>

#include "diagnosis/posed.h"
#include "jaculus/core/error.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus {
namespace {

constexpr int kTrials = 4;
constexpr double kTelling = 1.0;  // expected log Bayes factor from which an experiment is worth naming
constexpr double kMocapRate = 240.0, kJointsRate = 1000.0;  // Hz
// Noise of channels that the present data lack: m, rad of motion capture; rad and rad/s of encoders.
constexpr double kPlace = 3e-4, kPitch = 0.15 * std::numbers::pi / 180.0, kEncoder = 1e-3, kTachometer = 0.1;
constexpr double kFall = 1.5;       // m, from which the drop begins
constexpr double kDropTime = 0.32;  // s, one body length

struct Proposal {
  std::string name;
  Experiment experiment;
};

/// Noise of a channel as the present data show it, else `usual`.
double noise_of(const DiagnosisProblem& problem, const std::string& channel, double usual) {
  for (const Condition& condition : problem.observations.conditions)
    for (const Channel& own : condition.channels)
      if (own.name == channel) return own.noise_floor;
  return usual;
}

SensorStream encoders(const DiagnosisProblem& problem, const std::vector<std::string>& joints) {
  SensorStream stream;
  stream.name = "joints";
  stream.rate_hz = kJointsRate;
  for (const std::string& joint : joints) {
    stream.channels.push_back(joint);
    stream.noise[joint] = noise_of(problem, joint, kEncoder);
    stream.channels.push_back(joint + "_velocity");
    stream.noise[joint + "_velocity"] = noise_of(problem, joint + "_velocity", kTachometer);
  }
  return stream;
}

SensorStream motion_capture(const DiagnosisProblem& problem) {
  SensorStream stream;
  stream.name = "mocap";
  stream.rate_hz = kMocapRate;
  stream.channels = {"x", "z", "pitch"};
  stream.noise = {{"x", noise_of(problem, "x", kPlace)},
                  {"z", noise_of(problem, "z", kPlace)},
                  {"pitch", noise_of(problem, "pitch", kPitch)}};
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

Experiment begin(const Dataset& present) {
  Experiment experiment;
  experiment.setup = present;
  experiment.setup.trials.clear();
  experiment.trials = kTrials;
  experiment.duration = command_duration(present);
  return experiment;
}

Proposal again(const Dataset& present, const DiagnosisProblem& problem, const PlanarModel& model) {
  Proposal proposal{fmt::format("{} as now, {} more trials", present.experiment, kTrials), begin(present)};
  if (model.coordinate_index("x") >= 0) proposal.experiment.streams.push_back(motion_capture(problem));
  proposal.experiment.streams.push_back(encoders(problem, motor_joints(model)));
  return proposal;
}

/// The same plan by the other quantity, gains as the same stiffness at stall.
Proposal switched(const Dataset& present, const DiagnosisProblem& problem, const PlanarModel& model) {
  const bool by_torque = present.controller.quantity == "torque";
  const std::string other = by_torque ? "duty" : "torque";
  Proposal proposal = again(present, problem, model);
  proposal.name = present.experiment + " by " + other + " instead of " + present.controller.quantity;
  StatedController& controller = proposal.experiment.setup.controller;
  controller.quantity = other;
  for (const PlanarMotor& motor : model.motors) {
    if (!present.plan || present.plan->column(motor.joint + "_" + other) < 0)
      throw InputError("the plan has no " + other + " for " + motor.joint);
    const double stall = motor.torque_constant * motor.voltage / motor.resistance;
    for (auto* gains : {&controller.kp, &controller.kd}) {
      auto found = gains->find(motor.joint);
      if (found == gains->end() && gains->contains("*")) found = gains->emplace(motor.joint, gains->at("*")).first;
      if (found == gains->end()) continue;
      const double factor = by_torque ? 1.0 / stall : stall;
      found->second.range = {found->second.range.lower * factor, found->second.range.upper * factor};
    }
  }
  return proposal;
}

/// Half the battery to and fro on the tail, base held.
Proposal bench(const Dataset& present, const DiagnosisProblem& problem, const PlanarMotor& tail) {
  Proposal proposal{"tail_bench: base held, " + tail.joint + " to and fro at half the battery's voltage",
                    begin(present)};
  Dataset& setup = proposal.experiment.setup;
  setup.experiment = "tail_bench";
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
  setup.controller.kind = setup.controller.quantity = "voltage";
  setup.controller.bus_voltage = tail.voltage;
  proposal.experiment.duration = 0.5;
  proposal.experiment.streams = {encoders(problem, {tail.joint})};
  return proposal;
}

/// Full command on the tail from straight back, legs held as the present controller holds them.
Proposal drop(const Dataset& present, const DiagnosisProblem& problem, const PlanarModel& model,
              const PlanarMotor& tail) {
  Proposal proposal{fmt::format("self_righting: drop from {} m, full command on {}", kFall, tail.joint),
                    begin(present)};
  Dataset& setup = proposal.experiment.setup;
  const double back = -0.5 * std::numbers::pi;
  setup.experiment = "self_righting";
  setup.script.reset();
  setup.initial = {{"x", 0.0}, {"z", kFall}, {"pitch", 0.0}};
  setup.stops = {{tail.joint, {{back, -back}, 0.0}}};
  setup.controller.quantity = present.controller.quantity;
  setup.controller.after_end = "repeat";
  setup.controller.kp[tail.joint] = setup.controller.kd[tail.joint] = {{0.0, 0.0}};
  const std::string& quantity = setup.controller.quantity;
  Table plan;
  plan.columns.push_back({"time", "s"});
  std::vector<double> pose{0.0};
  for (const PlanarMotor& motor : model.motors) {
    const bool is_tail = motor.joint == tail.joint;
    const int column = present.plan ? present.plan->column(motor.joint) : -1;
    if (!is_tail && column < 0) throw InputError("the present plan gives no pose for " + motor.joint);
    const double full =
        quantity == "torque" ? tail.torque_limit * tail.gear : (quantity == "duty" ? 1.0 : tail.voltage);
    plan.columns.insert(plan.columns.end(), {{motor.joint, "rad"},
                                             {motor.joint + "_velocity", "rad/s"},
                                             {motor.joint + "_" + quantity,
                                              quantity == "torque" ? "N m" : (quantity == "duty" ? "-" : "V")}});
    pose.insert(pose.end(), {is_tail ? back : present.plan->values(0, column), 0.0, is_tail ? full : 0.0});
  }
  plan.values.resize(2, static_cast<Eigen::Index>(pose.size()));
  plan.values.row(0) = plan.values.row(1) = Eigen::Map<const Eigen::RowVectorXd>(pose.data(), plan.values.cols());
  plan.values(1, 0) = kDropTime;
  setup.plan = plan;
  proposal.experiment.duration = kDropTime;
  proposal.experiment.streams = {motion_capture(problem), encoders(problem, motor_joints(model))};
  return proposal;
}

/// Trials of an experiment on the plant with a rival's effects; nothing where the plant is lost.
std::optional<Dataset> simulated(const Experiment& experiment, const Rival& rival) {
  const Robot robot = dataset_robot(experiment.setup);
  Plant plant = dataset_plant(experiment.setup, robot.planar);
  for (std::size_t i = 0; i < rival.effects.size(); ++i)
    if (rival.effects[i]->applies(robot.planar)) rival.effects[i]->apply(rival.theta[i], plant);
  const Controller controller = experiment_controller(experiment, robot.planar);
  Dataset dataset = experiment.setup;
  for (int k = 0; k < experiment.trials; ++k) {
    const TrialRun run = run_trial(experiment, plant, controller, k, 1);
    if (run.truth.status != SimulationStatus::done) return std::nullopt;
    dataset.trials.push_back(run.trial);
  }
  return dataset;
}

/// A rival's effects as candidates of a problem, its parameters set; effects that don't act there stay away.
FittedModel start_at(const DiagnosisProblem& problem, const Rival& rival) {
  FittedModel model{{}, problem.hypotheses.nominal()};
  for (std::size_t i = 0; i < rival.effects.size(); ++i) {
    const int c = problem.hypotheses.candidate(rival.effects[i]->name);
    if (c < 0) continue;
    model.candidates.push_back(c);
    const auto& own = problem.hypotheses.candidates[static_cast<std::size_t>(c)].parameters;
    for (std::size_t k = 0; k < own.size(); ++k) model.p[own[k]] = rival.theta[i][static_cast<Eigen::Index>(k)];
  }
  return model;
}

/// Mean over both rivals of the evidence for the one that made the data; NaN where one can't be simulated or fitted.
double expected_log_bayes_factor(const Experiment& experiment, const Rival& a, const Rival& b,
                                 const DiagnoseOptions& options) {
  double sum = 0.0;
  for (const bool first : {true, false}) {
    const Rival& truth = first ? a : b;
    const std::optional<Dataset> data = simulated(experiment, truth);
    if (!data) return kNaN;
    const std::vector<double> evidence = log_evidences({*data}, {truth, first ? b : a}, options);
    sum += evidence[0] - evidence[1];
  }
  return 0.5 * sum;
}

}  // namespace

std::vector<double> log_evidences(const std::vector<Dataset>& datasets, const std::vector<Rival>& rivals,
                                  const DiagnoseOptions& options) {
  DiagnoseOptions all = options;
  all.effects.clear();
  for (const Rival& rival : rivals)
    for (const Effect* effect : rival.effects)
      if (std::find(all.effects.begin(), all.effects.end(), effect) == all.effects.end()) all.effects.push_back(effect);
  std::vector<double> found(rivals.size(), kNaN);
  const Posed posed = pose(datasets, all);
  Diagnosis unused;
  Linearisation about;
  if (!posed.forward || !prepare(*posed.problem, about, options, unused)) return found;
  EvidenceSpace space = compare_in(*posed.problem, about, options);
  Linearisation there = linearise(*posed.problem, start_at(*posed.problem, rivals.front()).p);
  if (there.at_p.valid) space = evidence_space(*posed.problem, there);
  for (std::size_t r = 0; r < rivals.size(); ++r) {
    const FittedModel start = start_at(*posed.problem, rivals[r]);
    const Fit anew = fit_members(*posed.problem, space, about.p, start.candidates);
    const Fit from = fit_model(*posed.problem, space, posed.problem->hypotheses.freed_by(start.candidates), {start.p});
    for (const Fit* fit : {&anew, &from})
      if (fit->valid && !(fit->log_evidence < found[r])) found[r] = fit->log_evidence;
  }
  return found;
}

std::optional<NextExperiment> next_experiment(const Dataset& present, const DiagnosisProblem& problem, const Rival& a,
                                              const Rival& b, const DiagnoseOptions& options) {
  if (present.controller.kind == "measured" || (!present.plan && !present.script)) return std::nullopt;
  const PlanarModel model = dataset_robot(present).planar;
  const PlanarMotor* tail = tail_motor(model);
  std::vector<std::function<Proposal()>> makers{[&] { return again(present, problem, model); }};
  if (present.controller.kind == "feedforward_pd") makers.push_back([&] { return switched(present, problem, model); });
  if (tail != nullptr) {
    if (present.experiment != "tail_bench") makers.push_back([&] { return bench(present, problem, *tail); });
    if (present.experiment != "self_righting" && model.coordinate_index("z") >= 0)
      makers.push_back([&] { return drop(present, problem, model, *tail); });
  }
  std::optional<NextExperiment> best;
  for (const auto& make : makers) {
    try {
      const Proposal proposal = make();
      const double expected = expected_log_bayes_factor(proposal.experiment, a, b, options);
      if (expected >= kTelling && (!best || expected > best->log_bayes_factor)) best = {{proposal.name, expected}};
    } catch (const InputError&) {
      continue;  // the robot or its stated controller does not allow this experiment
    }
  }
  return best;
}

}  // namespace jaculus
