#include "jaculus/simulation/experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/error.h"
#include "jaculus/core/tasks.h"
#include "simulation/experiment/sensors.h"
#include "simulation/plant/named_values.h"

namespace jaculus::simulation {
namespace {

/// The start with scattered coordinates, feet lowered to the floor again.
StartState scattered_start(const Experiment& experiment, const Plant& plant,
                           const Controller& controller, Random& random) {
  Vector off = Vector::Zero(plant.model.size());
  for (int i = 0; i < plant.model.size(); ++i) {
    const auto spread = experiment.scatter.find(plant.model.coordinates[i].name);
    if (spread != experiment.scatter.end()) off[i] = random.draw(spread->second);
  }
  return reference_start(plant, controller.reference, off);
}

/// An override's value, for messages at the place where the dataset's file states it.
yaml::Node override_node(const trajectory::Dataset& dataset, const std::string& path,
                         const std::string& text) {
  const auto stated = dataset.override_places.find(path);
  if (stated == dataset.override_places.end())
    return yaml::Node::parse(text, (dataset.folder / "override").string());
  const InputPlace& place = stated->second;
  const std::string above(std::max(place.line - 1, 0), '\n');
  return yaml::Node::parse(
             fmt::format("{}{{override: {{{}: {}}}}}", above, yaml::quoted(path), text), place.file)
      .at("override")
      .at(path);
}

}  // namespace

double command_duration(const trajectory::Dataset& dataset) {
  if (dataset.plan)
    return dataset.plan->values(dataset.plan->values.rows() - 1, dataset.plan->column("time"));
  return dataset.script->time[dataset.script->time.size() - 1];
}

model::Robot overridden_robot(const trajectory::Dataset& dataset) {
  std::vector<model::Override> overrides;
  for (const auto& [path, text] : dataset.overrides)
    overrides.push_back({path, override_node(dataset, path, text)});
  return model::read_robot(model::find_robot(dataset.robot, dataset.folder), overrides);
}

model::Robot dataset_robot(const trajectory::Dataset& dataset) {
  model::Robot robot = overridden_robot(dataset);
  if (dataset.experiment != trajectory::ExperimentKind::tail_bench) return robot;

  std::vector<std::string> commanded;
  if (dataset.script) commanded = dataset.script->joints;
  if (!dataset.script) commanded = {"tail"};
  for (const model::Coordinate& c : std::vector<model::Coordinate>(robot.planar.coordinates)) {
    if (std::find(commanded.begin(), commanded.end(), c.name) != commanded.end()) continue;
    const double middle =
        std::isfinite(c.range.lower + c.range.upper) ? 0.5 * (c.range.lower + c.range.upper) : 0.0;
    robot.planar = model::lock(robot.planar, c.name,
                               value_or(dataset.initial, c.name, c.name == "z" ? 1.0 : middle));
  }

  robot.notes.emplace_back("tail bench: the base and every coordinate without a command are held");
  return robot;
}

Plant dataset_plant(const trajectory::Dataset& dataset, const model::PlanarModel& model) {
  Plant plant = nominal_plant(model);
  if (dataset.controller.bus_voltage)
    for (model::PlanarMotor& motor : plant.model.motors)
      if (!motor.ideal()) motor.voltage = *dataset.controller.bus_voltage;

  for (const auto& [joint, stop] : dataset.stops) {
    if (model.body_of_joint(joint) < 0) {
      std::vector<std::string> joints;
      for (const model::PlanarBody& body : model.bodies)
        if (!body.joint.empty()) joints.push_back(body.joint);
      throw InputError(fmt::format("stops: '{}' is no joint of this robot{}", joint,
                                   yaml::did_you_mean(joint, joints)));
    }
    plant.stops.push_back({joint, stop.range, stop.restitution});
  }
  return plant;
}

void require_units(const trajectory::Dataset& dataset, const model::PlanarModel& model) {
  for (const trajectory::Trial& trial : dataset.trials)
    for (const trajectory::Stream& stream : trial.streams)
      for (std::size_t c = 0; c < stream.channels.size(); ++c) {
        const trajectory::ChannelName parts = trajectory::parse_channel(stream.channels[c]);
        const int body = model.body_of_joint(parts.of);
        if (body < 0) continue;
        const bool slides = model.bodies[body].kind == model::JointKind::prismatic;
        const std::string usual = trajectory::unit_of(parts.quantity, slides);
        if (stream.units[c] != trajectory::unit_of(parts.quantity, !slides) ||
            stream.units[c] == usual)
          continue;
        throw InputError(fmt::format("{}: channel '{}' is in {}, but the joint {}; allowed: {}",
                                     stream.name, stream.channels[c], stream.units[c],
                                     slides ? "slides" : "turns", usual));
      }
}

void put_gains_at_motors(const model::PlanarModel& model,
                         trajectory::StatedController& controller) {
  if (!controller.gains_at_joint) return;
  controller.gains_at_joint = false;
  for (auto* gains : {&controller.kp, &controller.kd}) {
    const auto all = gains->find("*");
    if (all != gains->end()) {
      for (const model::PlanarMotor& motor : model.motors)
        gains->try_emplace(motor.joint, all->second);
      gains->erase("*");
    }
    for (const model::PlanarMotor& motor : model.motors) {
      const auto gain = gains->find(motor.joint);
      if (gain == gains->end()) continue;
      gain->second.range.lower /= motor.gear * motor.gear;
      gain->second.range.upper /= motor.gear * motor.gear;
    }
  }
}

Controller experiment_controller(const Experiment& experiment, const model::PlanarModel& model) {
  const trajectory::StatedController& stated = experiment.setup.controller;
  if (!stated.gains_stated)
    throw InputError(
        fmt::format("{}: controller: kp and kd are missing; a simulation needs them as numbers",
                    experiment.name));
  for (const auto* gains : {&stated.kp, &stated.kd}) {
    for (const auto& [joint, gain] : *gains) {
      if (!gain.known())
        throw InputError(
            fmt::format("{}: controller: {}.{}: unknown or a range; a simulation needs a number",
                        experiment.name, gains == &stated.kp ? "kp" : "kd", joint));
    }
  }

  trajectory::Dataset setup = experiment.setup;
  if (setup.experiment == trajectory::ExperimentKind::tail_bench) {
    // What is held has left the model; only what remains can be set.
    std::erase_if(setup.initial, [&](const auto& entry) {
      return model.coordinate_index(entry.first) < 0 &&
             dataset_robot(experiment.setup).planar.body_of_joint(entry.first) < 0;
    });
  }

  // names the file; a dataset's plan is always plan.csv
  if (setup.plan && !experiment.plan_file.empty())
    (void)plan_reference(*setup.plan, model, stated.quantity, 1.0, experiment.plan_file);
  return stated_controller(setup, model, {});
}

TrialRun run_trial(const Experiment& experiment, const Plant& plant, const Controller& controller,
                   int index, std::uint64_t seed) {
  const std::uint64_t own = task_seed(seed, index);
  Random random(own);
  TrialRun run;
  run.start = scattered_start(experiment, plant, controller, random);
  SimulationOptions options;
  const double steps = std::ceil(experiment.duration / kTruthStep);
  options.duration = steps * kTruthStep;
  options.sample_times = Vector::LinSpaced(std::lround(steps) + 1, 0.0, options.duration);
  run.truth = simulate(plant, controller, run.start, options);
  run.trial.name = fmt::format("trial_{:02}", index + 1);
  if (run.truth.time.size() == 0) return run;
  for (std::size_t i = 0; i < experiment.streams.size(); ++i) {
    Random random(task_seed(own, 100 + i));
    run.trial.streams.push_back(
        read_sensor(experiment, experiment.streams[i], plant, run.truth, random));
  }
  return run;
}

}  // namespace jaculus::simulation
