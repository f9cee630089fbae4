// The testbed's experiments as datasets without trials.

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "jaculus/core/error.h"
#include "jaculus/testbed/trials.h"
#include "testbed/commands.h"
#include "testbed/drives.h"

namespace jaculus::testbed {
namespace {

// Gains of the robot's replay loop, in duty a radian and duty a rad/s; as torque, what a duty gives at stall.
constexpr double kLegP = 0.4, kLegD = 0.01, kTailP = 1.0, kTailD = 0.01;

const PlanarMotor& motor_of(const RobotFiles& files, const std::string& planar) {
  for (const Drive& drive : files.drives) {
    if (drive.planar == planar) return drive.motor;
  }
  throw InputError(fmt::format("robot '{}' has no motor '{}'", files.name, planar));
}

bool is_tail(const std::string& motor) { return motor == "tail"; }

void state_gains(Dataset& dataset, const RobotFiles& files, const std::string& quantity) {
  StatedController& c = dataset.controller;
  c.kind = "feedforward_pd";
  c.quantity = quantity;
  c.quantity_stated = c.gains_stated = true;
  for (const std::string& name : files.planar_motors) {
    const PlanarMotor& motor = motor_of(files, name);
    const double unit = quantity == "duty" ? 1.0 : 8.2;  // N m at stall, 16 V on 0.186 ohm without saturation
    const double p = unit * (is_tail(name) ? kTailP / motor.gear : kLegP);
    const double d = unit * (is_tail(name) ? kTailD / motor.gear : kLegD);
    c.kp[name].range = {p, p};
    c.kd[name].range = {d, d};
    if (quantity == "duty") c.bus_voltage = motor.voltage;
  }
}

void set_column(Table& table, const std::string& name, const std::string& unit, const Vector& values) {
  int index = table.column(name);
  if (index < 0) {
    index = static_cast<int>(table.columns.size());
    table.columns.push_back({name, unit});
    table.values.conservativeResize(table.values.rows(), index + 1);
  }
  table.columns[static_cast<std::size_t>(index)].unit = unit;
  table.values.col(index) = values;
}

/// Duty that gives the plan's torques at its rates on the believed motor: (R i + k_t w)/V.
void set_duty(Table& table, const RobotFiles& files, const PlanCommands& plan) {
  for (std::size_t m = 0; m < plan.commands.motors.size(); ++m) {
    const std::string& name = plan.commands.motors[m];
    const PlanarMotor& motor = motor_of(files, name);
    const auto row = static_cast<Eigen::Index>(m);
    Vector duty(plan.commands.time.size());
    for (Eigen::Index k = 0; k < duty.size(); ++k) {
      const double current = current_of_torque(motor, plan.commands.feedforward(row, k));
      const double emf = motor.torque_constant * motor.gear * plan.commands.velocity(row, k);
      duty[k] = (motor.resistance * current + emf) / motor.voltage;
    }
    set_column(table, name + "_duty", "-", duty);
  }
}

std::string robot_name(const std::filesystem::path& folder) { return folder.filename().string(); }

/// A table of `samples` rows from 0 to `duration` with legs at rest at `leg` and the tail as told.
Table rest_plan(const RobotFiles& files, double duration, double leg) {
  Table table;
  table.columns.push_back({"time", "s"});
  table.values = Vector::LinSpaced(3, 0.0, duration);
  const Vector zero = Vector::Zero(3);
  for (const std::string& name : files.planar_motors) {
    set_column(table, name, "rad", is_tail(name) ? zero : Vector(Vector::Constant(3, leg)));
    set_column(table, name + "_velocity", "rad/s", zero);
    set_column(table, name + "_duty", "-", zero);
  }
  return table;
}

}  // namespace

Dataset leap(const std::filesystem::path& robot_folder, const std::filesystem::path& plan,
             const std::string& quantity) {
  const RobotFiles files = read_robot_files(robot_folder);
  Dataset dataset;
  dataset.experiment = "leap";
  dataset.robot = robot_name(robot_folder);
  dataset.plan = read_csv(plan);
  const PlanCommands commands = plan_commands(*dataset.plan, files, "torque", plan);
  if (quantity == "duty") set_duty(*dataset.plan, files, commands);
  state_gains(dataset, files, quantity);
  return dataset;
}

Dataset self_righting(const std::filesystem::path& robot_folder) {
  const RobotFiles files = read_robot_files(robot_folder);
  Dataset dataset;
  dataset.experiment = "self_righting";
  dataset.robot = robot_name(robot_folder);
  state_gains(dataset, files, "duty");
  dataset.controller.kp["tail"].range = {0.0, 0.0};
  dataset.controller.kd["tail"].range = {0.0, 0.0};
  dataset.controller.after_end = "repeat";
  Table table = rest_plan(files, 0.3, 1.0);
  set_column(table, "tail", "rad", Vector::Constant(3, -0.5 * std::numbers::pi));
  set_column(table, "tail_duty", "-", Vector::Ones(3));
  dataset.plan = table;
  dataset.stops["tail"].range = {-0.5 * std::numbers::pi, 0.5 * std::numbers::pi};
  dataset.initial = {{"x", 0.0}, {"z", 1.0}, {"pitch", 0.0}};
  return dataset;
}

Dataset tail_bench(const std::filesystem::path& robot_folder) {
  const RobotFiles files = read_robot_files(robot_folder);
  (void)motor_of(files, "tail");
  Dataset dataset;
  dataset.experiment = "tail_bench";
  dataset.robot = robot_name(robot_folder);
  dataset.controller.kind = dataset.controller.quantity = "voltage";
  dataset.controller.quantity_stated = dataset.controller.gains_stated = true;
  InputScript script;
  script.joints = {"tail"};
  script.time.resize(6);
  script.time << 0.0, 0.05, 0.15, 0.25, 0.35, 0.4;
  script.values.resize(1, 6);
  script.values << 8.0, -8.0, 8.0, -8.0, 8.0, 0.0;
  dataset.script = script;
  for (const std::string& name : files.planar_motors) dataset.initial[name] = is_tail(name) ? 0.0 : 1.0;
  return dataset;
}

Dataset pendulum(const std::filesystem::path& robot_folder) {
  const RobotFiles files = read_robot_files(robot_folder);
  if (files.planar_motors.size() != 1 || files.floating) {
    throw InputError(fmt::format("robot '{}': {} motors; allowed for a pendulum: one, on a fixed base", files.name,
                                 files.planar_motors.size()));
  }
  Dataset dataset;
  dataset.experiment = "pendulum";
  dataset.robot = robot_name(robot_folder);
  dataset.controller.kind = dataset.controller.quantity = "torque";
  dataset.controller.quantity_stated = dataset.controller.gains_stated = true;
  InputScript script;
  script.quantity = "torque";
  script.joints = files.planar_motors;
  script.time.resize(5);
  script.time << 0.0, 0.3, 0.8, 1.2, 2.0;
  script.values.resize(1, 5);
  script.values << 2.0, -2.5, 1.0, 0.0, 0.0;
  dataset.script = script;
  dataset.initial = {{files.planar_motors.front(), 0.0}};
  return dataset;
}

}  // namespace jaculus::testbed
