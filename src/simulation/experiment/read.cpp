#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "jaculus/core/error.h"
#include "jaculus/simulation/experiment.h"
#include "simulation/experiment/channel_values.h"
#include "simulation/experiment/uncertain_values.h"
#include "trajectory/channel_units.h"
#include "trajectory/dataset_yaml.h"

namespace jaculus::simulation {
namespace {

namespace fs = std::filesystem;

// Standard deviations of sensors of this class: motion capture 0.3 mm and 0.15 degrees, encoders
// 1e-3 rad.
const std::map<std::string, double> kDefaultNoise = {{"x", 3e-4},
                                                     {"z", 3e-4},
                                                     {"y", 3e-4},
                                                     {"pitch", 2.6179938779914944e-3},
                                                     {"*", 1e-3},
                                                     {"*_velocity", 0.1},
                                                     {"*_torque", 0.0},
                                                     {"*_current", 0.2},
                                                     {"*_voltage", 0.05},
                                                     {"*_duty", 0.0},
                                                     {"bus_voltage", 0.02},
                                                     {"imu_pitch", 5e-3},
                                                     {"imu_pitch_velocity", 0.02}};

/// A number in the first of `dimensions` that its unit has.
double number_in(const yaml::Node& node, const std::vector<Dimension>& dimensions,
                 const Bounds& allowed = {}) {
  for (std::size_t i = 0; i + 1 < dimensions.size(); ++i) {
    try {
      return node.number(dimensions[i], allowed);
    } catch (const InputError&) {  // NOLINT(bugprone-empty-catch): the next dimension is tried
    }
  }
  return node.number(dimensions.back(), allowed);
}

Spread read_spread(const yaml::Node& node, const std::vector<Dimension>& dimensions) {
  Spread spread;
  if (!node.is_list()) {
    spread.deviation = number_in(node, dimensions, {0.0, kInfinity});
    return spread;
  }
  const std::vector<yaml::Node> ends = node.items();
  if (ends.size() != 2) throw node.error("allowed: a standard deviation, or [from, to]");
  spread.range = Bounds{number_in(ends[0], dimensions), number_in(ends[1], dimensions)};
  if (spread.range->lower > spread.range->upper)
    throw node.error("from is above to; allowed: [from, to]");
  return spread;
}

/// The pattern that a channel goes by: "front_a_velocity" is "*_velocity" where front_a has a
/// motor.
std::string pattern_of(const std::string& channel, const model::PlanarModel& model) {
  const auto [motor, quantity] = motor_channel(model, channel);
  return motor < 0 ? channel : channel_name("*", quantity);
}

/// Names of everything that a stream may show of this robot.
std::vector<std::string> known_channels(const model::PlanarModel& model) {
  std::vector<std::string> names;
  for (const model::Coordinate& c : model.coordinates) {
    names.push_back(c.name);
    names.push_back(channel_name(c.name, Quantity::velocity));
  }
  for (const model::PlanarMotor& motor : model.motors)
    for (const Quantity quantity : {Quantity::position, Quantity::velocity, Quantity::torque,
                                    Quantity::current, Quantity::voltage, Quantity::duty})
      names.push_back(channel_name(motor.joint, quantity));
  if (model.coordinate_index("pitch") >= 0)
    names.insert(names.end(), {"imu_pitch", "imu_pitch_velocity"});
  names.emplace_back("bus_voltage");
  return names;
}

void add_channel(const std::string& text, const yaml::Node& node, const model::PlanarModel& model,
                 SensorStream& stream) {
  const std::vector<std::string> known = known_channels(model);
  std::vector<std::string> wanted = {text};

  if (text.starts_with("*")) {
    wanted.clear();
    for (const model::PlanarMotor& motor : model.motors)
      wanted.push_back(motor.joint + text.substr(1));
  }

  for (const std::string& name : wanted) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      throw node.error(fmt::format("'{}' given{}; allowed: {}", name,
                                   yaml::did_you_mean(name, known), fmt::join(known, ", ")));
    }
    if (std::find(stream.channels.begin(), stream.channels.end(), name) == stream.channels.end())
      stream.channels.push_back(name);
  }
}

/// What noise of a channel may be in: a joint's or a coordinate's as it turns or slides.
std::vector<Dimension> noise_dimensions(const std::string& channel,
                                        const model::PlanarModel& model) {
  const auto [motor, quantity] = motor_channel(model, channel);
  const std::string of = trajectory::parse_channel(channel).of;
  const int coordinate = model.coordinate_index(of == "imu_pitch" ? "pitch" : of);
  if (motor < 0 && coordinate < 0) return trajectory::channel_dimensions(channel);
  const bool slides =
      motor >= 0 ? model.slides(model.motors[motor]) : !model.coordinates[coordinate].angular;
  const std::vector<Dimension>& dimensions = trajectory::dimensions_of(quantity);
  return {slides ? dimensions.back() : dimensions.front()};
}

void set_noise(const std::optional<yaml::Node>& node, const model::PlanarModel& model,
               SensorStream& stream) {
  std::map<std::string, yaml::Node> stated;
  if (node) {
    for (const auto& [name, value] : node->entries()) {
      const bool used = std::any_of(stream.channels.begin(), stream.channels.end(),
                                    [&](const std::string& channel) {
                                      return channel == name || pattern_of(channel, model) == name;
                                    });
      if (!used) throw value.error(fmt::format("the stream has no channel '{}'", name));
      stated.emplace(name, value);
    }
  }

  for (const std::string& channel : stream.channels) {
    const std::string pattern = pattern_of(channel, model);
    auto found = stated.find(channel);
    if (found == stated.end()) found = stated.find(pattern);
    const auto usual = kDefaultNoise.find(pattern);
    stream.noise[channel] =
        found != stated.end()
            ? number_in(found->second, noise_dimensions(channel, model), {0.0, kInfinity})
            : (usual == kDefaultNoise.end() ? 0.0 : usual->second);
  }
}

std::vector<std::string> default_channels(const std::string& stream,
                                          const model::PlanarModel& model) {
  if (stream == trajectory::kMocapStream) {
    std::vector<std::string> channels;
    for (const char* name : {"x", "z", "pitch"})
      if (model.coordinate_index(name) >= 0) channels.emplace_back(name);
    return channels;
  }
  return {"*", "*_velocity", "*_torque"};
}

SensorStream read_stream(const std::string& name, const yaml::Node& node,
                         const model::PlanarModel& model) {
  node.only({"rate_hz", "channels", "noise", "dropout", "dropout_length", "time_shift"});
  SensorStream stream;
  stream.name = name;
  stream.rate_hz = node.at("rate_hz").number(dimension::frequency, {1e-3, 1e6});
  if (const auto channels = node.find("channels")) {
    for (const yaml::Node& channel : channels->items())
      add_channel(channel.text(), channel, model, stream);
  } else {
    for (const std::string& channel : default_channels(name, model))
      add_channel(channel, node, model, stream);
  }

  if (stream.channels.empty()) throw node.error("the stream has no channel; allowed: at least one");
  set_noise(node.find("noise"), model, stream);
  if (const auto dropout = node.find("dropout"))
    stream.dropout = dropout->number(dimension::none, {0.0, 0.9});
  if (const auto length = node.find("dropout_length"))
    stream.dropout_length = length->number(dimension::none, {1.0, 1e6});
  if (const auto shift = node.find("time_shift"))
    stream.time_shift = read_spread(*shift, {dimension::time});

  return stream;
}

void read_uncertainties(const yaml::Node& node, Experiment& experiment) {
  const std::vector<model::ModelValue> all =
      model::model_values(overridden_robot(experiment.setup).planar);
  for (const auto& [path, value] : node.entries()) {
    (void)values_named(path, all, experiment.setup.robot,
                       {node.file().string(), value.line(), node.path()});
    const std::string text = value.is_scalar() ? value.dump() : "";
    Spread spread;
    if (text.find('%') != std::string::npos) {
      spread.deviation = value.number(dimension::none, {0.0, 1.0});
      spread.relative = true;
    } else {
      // Its dimension is that of the model value, which the replay knows; here any that a model
      // value has.
      spread = read_spread(
          value, {dimension::none, dimension::mass, dimension::length, dimension::inertia,
                  dimension::voltage, dimension::resistance, dimension::torque_constant,
                  dimension::angle, dimension::torque, dimension::current, dimension::density});
    }
    experiment.uncertainties[path] = spread;
  }
}

void read_sensors(const yaml::Node& file, const model::PlanarModel& model, Experiment& experiment) {
  if (const auto streams = file.find("streams")) {
    for (const auto& [name, node] : streams->entries())
      experiment.streams.push_back(read_stream(name, node, model));
  } else {
    const auto usual = [&](const std::string& text, const std::string& name) {
      experiment.streams.push_back(read_stream(name, yaml::Node::parse(text, name), model));
    };
    if (model.coordinate_index("x") >= 0) usual("{rate_hz: 240}", trajectory::kMocapStream);
    if (!model.motors.empty()) usual("{rate_hz: 1000}", trajectory::kJointStream);
  }
  if (experiment.streams.empty())
    throw file.error("there is nothing to measure; allowed: at least one stream");
}

void read_scatter(const yaml::Node& node, const model::PlanarModel& model, Experiment& experiment) {
  std::vector<std::string> names;
  for (const model::Coordinate& c : model.coordinates) names.push_back(c.name);
  node.only(names);
  for (const auto& [name, value] : node.entries()) {
    const bool angular = model.coordinates[model.coordinate_index(name)].angular;
    experiment.scatter[name] = read_spread(value, {angular ? dimension::angle : dimension::length});
  }
}

/// Refuses a pose that leaves coordinates open here, where its place is known, before the first
/// trial does.
void check_start(const yaml::Node& file, const Experiment& experiment,
                 const model::PlanarModel& model) {
  const Plant plant = dataset_plant(experiment.setup, model);
  const Controller controller = experiment_controller(experiment, model);
  try {
    (void)reference_start(plant, controller.reference);
  } catch (const InputError& error) {
    const auto initial = file.find("initial");
    throw InputError({file.file().string(), initial ? initial->line() : file.line(), "initial"},
                     error.fault());
  }
}

/// `states_kind`: the file is a user's, so that the kind of experiment must fit its robot.
Experiment read_parts(const yaml::Node& file, const fs::path& folder, bool states_kind) {
  std::vector<std::string> keys = {
      "format", "name",    "duration", "lead",          "trials",
      "seed",   "scatter", "streams",  "uncertainties", "touchdown_height"};
  keys.insert(keys.end(), trajectory::kSetupKeys.begin(), trajectory::kSetupKeys.end());
  yaml::refuse_other_kind(file, "jaculus-experiment/1");
  file.only(keys);
  (void)file.at("format").choice({"jaculus-experiment/1"});
  Experiment experiment;
  experiment.name = file.at("name").text();
  trajectory::DatasetOutline outline = trajectory::read_dataset_setup(file);
  trajectory::load_commands(outline, folder);
  if (outline.plan) experiment.plan_file = folder / outline.plan->text();
  experiment.setup = std::move(outline.dataset);
  experiment.setup.folder = folder;

  if (!experiment.setup.plan && !experiment.setup.script)
    throw file.error(
        "neither plan nor input is given; allowed: one of the two, for there is no log to replay");
  const model::PlanarModel model = dataset_robot(experiment.setup).planar;
  if (states_kind && experiment.setup.experiment == trajectory::ExperimentKind::leap &&
      model.coordinate_index("z") < 0)
    throw file.at("experiment").error("leap given for a robot whose base can't rise");
  put_gains_at_motors(model, experiment.setup.controller);
  const double commanded = command_duration(experiment.setup);
  experiment.duration = commanded + 0.1;

  if (const auto duration = file.find("duration"))
    experiment.duration = duration->number(dimension::time, {1e-3, 3600.0});
  if (const auto lead = file.find("lead"))
    experiment.lead = lead->number(dimension::time, {0.0, 3600.0});
  if (const auto trials = file.find("trials")) experiment.trials = trials->integer(1, 100000);
  if (const auto seed = file.find("seed")) experiment.seed = seed->integer(0, 2147483647);
  if (const auto scatter = file.find("scatter")) read_scatter(*scatter, model, experiment);
  read_sensors(file, model, experiment);
  if (const auto uncertainties = file.find("uncertainties"))
    read_uncertainties(*uncertainties, experiment);
  if (const auto height = file.find("touchdown_height"))
    experiment.touchdown_height = height->number(dimension::length, {0.0, kInfinity});
  check_start(file, experiment, model);

  return experiment;
}

}  // namespace

Experiment read_experiment(const yaml::Node& node) {
  const fs::path folder = node.file().parent_path();
  return read_parts(node, folder.empty() ? fs::path(".") : folder, true);
}

Experiment read_experiment(const fs::path& file) { return read_experiment(yaml::Node::load(file)); }

Experiment plan_experiment(const fs::path& plan, const std::string& robot,
                           const std::string& controller) {
  const fs::path folder = plan.parent_path().empty() ? fs::path(".") : plan.parent_path();
  // Gains of the class that this robot was run with, as torque at the motor: duty 0.4 and 0.01 a
  // radian and rad/s at 8.2 N m.
  const std::string usual =
      "{kind: feedforward_pd, quantity: torque, rate_hz: 1000, kp: 3.3, kd: 0.08}";
  using yaml::quoted;
  const std::string text = fmt::format(
      "format: jaculus-experiment/1\nname: {}\nexperiment: leap\nrobot: {}\nplan: {}\ncontroller: "
      "{}\nlead: 0.3\n"
      "touchdown_height: 0.2078\n",
      quoted(plan.stem().string()), quoted(robot), quoted(plan.filename().string()),
      controller.empty() ? usual : controller);

  return read_parts(yaml::Node::parse(text, plan.string()), folder, false);
}

}  // namespace jaculus::simulation
