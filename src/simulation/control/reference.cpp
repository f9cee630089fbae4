// A plan's table as a reference, the controller that a dataset states, and the pose that a
// reference begins in.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "jaculus/components/motor.h"
#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"
#include "jaculus/simulation/controller.h"
#include "simulation/control/plan_voltage.h"

namespace jaculus::simulation {

namespace {

std::vector<std::string> column_names(const trajectory::Table& table) {
  std::vector<std::string> names;
  for (const trajectory::Column& column : table.columns) names.push_back(column.name);
  return names;
}

[[noreturn]] void missing_column(const trajectory::Table& table, const std::string& name,
                                 const std::string& why, const std::filesystem::path& file) {
  const auto near = yaml::nearest_name(name, column_names(table));
  throw InputError({file.string(), 1, fmt::format("column '{}'", name)},
                   fmt::format("{}, but the file has no such column{}", why,
                               near ? fmt::format("; did it mean '{}'?", *near) : ""));
}

void check_time(const Vector& time, const std::filesystem::path& file) {
  const auto fault = [&file](int row, const std::string& what) {
    return InputError({file.string(), row + 2, "time"}, what);
  };
  for (int k = 0; k < count_of(time); ++k) {
    if (!std::isfinite(time[k])) throw fault(k, "a gap; every sample has its time");
    if (k > 0 && time[k] < time[k - 1])
      throw fault(k,
                  fmt::format("{} s after {} s; a plan's time never falls", time[k], time[k - 1]));
  }
}

/// Row of a plan, without gaps.
Eigen::RowVectorXd plan_row(const trajectory::Table& plan, const std::string& name,
                            const Dimension& dimension, const std::filesystem::path& file) {
  const Vector values = quantity(plan, name, dimension, file);
  for (int k = 0; k < count_of(values); ++k)
    if (!std::isfinite(values[k]))
      throw InputError({file.string(), k + 2, fmt::format("column '{}'", name)},
                       "a gap; a plan has every value");
  return values.transpose();
}

/// By what a plan's duty is multiplied to be one of the bus: the plan's own voltage over it; 1
/// where the plan doesn't tell its own, and within the rounding of columns.
double duty_share(const trajectory::Table& plan, const model::PlanarModel& model, double bus,
                  const std::filesystem::path& file) {
  constexpr double kRounding = 0.01;
  const std::optional<double> own = plan_voltage(plan, model, file);
  return !own || std::abs(*own / bus - 1.0) < kRounding ? 1.0 : *own / bus;
}

/// Feed-forward of one motor in the controller's quantity. `share`: of duty_share.
Eigen::RowVectorXd feedforward(const trajectory::Table& plan, const model::PlanarMotor& motor,
                               Quantity commanded, double bus_voltage, double share,
                               const std::filesystem::path& file) {
  const std::string& joint = motor.joint;
  const auto has = [&](Quantity q) { return plan.column(channel_name(joint, q)) >= 0; };
  const auto row = [&](Quantity q) -> Eigen::RowVectorXd {
    if (!has(q)) missing_column(plan, channel_name(joint, q), "the robot has a motor there", file);
    return plan_row(plan, channel_name(joint, q), trajectory::dimensions_of(q).front(), file);
  };

  // The joint's torque is what a plan means; the motor's follows by the gear of this robot, not by
  // the plan's margin for losses.
  if (commanded == Quantity::torque) return row(commanded) / (motor.gear * motor.efficiency);

  const bool duty = commanded == Quantity::duty;
  if (duty && has(Quantity::duty)) return share * row(Quantity::duty);
  if (!has(Quantity::voltage) && has(Quantity::duty))
    return share * row(Quantity::duty) * bus_voltage;
  return duty ? row(Quantity::voltage) / bus_voltage : row(Quantity::voltage);
}

/// Whether inputs are held over Hermite-Simpson intervals: in every phase the second, fourth, ...
/// sample repeats the one before.
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

Reference plan_reference(const trajectory::Table& plan, const model::PlanarModel& model,
                         Quantity commanded, double bus_voltage,
                         const std::filesystem::path& file) {
  Reference reference;
  if (plan.column("time") < 0) missing_column(plan, "time", "a plan has its time", file);
  reference.time = quantity(plan, "time", dimension::time, file);
  check_time(reference.time, file);
  const Eigen::Index samples = reference.time.size();
  reference.duration = reference.time[samples - 1];
  const auto motors = std::ssize(model.motors);
  reference.position.resize(motors, samples);
  reference.velocity.resize(motors, samples);
  reference.feedforward.resize(motors, samples);
  const double share =
      commanded == Quantity::torque ? 1.0 : duty_share(plan, model, bus_voltage, file);

  for (Eigen::Index m = 0; m < motors; ++m) {
    const model::PlanarMotor& motor = model.motors[m];
    const bool angular = !model.slides(motor);
    const std::string rate = channel_name(motor.joint, Quantity::velocity);
    for (const std::string& name : {motor.joint, rate})
      if (plan.column(name) < 0) missing_column(plan, name, "the robot has a motor there", file);
    reference.motors.push_back(motor.joint);
    reference.position.row(m) =
        plan_row(plan, motor.joint, angular ? dimension::angle : dimension::length, file);
    reference.velocity.row(m) =
        plan_row(plan, rate, angular ? dimension::angular_velocity : dimension::velocity, file);
    reference.feedforward.row(m) = feedforward(plan, motor, commanded, bus_voltage, share, file);
    reference.initial[motor.joint] = reference.position(m, 0);
  }

  for (const model::Coordinate& c : model.coordinates) {
    if (plan.column(c.name) < 0) continue;
    reference.initial[c.name] =
        plan_row(plan, c.name, c.angular ? dimension::angle : dimension::length, file)[0];
  }

  reference.linear = !looks_held(reference);
  return reference;
}

namespace {

double gain_of(const std::map<std::string, trajectory::StatedGain>& stated,
               const std::map<std::string, double>& assumed, const std::string& joint) {
  auto found = stated.find(joint);
  if (found == stated.end()) found = stated.find("*");
  if (found != stated.end() && found->second.known()) return found->second.range.lower;
  const auto value = assumed.find(joint);
  return value == assumed.end() ? 0.0 : value->second;
}

/// ", did you mean 'tail'?; allowed: front_a, tail", of the joints with a motor.
std::string motors_instead_of(const std::string& joint, const model::PlanarModel& model) {
  std::vector<std::string> motors;
  for (const model::PlanarMotor& motor : model.motors) motors.push_back(motor.joint);
  return fmt::format("{}; allowed: {}", yaml::did_you_mean(joint, motors), fmt::join(motors, ", "));
}

/// Refuses gains of a joint that the robot hasn't: they would be nobody's. A joint that stands
/// still in this experiment keeps those of the others.
void check_gain_names(const std::map<std::string, trajectory::StatedGain>& gains, const char* key,
                      const model::PlanarModel& model, const trajectory::Dataset& dataset) {
  for (const auto& [joint, gain] : gains) {
    const bool held = std::any_of(model.held.begin(), model.held.end(),
                                  [&](const model::HeldJoint& own) { return own.joint == joint; });
    if (joint == "*" || held || model.body_of_joint(joint) >= 0) continue;
    throw InputError(dataset.place_of(key), fmt::format("'{}' is no joint of this robot{}", joint,
                                                        motors_instead_of(joint, model)));
  }
}

/// A row of logged currents turns into the torques that the motor makes of them before its gear;
/// the drive applies gear and efficiency, as to every torque.
void currents_to_torques(const model::PlanarMotor& motor, const InputPlace& place,
                         Reference& reference, Eigen::Index row) {
  if (motor.ideal())
    throw InputError(
        place, fmt::format("current given, but the motor of '{}' is ideal, without a torque "
                           "constant; allowed: torque, or a robot.yaml whose motor there is of "
                           "kind electric",
                           motor.joint));
  for (double& value : reference.feedforward.row(row))
    value = components::saturated_torque(motor.saturation_linear, motor.saturation_cubic, value);
}

/// A script's columns for the motors of a robot; a motor that it leaves out has no command.
Reference script_reference(const trajectory::Dataset& dataset, const model::PlanarModel& model) {
  const trajectory::InputScript& script = *dataset.script;
  Reference reference;
  reference.time = script.time;
  reference.duration = script.time.size() > 0 ? script.time[script.time.size() - 1] : 0.0;
  for (std::size_t j = 0; j < script.joints.size(); ++j) {
    const int m = model.motor_index(script.joints[j]);
    if (m < 0)
      throw InputError(dataset.place_of("input"),
                       fmt::format("'{}' is no joint with a motor of this robot{}",
                                   script.joints[j], motors_instead_of(script.joints[j], model)));
    reference.motors.push_back(script.joints[j]);
  }

  reference.feedforward = script.values;
  for (int j = 0; j < count_of(script.joints); ++j) {
    const model::PlanarMotor& motor = model.motors[model.motor_index(script.joints[j])];
    if (script.quantity == Quantity::torque)
      reference.feedforward.row(j) /= motor.gear * motor.efficiency;
    if (script.quantity == Quantity::current)
      currents_to_torques(motor, dataset.place_of("controller.input"), reference, j);
  }

  return reference;
}

/// The pose to land in for every motor of the reference.
void set_landing(const trajectory::Dataset& dataset, Controller& controller) {
  const trajectory::StatedController& stated = dataset.controller;
  const InputPlace end = dataset.place_of("controller.after_end");
  const InputPlace pose{end.file, end.line, end.key + ".pose"};
  const std::vector<std::string>& motors = controller.reference.motors;
  if (controller.reference.position.size() == 0)
    throw InputError(end, "a pose given after a script; allowed: only after a plan");
  for (const auto& [joint, value] : stated.landing_pose) {
    if (joint == "*" || std::find(motors.begin(), motors.end(), joint) != motors.end()) continue;
    const auto near = yaml::nearest_name(joint, motors);
    throw InputError(pose, fmt::format("'{}' is no joint with a motor of this robot{}", joint,
                                       near ? fmt::format("; did it mean '{}'?", *near) : ""));
  }

  controller.landing_pose.resize(motors.size());
  for (int m = 0; m < count_of(motors); ++m) {
    auto found = stated.landing_pose.find(motors[m]);
    if (found == stated.landing_pose.end()) found = stated.landing_pose.find("*");
    if (found == stated.landing_pose.end())
      throw InputError(pose, fmt::format("nothing for '{}'; allowed: a value for every motor, "
                                         "\"*\" for all that are not named",
                                         motors[m]));
    controller.landing_pose[m] = found->second;
  }

  controller.landing_time = stated.landing_time;
}

void set_after_end(const trajectory::Dataset& dataset, Controller& controller) {
  if (dataset.controller.after_end) controller.after_end = *dataset.controller.after_end;
  if (controller.after_end == AfterEnd::pose) set_landing(dataset, controller);
}

}  // namespace

Controller stated_controller(const trajectory::Dataset& dataset, const model::PlanarModel& model,
                             const AssumedGains& gains) {
  Controller controller;
  controller.rate_hz = dataset.controller.rate_hz;
  if (dataset.plan) {
    controller.quantity = dataset.controller.quantity;
    const double bus = dataset.controller.bus_voltage.value_or(
        model.motors.empty() ? 0.0 : model.motors[0].voltage);
    controller.reference =
        plan_reference(*dataset.plan, model, controller.quantity, bus, dataset.folder / "plan.csv");
  } else if (dataset.script) {
    // currents are turned into the torques that they make
    const bool logged_current = dataset.script->quantity == Quantity::current;
    controller.quantity = logged_current ? Quantity::torque : dataset.script->quantity;
    controller.reference = script_reference(dataset, model);
    controller.after_end = AfterEnd::repeat;
  } else if (dataset.controller.kind == trajectory::ControllerKind::measured) {
    throw InputError(dataset.place_of("controller"),
                     "of kind measured: the log of each trial is its own command; allowed here: a "
                     "plan, or an input");
  } else {
    throw InputError(dataset.place_of("plan"),
                     "none, and no input either; one of them says what was commanded");
  }

  for (const auto& [name, value] : dataset.initial) controller.reference.initial[name] = value;
  set_after_end(dataset, controller);
  const auto count = std::ssize(controller.reference.motors);
  controller.kp = controller.kd = Vector::Zero(count);
  if (dataset.controller.kind != trajectory::ControllerKind::feedforward_pd) return controller;
  check_gain_names(dataset.controller.kp, "controller.kp", model, dataset);
  check_gain_names(dataset.controller.kd, "controller.kd", model, dataset);

  for (Eigen::Index m = 0; m < count; ++m) {
    const std::string& joint = controller.reference.motors[m];
    controller.kp[m] = gain_of(dataset.controller.kp, gains.kp, joint);
    controller.kd[m] = gain_of(dataset.controller.kd, gains.kd, joint);
  }

  return controller;
}

}  // namespace jaculus::simulation
