// A plan's table as a reference, the controller that a dataset states, and the pose that a reference begins in.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"
#include "jaculus/simulation/controller.h"

namespace jaculus {

namespace {

std::vector<std::string> column_names(const Table& table) {
  std::vector<std::string> names;
  for (const Column& column : table.columns) names.push_back(column.name);
  return names;
}

[[noreturn]] void missing_column(const Table& table, const std::string& name, const std::string& why,
                                 const std::filesystem::path& file) {
  const auto near = yaml::nearest_name(name, column_names(table));
  throw InputError(fmt::format("{}:1: column '{}': {}, but the file has no such column{}", file.string(), name, why,
                               near ? fmt::format("; did it mean '{}'?", *near) : ""));
}

void check_time(const Vector& time, const std::filesystem::path& file) {
  for (Eigen::Index k = 0; k < time.size(); ++k) {
    if (!std::isfinite(time[k]))
      throw InputError(fmt::format("{}:{}: time: a gap; every sample has its time", file.string(), k + 2));
    if (k > 0 && time[k] < time[k - 1])
      throw InputError(fmt::format("{}:{}: time: {} s after {} s; a plan's time never falls", file.string(), k + 2,
                                   time[k], time[k - 1]));
  }
}

/// Row of a plan, without gaps.
Eigen::RowVectorXd plan_row(const Table& plan, const std::string& name, const Dimension& dimension,
                            const std::filesystem::path& file) {
  const Vector values = quantity(plan, name, dimension, file);
  for (Eigen::Index k = 0; k < values.size(); ++k)
    if (!std::isfinite(values[k]))
      throw InputError(fmt::format("{}:{}: column '{}': a gap; a plan has every value", file.string(), k + 2, name));
  return values.transpose();
}

/// Feed-forward of one motor in the controller's quantity.
Eigen::RowVectorXd feedforward(const Table& plan, const PlanarMotor& motor, CommandQuantity quantity_kind,
                               double bus_voltage, const std::filesystem::path& file) {
  const std::string& joint = motor.joint;
  const auto has = [&](const char* suffix) { return plan.column(joint + suffix) >= 0; };
  if (quantity_kind == CommandQuantity::torque) {
    if (!has("_torque")) missing_column(plan, joint + "_torque", "the robot has a motor there", file);
    // The joint's torque is what a plan means; the motor's follows by the gear of this robot, not by the plan's margin for losses.
    return plan_row(plan, joint + "_torque", dimension::torque, file) / (motor.gear * motor.efficiency);
  }
  const bool duty = quantity_kind == CommandQuantity::duty;
  if (duty && has("_duty")) return plan_row(plan, joint + "_duty", dimension::none, file);
  if (!has("_voltage")) {
    if (has("_duty")) return plan_row(plan, joint + "_duty", dimension::none, file) * bus_voltage;
    missing_column(plan, joint + "_voltage", "the robot has a motor there", file);
  }
  const Eigen::RowVectorXd voltage = plan_row(plan, joint + "_voltage", dimension::voltage, file);
  return duty ? Eigen::RowVectorXd(voltage / bus_voltage) : voltage;
}

/// Whether inputs are held over Hermite-Simpson intervals: in every phase the second, fourth, ... sample repeats the one before.
bool looks_held(const Reference& reference) {
  const Matrix& u = reference.feedforward;
  Eigen::Index first = 0;
  for (Eigen::Index k = 1; k < u.cols(); ++k) {
    if (reference.time[k] == reference.time[k - 1]) {
      first = k;
    } else if ((k - first) % 2 == 1 && k + 1 < u.cols() && !u.col(k).isApprox(u.col(k - 1), 1e-9)) {
      return false;
    }
  }
  return true;
}

}  // namespace

Reference plan_reference(const Table& plan, const PlanarModel& model, CommandQuantity quantity_kind, double bus_voltage,
                         const std::filesystem::path& file) {
  Reference reference;
  if (plan.column("time") < 0) missing_column(plan, "time", "a plan has its time", file);
  reference.time = quantity(plan, "time", dimension::time, file);
  check_time(reference.time, file);
  const Eigen::Index samples = reference.time.size();
  reference.duration = reference.time[samples - 1];
  const auto motors = static_cast<Eigen::Index>(model.motors.size());
  reference.position.resize(motors, samples);
  reference.velocity.resize(motors, samples);
  reference.feedforward.resize(motors, samples);
  for (Eigen::Index m = 0; m < motors; ++m) {
    const PlanarMotor& motor = model.motors[static_cast<size_t>(m)];
    const bool angular = model.bodies[static_cast<size_t>(motor.body)].kind == JointKind::revolute;
    for (const std::string& name : {motor.joint, motor.joint + "_velocity"})
      if (plan.column(name) < 0) missing_column(plan, name, "the robot has a motor there", file);
    reference.motors.push_back(motor.joint);
    reference.position.row(m) = plan_row(plan, motor.joint, angular ? dimension::angle : dimension::length, file);
    reference.velocity.row(m) =
        plan_row(plan, motor.joint + "_velocity", angular ? dimension::angular_velocity : dimension::velocity, file);
    reference.feedforward.row(m) = feedforward(plan, motor, quantity_kind, bus_voltage, file);
    reference.initial[motor.joint] = reference.position(m, 0);
  }
  for (const Coordinate& c : model.coordinates) {
    if (plan.column(c.name) < 0) continue;
    reference.initial[c.name] = plan_row(plan, c.name, c.angular ? dimension::angle : dimension::length, file)[0];
  }
  reference.linear = !looks_held(reference);
  return reference;
}

namespace {

double gain_of(const std::map<std::string, StatedGain>& stated, const std::map<std::string, double>& assumed,
               const std::string& joint) {
  auto found = stated.find(joint);
  if (found == stated.end()) found = stated.find("*");
  if (found != stated.end() && found->second.known()) return found->second.range.lower;
  const auto value = assumed.find(joint);
  return value == assumed.end() ? 0.0 : value->second;
}

CommandQuantity quantity_of(const std::string& name) {
  if (name == "duty") return CommandQuantity::duty;
  return name == "voltage" ? CommandQuantity::voltage : CommandQuantity::torque;
}

/// A script's columns for the motors of a robot; a motor that it leaves out has no command.
Reference script_reference(const InputScript& script, const PlanarModel& model, const std::filesystem::path& file) {
  Reference reference;
  reference.time = script.time;
  reference.duration = script.time.size() > 0 ? script.time[script.time.size() - 1] : 0.0;
  for (size_t j = 0; j < script.joints.size(); ++j) {
    const int m = model.motor_index(script.joints[j]);
    if (m < 0)
      throw InputError(
          fmt::format("{}: input: '{}' is no joint with a motor of this robot", file.string(), script.joints[j]));
    reference.motors.push_back(script.joints[j]);
  }
  reference.feedforward = script.values;
  if (script.quantity == "torque") {
    for (size_t j = 0; j < script.joints.size(); ++j) {
      const PlanarMotor& motor = model.motors[static_cast<size_t>(model.motor_index(script.joints[j]))];
      reference.feedforward.row(static_cast<Eigen::Index>(j)) /= motor.gear * motor.efficiency;
    }
  }
  return reference;
}

/// The pose to land in for every motor of the reference.
void set_landing(const StatedController& stated, Controller& controller) {
  const std::string& place = stated.after_end_place;
  const std::vector<std::string>& motors = controller.reference.motors;
  if (controller.reference.position.size() == 0)
    throw InputError(fmt::format("{}: a pose given after a script; allowed: only after a plan", place));
  for (const auto& [joint, value] : stated.landing_pose) {
    if (joint == "*" || std::find(motors.begin(), motors.end(), joint) != motors.end()) continue;
    const auto near = yaml::nearest_name(joint, motors);
    throw InputError(fmt::format("{}.pose: '{}' is no joint with a motor of this robot{}", place, joint,
                                 near ? fmt::format("; did it mean '{}'?", *near) : ""));
  }
  controller.landing_pose.resize(static_cast<Eigen::Index>(motors.size()));
  for (std::size_t m = 0; m < motors.size(); ++m) {
    auto found = stated.landing_pose.find(motors[m]);
    if (found == stated.landing_pose.end()) found = stated.landing_pose.find("*");
    if (found == stated.landing_pose.end())
      throw InputError(
          fmt::format("{}.pose: nothing for '{}'; allowed: a value for every motor, \"*\" for all "
                      "that are not named",
                      place, motors[m]));
    controller.landing_pose[static_cast<Eigen::Index>(m)] = found->second;
  }
  controller.landing_time = stated.landing_time;
}

void set_after_end(const StatedController& stated, Controller& controller) {
  if (stated.after_end == "hold") controller.after_end = AfterEnd::hold;
  if (stated.after_end == "relax") controller.after_end = AfterEnd::relax;
  if (stated.after_end == "repeat") controller.after_end = AfterEnd::repeat;
  if (stated.after_end != "pose") return;
  controller.after_end = AfterEnd::pose;
  set_landing(stated, controller);
}

}  // namespace

Controller stated_controller(const Dataset& dataset, const PlanarModel& model, const AssumedGains& gains) {
  const std::filesystem::path file = dataset.folder / "dataset.yaml";
  Controller controller;
  controller.rate_hz = dataset.controller.rate_hz;
  if (dataset.plan) {
    controller.quantity = quantity_of(dataset.controller.quantity);
    const double bus = dataset.controller.bus_voltage.value_or(model.motors.empty() ? 0.0 : model.motors[0].voltage);
    controller.reference = plan_reference(*dataset.plan, model, controller.quantity, bus, dataset.folder / "plan.csv");
  } else if (dataset.script) {
    controller.quantity = quantity_of(dataset.script->quantity);
    controller.reference = script_reference(*dataset.script, model, file);
    controller.after_end = AfterEnd::repeat;
  } else if (dataset.controller.kind == "measured") {
    throw InputError(
        fmt::format("{}: controller: of kind measured: the log of each trial is its own command; allowed here: a plan, "
                    "or an input",
                    file.string()));
  } else {
    throw InputError(
        fmt::format("{}: plan: none, and no input either; one of them says what was commanded", file.string()));
  }
  for (const auto& [name, value] : dataset.initial) controller.reference.initial[name] = value;
  set_after_end(dataset.controller, controller);
  const auto count = static_cast<Eigen::Index>(controller.reference.motors.size());
  controller.kp = controller.kd = Vector::Zero(count);
  if (dataset.controller.kind != "feedforward_pd") return controller;
  for (Eigen::Index m = 0; m < count; ++m) {
    const std::string& joint = controller.reference.motors[static_cast<size_t>(m)];
    controller.kp[m] = gain_of(dataset.controller.kp, gains.kp, joint);
    controller.kd[m] = gain_of(dataset.controller.kd, gains.kd, joint);
  }
  return controller;
}

}  // namespace jaculus
