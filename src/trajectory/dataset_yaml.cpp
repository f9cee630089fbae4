#include "trajectory/dataset_yaml.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "jaculus/core/error.h"

namespace jaculus::trajectory {
namespace {

/// The value of an enumeration that a node names.
template <class Value>
Value read_name(const yaml::Node& node, const NameTable<Value>& table) {
  return *table.find(node.choice(table.names()));
}

const Bounds kPositive{1e-12, kInfinity};

StatedGain read_gain(const yaml::Node& node, const Dimension& dimension) {
  if (node.is_list()) {
    const Bounds range = node.bounds(dimension);
    if (range.lower < 0.0)
      throw node.error("a gain below zero given; allowed: [lower, upper] with 0 <= lower");
    return {range};
  }
  if (const std::string text = node.dump(); text == "unknown" || text == "\"unknown\"")
    return {{0.0, kInfinity}};
  const double value = node.number(dimension, {0.0, kInfinity});
  return {{value, value}};
}

/// One gain for all joints, or one a joint.
std::map<std::string, StatedGain> read_gains(const yaml::Node& node, const Dimension& dimension) {
  if (!node.is_map()) return {{"*", read_gain(node, dimension)}};
  std::map<std::string, StatedGain> gains;
  for (const auto& [joint, gain] : node.entries()) gains[joint] = read_gain(gain, dimension);
  return gains;
}

/// motor | joint. A joint's duty or voltage would be nobody's.
void read_gains_at(const yaml::Node& node, StatedController& controller) {
  controller.gains_at_joint = node.choice({"motor", "joint"}) == "joint";
  if (controller.gains_at_joint && controller.quantity != Quantity::torque)
    throw node.error("joint given with gains that are no torque; allowed: motor");
}

void note_gains(const StatedController& controller, std::vector<std::string>& notes) {
  if (!controller.gains_stated) {
    notes.emplace_back(
        "the controller's gains are not stated: every kp and kd is taken as unknown");
    return;
  }
  for (const auto* gains : {&controller.kp, &controller.kd}) {
    if (gains->empty())
      notes.push_back(fmt::format("no {} is stated: it is taken as unknown",
                                  gains == &controller.kp ? "kp" : "kd"));
  }
}

double angle_or_length(const yaml::Node& node) {
  try {
    return node.number(dimension::angle);
  } catch (const InputError&) {
    return node.number(dimension::length);
  }
}

/// hold | relax | repeat | {pose: {JOINT: ANGLE, "*": ANGLE}, within: TIME}
void read_after_end(const yaml::Node& node, StatedController& controller) {
  if (!node.is_map()) {
    controller.after_end =
        read_name(node, after_ends().only({AfterEnd::hold, AfterEnd::relax, AfterEnd::repeat}));
    return;
  }

  node.only({"pose", "within"});
  if (controller.kind != ControllerKind::feedforward_pd)
    throw node.error(
        fmt::format("a landing pose given; allowed: hold, relax or repeat, for a controller of "
                    "kind {} has no feedback "
                    "that could reach a pose",
                    name_of(controller.kind)));
  controller.after_end = AfterEnd::pose;
  for (const auto& [joint, value] : node.at("pose").entries())
    controller.landing_pose[joint] = angle_or_length(value);
  if (controller.landing_pose.empty())
    throw node.at("pose").error("no joint given; allowed: JOINT: ANGLE, or \"*\"");

  controller.landing_time = node.at("within").number(dimension::time, kPositive);
}

/// What the script of a controller must be in; nothing where its kind leaves that open.
std::optional<Quantity> scripted_quantity(ControllerKind kind) {
  if (kind == ControllerKind::voltage) return Quantity::voltage;
  if (kind == ControllerKind::torque) return Quantity::torque;
  return std::nullopt;
}

/// A value, or a motor anew, in one line.
std::string override_text(const yaml::Node& node) {
  const auto one = [](const yaml::Node& value) {
    if (!value.is_scalar()) throw value.error("allowed: one value");
    return value.dump();
  };
  if (!node.is_map()) return one(node);
  std::string text;
  for (const auto& [key, value] : node.entries())
    text += fmt::format("{}{}: {}", text.empty() ? "{" : ", ", key, one(value));
  return text + "}";
}

StatedController controller_of(const yaml::Node& node, std::vector<std::string>& notes) {
  node.only(
      {"kind", "quantity", "rate_hz", "kp", "kd", "gains_at", "bus_voltage", "input", "after_end"});
  StatedController controller;
  controller.kind = read_name(node.at("kind"), controller_kinds());
  const bool feedback = controller.kind == ControllerKind::feedforward_pd;
  const bool measured = controller.kind == ControllerKind::measured;

  const std::optional<Quantity> scripted = scripted_quantity(controller.kind);
  if (scripted) controller.quantity = *scripted;
  if (const auto quantity = node.find("quantity")) {
    controller.quantity =
        read_name(*quantity, scripted ? quantity_names().only({*scripted}) : command_names());
    controller.quantity_stated = true;
  } else if (feedback) {
    notes.emplace_back("the controller's quantity is not stated: torque is taken");
  }

  if (const auto rate = node.find("rate_hz")) {
    controller.rate_hz = rate->number(dimension::frequency, kPositive);
  } else if (!measured) {
    notes.push_back(
        fmt::format("the controller's rate is not stated: {} Hz is taken", controller.rate_hz));
  }

  const auto kp = node.find("kp");
  const auto kd = node.find("kd");
  for (const auto& gain : {kp, kd}) {
    if (feedback || !gain) continue;
    throw gain->error(
        fmt::format("a controller of kind {} has no feedback", name_of(controller.kind)));
  }
  controller.gains_stated = kp || kd || !feedback;
  if (kp) controller.kp = read_gains(*kp, gain_dimension(controller.quantity, false));
  if (kd) controller.kd = read_gains(*kd, gain_dimension(controller.quantity, true));
  if (feedback) note_gains(controller, notes);
  if (const auto at = node.find("gains_at")) read_gains_at(*at, controller);

  if (const auto bus = node.find("bus_voltage"))
    controller.bus_voltage = bus->number(dimension::voltage, kPositive);
  if (const auto end = node.find("after_end")) read_after_end(*end, controller);
  if (measured) {
    controller.input =
        read_name(node.at("input"), quantity_names().only({Quantity::torque, Quantity::voltage,
                                                           Quantity::duty, Quantity::current}));
  } else if (const auto input = node.find("input")) {
    throw input->error(
        "given; allowed: only where kind is measured (it names the logged quantity that drove the "
        "joint)");
  }
  return controller;
}

/// One joint's commands: a number that holds from the start, or [[time, value], ...].
std::vector<std::pair<double, double>> read_steps(const yaml::Node& node,
                                                  const Dimension& dimension) {
  if (node.is_scalar()) return {{0.0, node.number(dimension)}};
  std::vector<std::pair<double, double>> steps;
  for (const yaml::Node& step : node.items()) {
    const std::vector<yaml::Node> parts = step.items();
    if (parts.size() != 2) throw step.error("allowed: [time, value]");
    const double time = parts[0].number(dimension::time);
    if (!steps.empty() && !(time > steps.back().first))
      throw step.error(fmt::format("time {:.10g} s follows {:.10g} s; allowed: rising times", time,
                                   steps.back().first));
    steps.emplace_back(time, parts[1].number(dimension));
  }
  if (steps.empty()) throw node.error("an empty list given; allowed: [[time, value], ...]");
  return steps;
}

/// {voltage: {tail: 12 V, ...}}: all joints on one grid, each holding its last value (0 before its
/// first).
InputScript read_steps_script(const yaml::Node& node, Quantity quantity) {
  InputScript script;
  script.quantity = quantity;
  std::vector<std::vector<std::pair<double, double>>> all;
  std::set<double> times;
  for (const auto& [joint, value] : node.entries()) {
    script.joints.push_back(joint);
    all.push_back(read_steps(value, command_dimension(quantity)));
    for (const auto& step : all.back()) times.insert(step.first);
  }

  if (script.joints.empty()) throw node.error("no joint given; allowed: a map of joints");
  if (*times.begin() < 0.0)
    throw node.error(fmt::format("a time of {:g} s given; allowed: from the command's start, 0, on",
                                 *times.begin()));
  times.insert(0.0);  // nothing is commanded before a first step
  const std::vector<double> grid(times.begin(), times.end());
  script.time = Eigen::Map<const Vector>(grid.data(), grid.size());
  script.values = Matrix::Zero(all.size(), script.time.size());
  for (int j = 0; j < count_of(all); ++j) {
    for (const auto& [time, value] : all[j]) {
      for (Eigen::Index k = 0; k < script.time.size(); ++k)
        if (script.time[k] >= time) script.values(j, k) = value;
    }
  }

  return script;
}

void read_input(const yaml::Node& node, DatasetOutline& outline) {
  node.only({"quantity", "file", "torque", "duty", "voltage"});
  const StatedController& controller = outline.dataset.controller;
  std::vector<Quantity> direct;
  for (const std::string& name : command_names().names())
    if (node.has(name)) direct.push_back(*command_names().find(name));
  if (node.has("file") ? !direct.empty() : direct.size() != 1)
    throw node.error(
        "allowed: {quantity: voltage, file: input.csv}, or {voltage: {JOINT: VALUE or [[TIME, "
        "VALUE], ...]}}");

  if (!direct.empty()) {
    const Quantity own = direct.front();
    if (const auto quantity = node.find("quantity"))
      (void)read_name(*quantity, quantity_names().only({own}));
    outline.dataset.script = read_steps_script(node.at(name_of(own)), own);
  } else {
    outline.input_file = node.at("file");
    outline.dataset.script = InputScript{};
    const auto quantity = node.find("quantity");
    outline.dataset.script->quantity =
        quantity ? read_name(*quantity, command_names()) : controller.quantity;
  }

  const Quantity given = outline.dataset.script->quantity;
  const std::optional<Quantity> scripted = scripted_quantity(controller.kind);
  if (scripted && given != *scripted)
    throw node.error(fmt::format("a script of {} given for a controller of kind {}", name_of(given),
                                 name_of(controller.kind)));
}

void read_streams(const yaml::Node& node, DatasetOutline& outline) {
  for (const auto& [name, entry] : node.entries()) {
    entry.only({"file", "rate_hz"});
    StreamEntry stream{name, entry.at("file").text(), kNaN, entry};
    const std::filesystem::path file = stream.file;
    if (file.is_absolute() || *file.begin() == "..")
      throw entry.at("file").error(
          fmt::format("'{}' given; allowed: a file in the trials' folders", stream.file));
    if (const auto rate = entry.find("rate_hz"))
      stream.rate_hz = rate->number(dimension::frequency, kPositive);
    outline.streams.push_back(stream);
  }
  if (outline.streams.empty())
    throw node.error("no stream given; allowed: NAME: {file: NAME.csv, rate_hz: RATE}");
}

void read_trials(const yaml::Node& node, DatasetOutline& outline) {
  std::set<std::string> seen;
  for (const yaml::Node& trial : node.items()) {
    const std::filesystem::path name = trial.text();
    if (name.is_absolute() || *name.begin() == "..")
      throw trial.error(
          fmt::format("'{}' given; allowed: a folder in the dataset's folder", name.string()));
    if (!seen.insert(name.string()).second)
      throw trial.error(fmt::format("'{}' stands twice", name.string()));
    outline.trials.push_back(trial);
  }
  if (outline.trials.empty())
    throw node.error("no trial given; allowed: a list of the trials' folders");
}

void check_commands(const yaml::Node& file, const DatasetOutline& outline) {
  const StatedController& controller = outline.dataset.controller;
  const bool scripted = outline.dataset.script.has_value();
  if (outline.plan && scripted)
    throw file.at("input").error("given beside a plan; allowed: one of the two");
  if (outline.plan || scripted) return;

  if (controller.kind == ControllerKind::feedforward_pd)
    throw file.error(
        "key 'plan' is missing; a controller of kind feedforward_pd needs plan or input");
  if (scripted_quantity(controller.kind))
    throw file.error(
        fmt::format("key 'input' is missing; a controller of kind {} needs it, or a plan",
                    name_of(controller.kind)));
}

}  // namespace

void note_places(const yaml::Node& node, const std::string& key, Dataset& dataset) {
  dataset.places[key] = {node.file().string(), node.line(), key};
  if (!node.is_map()) return;
  for (const auto& [name, value] : node.entries()) {
    const std::string own = key + "." + name;
    dataset.places[own] = {value.file().string(), value.line(), own};
  }
}

StatedController read_stated_controller(const yaml::Node& node, std::vector<std::string>& notes) {
  return controller_of(node, notes);
}

Dimension command_dimension(Quantity quantity) { return dimensions_of(quantity).front(); }

Dimension gain_dimension(Quantity quantity, bool derivative) {
  Dimension dimension = command_dimension(quantity);
  dimension.radian -= 1;
  if (derivative) dimension.second += 1;
  return dimension;
}

const std::vector<std::string> kSetupKeys = {"experiment", "robot",   "override", "plan",
                                             "input",      "initial", "stops",    "controller"};

DatasetOutline read_dataset_setup(const yaml::Node& file) {
  DatasetOutline outline;
  Dataset& dataset = outline.dataset;
  dataset.experiment = read_name(file.at("experiment"), experiment_kinds());
  dataset.robot = file.at("robot").text();
  if (const auto overrides = file.find("override")) {
    for (const auto& [path, value] : overrides->entries()) {
      dataset.overrides[path] = override_text(value);
      dataset.override_places[path] = {value.file().string(), value.line(), value.path()};
    }
  }

  for (const char* key : {"controller", "input", "plan"})
    if (const auto node = file.find(key)) note_places(*node, key, dataset);
  dataset.controller = controller_of(file.at("controller"), dataset.notes);
  outline.plan = file.find("plan");
  if (outline.plan) (void)outline.plan->text();
  if (const auto input = file.find("input")) read_input(*input, outline);
  if (const auto initial = file.find("initial")) {
    for (const auto& [name, value] : initial->entries())
      dataset.initial[name] = angle_or_length(value);
  }

  if (const auto stops = file.find("stops")) {
    for (const auto& [joint, stop] : stops->entries()) {
      stop.only({"range", "restitution"});
      StatedStop stated{stop.at("range").bounds(dimension::angle), 0.0};
      if (const auto r = stop.find("restitution"))
        stated.restitution = r->number(dimension::none, {0.0, 1.0});
      dataset.stops[joint] = stated;
    }
  }

  check_commands(file, outline);
  return outline;
}

DatasetOutline read_outline(const yaml::Node& file) {
  std::vector<std::string> keys = {"format", "streams", "trials", "provenance"};
  keys.insert(keys.begin() + 1, kSetupKeys.begin(), kSetupKeys.end());
  yaml::refuse_other_kind(file, "jaculus-dataset/1");
  file.only(keys);
  (void)file.at("format").choice({"jaculus-dataset/1"});
  DatasetOutline outline = read_dataset_setup(file);
  read_streams(file.at("streams"), outline);
  read_trials(file.at("trials"), outline);
  if (const auto provenance = file.find("provenance")) {
    outline.dataset.provenance = provenance->text();
  } else {
    outline.dataset.notes.emplace_back("no provenance is stated");
  }
  return outline;
}

}  // namespace jaculus::trajectory
