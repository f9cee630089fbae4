// The testbed's experiments as datasets without trials.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/error.h"
#include "jaculus/model/robot.h"
#include "jaculus/testbed/trials.h"
#include "testbed/commands.h"
#include "testbed/drives.h"
#include "testbed/experiment_parts.h"
#include "testbed/sizes.h"

namespace jaculus::testbed {
namespace {

using trajectory::ControllerKind;
using trajectory::ExperimentKind;
using trajectory::Quantity;

// Gains of a replay loop, in duty a radian and duty a rad/s of the joint; as torque, what a duty
// gives at stall.
constexpr double kLegP = 0.4, kLegD = 0.01, kTailP = 1.0, kTailD = 0.01;

bool is_tail(const RobotFiles& files, const std::string& motor) {
  const std::vector<std::string> tail = files.motors_of(Limb::tail);
  return std::find(tail.begin(), tail.end(), motor) != tail.end();
}

/// Motors of the tail, of which an experiment needs one.
std::vector<std::string> need_tail(const RobotFiles& files, ExperimentKind kind) {
  const std::vector<std::string> tail = files.motors_of(Limb::tail);
  if (!tail.empty()) return tail;
  throw InputError(
      fmt::format("robot '{}': no tail (a link with drag behind a motor); allowed for {}: a robot "
                  "with one",
                  files.name, name_of(kind)));
}

/// Torque before the gear that full duty gives at stall, without saturation; what an ideal motor
/// may give [N m].
double stall_torque(const model::PlanarMotor& motor) {
  if (!motor.ideal()) return round_figure(motor.torque_constant * motor.voltage / motor.resistance);
  return std::isfinite(motor.torque_limit) ? motor.torque_limit : 1.0;
}

}  // namespace

void state_gains(trajectory::Dataset& dataset, const RobotFiles& files, Quantity quantity) {
  trajectory::StatedController& c = dataset.controller;
  c.kind = ControllerKind::feedforward_pd;
  c.quantity = quantity;
  c.quantity_stated = c.gains_stated = true;
  for (const std::string& name : files.planar_motors) {
    const model::PlanarMotor& motor = *files.motor_of(name);
    const bool tail = is_tail(files, name);
    const double unit = quantity == Quantity::duty ? 1.0 : stall_torque(motor);
    const double p = unit * ((tail ? kTailP : kLegP) / motor.gear);
    const double d = unit * ((tail ? kTailD : kLegD) / motor.gear);
    c.kp[name].range = {p, p};
    c.kd[name].range = {d, d};
    if (quantity == Quantity::duty) c.bus_voltage = motor.voltage;
  }
}

void set_column(trajectory::Table& table, const std::string& name, const std::string& unit,
                const Vector& values) {
  int index = table.column(name);
  if (index < 0) {
    index = count_of(table.columns);
    table.columns.push_back({name, unit});
    table.values.conservativeResize(table.values.rows(), index + 1);
  }
  table.columns[index].unit = unit;
  table.values.col(index) = values;
}

std::string robot_name(const std::filesystem::path& folder) {
  const std::filesystem::path whole = std::filesystem::weakly_canonical(folder);
  const std::string name = whole.filename().string();
  try {
    const auto found = model::find_robot(name, whole.parent_path() / name / "none");
    if (std::filesystem::weakly_canonical(found) == whole) return name;
  } catch (const InputError&) {
    return whole.string();
  }
  return whole.string();
}

namespace {

/// Duty that gives the plan's torques at its rates on the believed motor: (R i + k_t w)/V.
void set_duty(trajectory::Table& table, const RobotFiles& files, const PlanCommands& plan) {
  for (int m = 0; m < count_of(plan.commands.motors); ++m) {
    const std::string& name = plan.commands.motors[m];
    const model::PlanarMotor& motor = *files.motor_of(name);
    Vector duty(plan.commands.time.size());
    for (Eigen::Index k = 0; k < duty.size(); ++k) {
      const double current = current_of_torque(motor, plan.commands.feedforward(m, k));
      const double emf = motor.torque_constant * motor.gear * plan.commands.velocity(m, k);
      duty[k] = (motor.resistance * current + emf) / motor.voltage;
    }
    set_column(table, channel_name(name, Quantity::duty), "-", duty);
  }
}

/// A table from 0 to `duration` with every motor at rest, the tail's at 0.
trajectory::Table rest_plan(const RobotFiles& files, double duration) {
  trajectory::Table table;
  table.columns.push_back({"time", "s"});
  table.values = Vector::LinSpaced(3, 0.0, duration);
  const Vector zero = Vector::Zero(3);
  for (const std::string& name : files.planar_motors) {
    const double rest = is_tail(files, name) ? 0.0 : files.rest_of(name);
    set_column(table, name, "rad", Vector::Constant(3, rest));
    set_column(table, channel_name(name, Quantity::velocity), "rad/s", zero);
    set_column(table, channel_name(name, Quantity::duty), "-", zero);
  }
  return table;
}

/// Limit of a pendulum's motor at the joint; 5 N m where none is stated [N m].
double pendulum_torque(const model::PlanarMotor& motor) {
  const double limit = std::isfinite(motor.torque_limit) ? motor.torque_limit : 5.0;
  return limit * motor.gear * motor.efficiency;
}

}  // namespace

trajectory::Dataset leap(const std::filesystem::path& robot_folder,
                         const std::filesystem::path& plan, Quantity quantity) {
  const RobotFiles files = read_robot_files(robot_folder);
  trajectory::Dataset dataset;
  dataset.experiment = ExperimentKind::leap;
  dataset.robot = robot_name(robot_folder);
  dataset.plan = trajectory::read_csv(plan);
  const PlanCommands commands = plan_commands(*dataset.plan, files, Quantity::torque, plan);
  if (quantity == Quantity::duty) set_duty(*dataset.plan, files, commands);
  state_gains(dataset, files, quantity);
  return dataset;
}

trajectory::Dataset self_righting(const std::filesystem::path& robot_folder) {
  const RobotFiles files = read_robot_files(robot_folder);
  const std::vector<std::string> tails = need_tail(files, ExperimentKind::self_righting);
  trajectory::Dataset dataset;
  dataset.experiment = ExperimentKind::self_righting;
  dataset.robot = robot_name(robot_folder);
  state_gains(dataset, files, Quantity::duty);
  dataset.controller.after_end = trajectory::AfterEnd::repeat;
  trajectory::Table table = rest_plan(files, 0.3);

  for (const std::string& tail : tails) {
    const Bounds& range = files.joint_of(tail).range;
    if (!std::isfinite(range.lower) || !std::isfinite(range.upper)) {
      throw InputError(
          fmt::format("robot '{}': joint '{}' has no stops; allowed for {}: a tail with a range",
                      files.name, tail, name_of(dataset.experiment)));
    }
    dataset.controller.kp[tail].range = dataset.controller.kd[tail].range = {0.0, 0.0};
    dataset.stops[tail].range = range;
    set_column(table, tail, "rad", Vector::Constant(3, range.lower));
    set_column(table, channel_name(tail, Quantity::duty), "-", Vector::Ones(3));
  }

  dataset.plan = table;
  dataset.initial = {{"x", 0.0}, {"z", 1.0}, {"pitch", 0.0}};
  return dataset;
}

trajectory::Dataset tail_bench(const std::filesystem::path& robot_folder) {
  const RobotFiles files = read_robot_files(robot_folder);
  const std::vector<std::string> tails = need_tail(files, ExperimentKind::tail_bench);
  trajectory::Dataset dataset;
  dataset.experiment = ExperimentKind::tail_bench;
  dataset.robot = robot_name(robot_folder);
  dataset.controller.kind = ControllerKind::voltage;
  dataset.controller.quantity = Quantity::voltage;
  dataset.controller.quantity_stated = dataset.controller.gains_stated = true;
  trajectory::InputScript script;
  script.joints = {tails.front()};
  script.time.resize(6);
  script.time << 0.0, 0.05, 0.15, 0.25, 0.35, 0.4;
  script.values.resize(1, 6);
  script.values << 0.5, -0.5, 0.5, -0.5, 0.5, 0.0;  // of the bus voltage
  script.values *= files.motor_of(tails.front())->voltage;
  dataset.script = script;
  for (const std::string& name : files.planar_motors)
    dataset.initial[name] = is_tail(files, name) ? 0.0 : files.rest_of(name);

  return dataset;
}

trajectory::Dataset pendulum(const std::filesystem::path& robot_folder) {
  const RobotFiles files = read_robot_files(robot_folder);
  if (files.planar_motors.size() != 1 || files.floating) {
    throw InputError(
        fmt::format("robot '{}': {} motors; allowed for a pendulum: one, on a fixed base",
                    files.name, files.planar_motors.size()));
  }

  trajectory::Dataset dataset;
  dataset.experiment = ExperimentKind::pendulum;
  dataset.robot = robot_name(robot_folder);
  dataset.controller.kind = ControllerKind::torque;
  dataset.controller.quantity = Quantity::torque;
  dataset.controller.quantity_stated = dataset.controller.gains_stated = true;
  trajectory::InputScript script;
  script.quantity = Quantity::torque;
  script.joints = files.planar_motors;
  script.time.resize(5);
  script.time << 0.0, 0.3, 0.8, 1.2, 2.0;
  script.values.resize(1, 5);
  script.values << 0.4, -0.5, 0.2, 0.0, 0.0;  // of the motor's limit at the joint
  script.values *= pendulum_torque(*files.motor_of(files.planar_motors.front()));
  dataset.script = script;
  dataset.initial = {{files.planar_motors.front(), 0.0}};

  return dataset;
}

}  // namespace jaculus::testbed
