#include "jaculus/simulation/experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/error.h"
#include "jaculus/core/tasks.h"
#include "simulation/channel_values.h"

namespace jaculus {
namespace {

constexpr double kTruthStep = 5e-4;

/// Normal and uniform numbers that are the same wherever the program runs.
class Random {
 public:
  explicit Random(std::uint64_t seed) : seed_(seed) {}

  double uniform() { return static_cast<double>(task_seed(seed_, ++count_) >> 11) * 0x1.0p-53; }
  double normal() {  // Box and Muller
    const double r = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return r * std::cos(6.283185307179586 * uniform());
  }
  double draw(const Spread& spread) {
    if (spread.range) return spread.range->lower + uniform() * (spread.range->upper - spread.range->lower);
    return spread.deviation == 0.0 ? 0.0 : spread.deviation * normal();
  }

 private:
  std::uint64_t seed_, count_ = 0;
};

std::string unit_of(const PlanarModel& model, const std::string& name) {
  const auto linear = [&model](const std::string& coordinate) {
    const int i = model.coordinate_index(coordinate);
    return i >= 0 && !model.coordinates[static_cast<std::size_t>(i)].angular;
  };
  for (const auto& [suffix, unit] :
       {std::pair("_torque", "N m"), std::pair("_current", "A"), std::pair("_voltage", "V"), std::pair("_duty", "-")})
    if (name.ends_with(suffix)) return unit;
  if (name.ends_with("_velocity")) return linear(name.substr(0, name.size() - 9)) ? "m/s" : "rad/s";
  return linear(name) ? "m" : "rad";
}

class Sensor {
 public:
  Sensor(const Experiment& experiment, const Plant& plant, const Simulation& truth, std::uint64_t seed)
      : experiment_(experiment), plant_(plant), truth_(truth), seed_(seed) {}

  Stream read(const SensorStream& spec, std::uint64_t index) const {
    Random random(task_seed(seed_, 100 + index));
    const double late = random.draw(spec.time_shift) + value_or(plant_.sensing.latency, spec.name, 0.0);
    Stream stream;
    stream.name = spec.name;
    stream.rate_hz = spec.rate_hz;
    const double end = std::min(experiment_.duration, truth_.end_time);
    const auto first = static_cast<Eigen::Index>(std::ceil(-experiment_.lead * spec.rate_hz - 1e-6));
    const auto last = static_cast<Eigen::Index>(std::floor(end * spec.rate_hz + 1e-6));
    stream.time.resize(std::max<Eigen::Index>(1, last - first + 1));
    for (Eigen::Index k = 0; k < stream.time.size(); ++k)
      stream.time[k] = static_cast<double>(first + k) / spec.rate_hz;
    stream.channels = spec.channels;
    stream.values.resize(static_cast<Eigen::Index>(spec.channels.size()), stream.time.size());
    for (std::size_t c = 0; c < spec.channels.size(); ++c) {
      stream.units.push_back(unit_of(plant_.model, spec.channels[c]));
      stream.values.row(static_cast<Eigen::Index>(c)) = channel(spec, spec.channels[c], stream.time, late, random);
    }
    drop(spec, random, stream);
    return stream;
  }

 private:
  [[nodiscard]] Eigen::RowVectorXd channel(const SensorStream& spec, const std::string& name, const Vector& stamps,
                                           double late, Random& random) const {
    const Eigen::RowVectorXd raw = raw_channel(plant_.model, truth_, name);
    const double zero = spec.name == "mocap" && (name == "x" || name == "pitch") ? raw[0] : 0.0;
    const double scale = value_or(plant_.sensing.scale, name, 1.0);
    const double offset = value_or(plant_.sensing.offset, name, 0.0);
    const double noise = value_or(spec.noise, name, 0.0);
    Eigen::RowVectorXd out(stamps.size());
    for (Eigen::Index k = 0; k < stamps.size(); ++k) {
      out[k] = scale * (interpolate(raw, kTruthStep, stamps[k] - late) - zero) + offset;
      if (noise > 0.0) out[k] += noise * random.normal();
    }
    return out;
  }

  /// Gaps of geometric length, `dropout` of all samples on average.
  static void drop(const SensorStream& spec, Random& random, Stream& stream) {
    if (spec.dropout <= 0.0) return;
    const double stop = 1.0 / spec.dropout_length;
    const double begin = std::min(1.0, stop * spec.dropout / (1.0 - spec.dropout));
    bool lost = false;
    for (Eigen::Index k = 0; k < stream.time.size(); ++k) {
      const double u = random.uniform();
      lost = lost ? u >= stop : u < begin;
      if (lost) stream.values.col(k).setConstant(kNaN);
    }
  }

  const Experiment& experiment_;
  const Plant& plant_;
  const Simulation& truth_;
  std::uint64_t seed_;
};

/// The start with scattered coordinates, feet lowered to the floor again.
StartState scattered_start(const Experiment& experiment, const Plant& plant, const Controller& controller,
                           Random& random) {
  StartState start = reference_start(plant, controller.reference);
  if (experiment.scatter.empty()) return start;
  Reference reference = controller.reference;
  reference.initial.clear();
  for (int i = 0; i < plant.model.size(); ++i) {
    const std::string& name = plant.model.coordinates[static_cast<std::size_t>(i)].name;
    reference.initial[name] = start.q[i];
    if (const auto spread = experiment.scatter.find(name); spread != experiment.scatter.end())
      reference.initial[name] += random.draw(spread->second);
  }
  return reference_start(plant, reference);
}

}  // namespace

double command_duration(const Dataset& dataset) {
  if (dataset.plan) return dataset.plan->values(dataset.plan->values.rows() - 1, dataset.plan->column("time"));
  return dataset.script->time[dataset.script->time.size() - 1];
}

Robot dataset_robot(const Dataset& dataset) {
  std::vector<Override> overrides;
  const std::string place = (dataset.folder / "override").string();
  for (const auto& [path, text] : dataset.overrides) overrides.push_back({path, yaml::Node::parse(text, place)});
  Robot robot = read_robot(find_robot(dataset.robot, dataset.folder), overrides);
  if (dataset.experiment != "tail_bench") return robot;
  std::vector<std::string> commanded;
  if (dataset.script) commanded = dataset.script->joints;
  if (!dataset.script) commanded = {"tail"};
  for (const Coordinate& c : std::vector<Coordinate>(robot.planar.coordinates)) {
    if (std::find(commanded.begin(), commanded.end(), c.name) != commanded.end()) continue;
    const double middle = std::isfinite(c.range.lower + c.range.upper) ? 0.5 * (c.range.lower + c.range.upper) : 0.0;
    robot.planar = lock(robot.planar, c.name, value_or(dataset.initial, c.name, c.name == "z" ? 1.0 : middle));
  }
  robot.notes.emplace_back("tail bench: the base and every coordinate without a command are held");
  return robot;
}

Plant dataset_plant(const Dataset& dataset, const PlanarModel& model) {
  Plant plant = nominal_plant(model);
  for (const auto& [joint, stop] : dataset.stops) {
    if (model.body_of_joint(joint) < 0) {
      std::vector<std::string> joints;
      for (const PlanarBody& body : model.bodies)
        if (!body.joint.empty()) joints.push_back(body.joint);
      const auto near = yaml::nearest_name(joint, joints);
      throw InputError(fmt::format("stops: '{}' is no joint of this robot{}", joint,
                                   near ? fmt::format(", did you mean '{}'?", *near) : ""));
    }
    plant.stops.push_back({joint, stop.range, stop.restitution});
  }
  return plant;
}

Controller experiment_controller(const Experiment& experiment, const PlanarModel& model) {
  const StatedController& stated = experiment.setup.controller;
  if (!stated.gains_stated)
    throw InputError(
        fmt::format("{}: controller: kp and kd are missing; a simulation needs them as numbers", experiment.name));
  for (const auto* gains : {&stated.kp, &stated.kd}) {
    for (const auto& [joint, gain] : *gains) {
      if (!gain.known())
        throw InputError(fmt::format("{}: controller: {}.{}: unknown or a range; a simulation needs a number",
                                     experiment.name, gains == &stated.kp ? "kp" : "kd", joint));
    }
  }
  Dataset setup = experiment.setup;
  if (setup.experiment == "tail_bench") {
    // What is held has left the model; only what remains can be set.
    std::erase_if(setup.initial, [&](const auto& entry) {
      return model.coordinate_index(entry.first) < 0 &&
             dataset_robot(experiment.setup).planar.body_of_joint(entry.first) < 0;
    });
  }
  if (setup.plan && !experiment.plan_file.empty())  // names the file; a dataset's plan is always plan.csv
    (void)plan_reference(*setup.plan, model,
                         stated.quantity == "duty"      ? CommandQuantity::duty
                         : stated.quantity == "voltage" ? CommandQuantity::voltage
                                                        : CommandQuantity::torque,
                         1.0, experiment.plan_file);
  return stated_controller(setup, model, {});
}

TrialRun run_trial(const Experiment& experiment, const Plant& plant, const Controller& controller, int index,
                   std::uint64_t seed) {
  const std::uint64_t own = task_seed(seed, static_cast<std::uint64_t>(index));
  Random random(own);
  TrialRun run;
  run.start = scattered_start(experiment, plant, controller, random);
  SimulationOptions options;
  const auto steps = static_cast<Eigen::Index>(std::ceil(experiment.duration / kTruthStep));
  options.sample_times = Vector::LinSpaced(steps + 1, 0.0, static_cast<double>(steps) * kTruthStep);
  options.duration = options.sample_times[steps];
  run.truth = simulate(plant, controller, run.start, options);
  run.trial.name = fmt::format("trial_{:02}", index + 1);
  if (run.truth.time.size() == 0) return run;
  const Sensor sensor(experiment, plant, run.truth, own);
  for (std::size_t i = 0; i < experiment.streams.size(); ++i)
    run.trial.streams.push_back(sensor.read(experiment.streams[i], i));
  return run;
}

}  // namespace jaculus
