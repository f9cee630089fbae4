#include "trajectory/dataset_yaml.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "jaculus/core/error.h"

namespace jaculus {
namespace {

const std::vector<std::string> kQuantities = {"torque", "duty", "voltage"};
const Bounds kPositive{1e-12, kInfinity};

StatedGain read_gain(const yaml::Node& node, const Dimension& dimension) {
  if (node.is_list()) {
    const Bounds range = node.bounds(dimension);
    if (range.lower < 0.0) throw node.error("a gain below zero given; allowed: [lower, upper] with 0 <= lower");
    return {range};
  }
  if (const std::string text = node.dump(); text == "unknown" || text == "\"unknown\"") return {{0.0, kInfinity}};
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

void note_gains(const StatedController& controller, std::vector<std::string>& notes) {
  if (!controller.gains_stated) {
    notes.emplace_back("the controller's gains are not stated: every kp and kd is taken as unknown");
    return;
  }
  for (const auto* gains : {&controller.kp, &controller.kd}) {
    if (gains->empty())
      notes.push_back(fmt::format("no {} is stated: it is taken as unknown", gains == &controller.kp ? "kp" : "kd"));
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
  controller.after_end_place = fmt::format("{}:{}: controller.after_end", node.file().string(), node.line());
  if (!node.is_map()) {
    controller.after_end = node.choice({"hold", "relax", "repeat"});
    return;
  }
  node.only({"pose", "within"});
  if (controller.kind != "feedforward_pd")
    throw node.error(
        fmt::format("a landing pose given; allowed: hold, relax or repeat, for a controller of kind {} has no feedback "
                    "that could reach a pose",
                    controller.kind));
  controller.after_end = "pose";
  for (const auto& [joint, value] : node.at("pose").entries()) controller.landing_pose[joint] = angle_or_length(value);
  if (controller.landing_pose.empty()) throw node.at("pose").error("no joint given; allowed: JOINT: ANGLE, or \"*\"");
  controller.landing_time = node.at("within").number(dimension::time, kPositive);
}

StatedController controller_of(const yaml::Node& node, std::vector<std::string>& notes) {
  node.only({"kind", "quantity", "rate_hz", "kp", "kd", "bus_voltage", "input", "after_end"});
  StatedController controller;
  controller.kind = node.at("kind").choice({"feedforward_pd", "voltage", "torque", "measured"});
  const bool feedback = controller.kind == "feedforward_pd";
  const bool script = controller.kind == "voltage" || controller.kind == "torque";
  if (script) controller.quantity = controller.kind;
  if (const auto quantity = node.find("quantity")) {
    controller.quantity = quantity->choice(script ? std::vector<std::string>{controller.kind} : kQuantities);
    controller.quantity_stated = true;
  } else if (feedback) {
    notes.emplace_back("the controller's quantity is not stated: torque is taken");
  }
  if (const auto rate = node.find("rate_hz")) {
    controller.rate_hz = rate->number(dimension::frequency, kPositive);
  } else if (controller.kind != "measured") {
    notes.push_back(fmt::format("the controller's rate is not stated: {} Hz is taken", controller.rate_hz));
  }
  const auto kp = node.find("kp");
  const auto kd = node.find("kd");
  if (!feedback && kp) throw kp->error(fmt::format("a controller of kind {} has no feedback", controller.kind));
  if (!feedback && kd) throw kd->error(fmt::format("a controller of kind {} has no feedback", controller.kind));
  controller.gains_stated = kp || kd || !feedback;
  if (kp) controller.kp = read_gains(*kp, gain_dimension(controller.quantity, false));
  if (kd) controller.kd = read_gains(*kd, gain_dimension(controller.quantity, true));
  if (feedback) note_gains(controller, notes);
  if (const auto bus = node.find("bus_voltage")) controller.bus_voltage = bus->number(dimension::voltage, kPositive);
  if (const auto end = node.find("after_end")) read_after_end(*end, controller);
  if (controller.kind == "measured") {
    controller.input = node.at("input").choice({"torque", "voltage", "duty", "current"});
  } else if (const auto input = node.find("input")) {
    throw input->error(
        "given; allowed: only where kind is measured (it names the logged quantity that drove the joint)");
  }
  return controller;
}

/// One joint's commands: a number that holds from the start, or [[time, value], ...].
std::vector<std::pair<double, double>> read_steps(const yaml::Node& node, const Dimension& dimension) {
  if (node.is_scalar()) return {{0.0, node.number(dimension)}};
  std::vector<std::pair<double, double>> steps;
  for (const yaml::Node& step : node.items()) {
    const std::vector<yaml::Node> parts = step.items();
    if (parts.size() != 2) throw step.error("allowed: [time, value]");
    const double time = parts[0].number(dimension::time);
    if (!steps.empty() && !(time > steps.back().first))
      throw step.error(
          fmt::format("time {:.10g} s follows {:.10g} s; allowed: rising times", time, steps.back().first));
    steps.emplace_back(time, parts[1].number(dimension));
  }
  if (steps.empty()) throw node.error("an empty list given; allowed: [[time, value], ...]");
  return steps;
}

/// {voltage: {tail: 12 V, ...}}: all joints on one grid, each holding its last value (0 before its first).
InputScript read_steps_script(const yaml::Node& node, const std::string& quantity) {
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
  const std::vector<double> grid(times.begin(), times.end());
  script.time = Eigen::Map<const Vector>(grid.data(), static_cast<Eigen::Index>(grid.size()));
  script.values = Matrix::Zero(static_cast<Eigen::Index>(all.size()), script.time.size());
  for (std::size_t j = 0; j < all.size(); ++j) {
    for (const auto& [time, value] : all[j]) {
      for (Eigen::Index k = 0; k < script.time.size(); ++k)
        if (script.time[k] >= time) script.values(static_cast<Eigen::Index>(j), k) = value;
    }
  }
  return script;
}

void read_input(const yaml::Node& node, DatasetOutline& outline) {
  node.only({"quantity", "file", "torque", "duty", "voltage"});
  const StatedController& controller = outline.dataset.controller;
  std::vector<std::string> direct;
  for (const std::string& quantity : kQuantities)
    if (node.has(quantity)) direct.push_back(quantity);
  if (node.has("file") ? !direct.empty() : direct.size() != 1)
    throw node.error(
        "allowed: {quantity: voltage, file: input.csv}, or {voltage: {JOINT: VALUE or [[TIME, VALUE], ...]}}");
  if (!direct.empty()) {
    if (const auto quantity = node.find("quantity")) (void)quantity->choice(direct);
    outline.dataset.script = read_steps_script(node.at(direct.front()), direct.front());
  } else {
    outline.input_file = node.at("file");
    outline.dataset.script = InputScript{};
    const auto quantity = node.find("quantity");
    outline.dataset.script->quantity = quantity ? quantity->choice(kQuantities) : controller.quantity;
  }
  const std::string& given = outline.dataset.script->quantity;
  if ((controller.kind == "voltage" || controller.kind == "torque") && given != controller.kind)
    throw node.error(fmt::format("a script of {} given for a controller of kind {}", given, controller.kind));
}

void read_streams(const yaml::Node& node, DatasetOutline& outline) {
  for (const auto& [name, entry] : node.entries()) {
    entry.only({"file", "rate_hz"});
    StreamEntry stream{name, entry.at("file").text(), kNaN, entry};
    const std::filesystem::path file = stream.file;
    if (file.is_absolute() || *file.begin() == "..")
      throw entry.at("file").error(fmt::format("'{}' given; allowed: a file in the trials' folders", stream.file));
    if (const auto rate = entry.find("rate_hz")) stream.rate_hz = rate->number(dimension::frequency, kPositive);
    outline.streams.push_back(stream);
  }
  if (outline.streams.empty()) throw node.error("no stream given; allowed: NAME: {file: NAME.csv, rate_hz: RATE}");
}

void read_trials(const yaml::Node& node, DatasetOutline& outline) {
  std::set<std::string> seen;
  for (const yaml::Node& trial : node.items()) {
    const std::filesystem::path name = trial.text();
    if (name.is_absolute() || *name.begin() == "..")
      throw trial.error(fmt::format("'{}' given; allowed: a folder in the dataset's folder", name.string()));
    if (!seen.insert(name.string()).second) throw trial.error(fmt::format("'{}' stands twice", name.string()));
    outline.trials.push_back(trial);
  }
  if (outline.trials.empty()) throw node.error("no trial given; allowed: a list of the trials' folders");
}

void check_commands(const yaml::Node& file, const DatasetOutline& outline) {
  const StatedController& controller = outline.dataset.controller;
  const bool scripted = outline.dataset.script.has_value();
  if (outline.plan && scripted) throw file.at("input").error("given beside a plan; allowed: one of the two");
  if (controller.kind == "feedforward_pd" && !outline.plan && !scripted)
    throw file.error("key 'plan' is missing; a controller of kind feedforward_pd needs plan or input");
  if ((controller.kind == "voltage" || controller.kind == "torque") && !outline.plan && !scripted)
    throw file.error(
        fmt::format("key 'input' is missing; a controller of kind {} needs it, or a plan", controller.kind));
}

}  // namespace

StatedController read_stated_controller(const yaml::Node& node, std::vector<std::string>& notes) {
  return controller_of(node, notes);
}

Dimension command_dimension(const std::string& quantity) {
  if (quantity == "torque") return dimension::torque;
  return quantity == "voltage" ? dimension::voltage : dimension::none;
}

Dimension gain_dimension(const std::string& quantity, bool derivative) {
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
  dataset.experiment = file.at("experiment").choice({"leap", "self_righting", "tail_bench", "pendulum"});
  dataset.robot = file.at("robot").text();
  if (const auto overrides = file.find("override")) {
    for (const auto& [path, value] : overrides->entries()) {
      if (!value.is_scalar()) throw value.error("allowed: one value");
      dataset.overrides[path] = value.dump();
    }
  }
  dataset.controller = controller_of(file.at("controller"), dataset.notes);
  outline.plan = file.find("plan");
  if (outline.plan) (void)outline.plan->text();
  if (const auto input = file.find("input")) read_input(*input, outline);
  if (const auto initial = file.find("initial")) {
    for (const auto& [name, value] : initial->entries()) dataset.initial[name] = angle_or_length(value);
  }
  if (const auto stops = file.find("stops")) {
    for (const auto& [joint, stop] : stops->entries()) {
      stop.only({"range", "restitution"});
      StatedStop stated{stop.at("range").bounds(dimension::angle), 0.0};
      if (const auto r = stop.find("restitution")) stated.restitution = r->number(dimension::none, {0.0, 1.0});
      dataset.stops[joint] = stated;
    }
  }
  check_commands(file, outline);
  return outline;
}

DatasetOutline read_outline(const yaml::Node& file) {
  std::vector<std::string> keys = {"format", "streams", "trials", "provenance"};
  keys.insert(keys.begin() + 1, kSetupKeys.begin(), kSetupKeys.end());
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

}  // namespace jaculus
