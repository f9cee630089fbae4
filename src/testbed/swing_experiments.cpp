// Experiments of smooth swings: robots on a fixed base, legs in the air and on a stand.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/error.h"
#include "jaculus/testbed/trials.h"
#include "testbed/drives.h"
#include "testbed/experiment_parts.h"
#include "testbed/swings.h"

namespace jaculus::testbed {
namespace {

using trajectory::ControllerKind;
using trajectory::ExperimentKind;
using trajectory::Quantity;

constexpr double kSwingTime = 2.0;      ///< [s]
constexpr double kDropTime = 0.3;       ///< in which a robot falls by 0.44 m [s]
constexpr double kDropHeight = 1.2;     ///< of the base [m]
constexpr double kSampling = 0.01;      ///< of commands [s]
constexpr double kDropSampling = 2e-3;  ///< [s]
constexpr double kTracked = 0.3;        ///< largest swing of a reference [rad]
constexpr double kDropTracked = 0.15;   ///< [rad]
constexpr double kTorqueShare = 0.1;    ///< swing of the torque, of what gravity takes at most [-]
constexpr double kVoltageRate = 1.5;    ///< at which back-EMF takes a voltage's swing [rad/s]
// A loop that tracks: bandwidth and damping of the load alone; between half and twice such gains
// its robot is as well behaved.
constexpr double kBandwidth = 25.0;  ///< [rad/s]
constexpr double kLoopDamping = 0.7;
constexpr double kGainRange = 2.0;  ///< stated gains reach from design/this to design x this [-]

Vector grid(double duration, double sampling) {
  return Vector::LinSpaced(std::lround(duration / sampling) + 1, 0.0, duration);
}

/// A plan that swings every motor about rest, with what holds it there as feed-forward.
trajectory::Table swing_plan(const RobotFiles& files, const Vector& time, double amplitude) {
  trajectory::Table table;
  table.columns.push_back({"time", "s"});
  table.values = time;
  for (int j = 0; j < count_of(files.planar_motors); ++j) {
    const std::string& name = files.planar_motors[j];
    const Swing swing = swing_of(time, j);
    const Vector hold = Vector::Constant(time.size(), load_of(files, name).hold);
    set_column(table, name, "rad", files.rest_of(name) + amplitude * swing.value.array());
    set_column(table, channel_name(name, Quantity::velocity), "rad/s", amplitude * swing.rate);
    set_column(table, channel_name(name, Quantity::torque), "N m", hold);
  }
  return table;
}

/// Swings about the voltages or torques that hold every motor at rest; the sides of a pair hear the
/// same.
trajectory::InputScript swing_script(const RobotFiles& files, Quantity quantity) {
  trajectory::InputScript script;
  script.quantity = quantity;
  script.joints = files.planar_motors;
  script.time = grid(kSwingTime, kSampling);
  script.values.resize(std::ssize(script.joints), script.time.size());

  for (int j = 0; j < count_of(script.joints); ++j) {
    const model::PlanarMotor& motor = *files.motor_of(script.joints[j]);
    const Load load = load_of(files, script.joints[j]);
    double middle = load.hold, amplitude = kTorqueShare * load.weight;
    if (quantity == Quantity::voltage) {
      const double current = current_of_torque(motor, load.hold / (motor.gear * motor.efficiency));
      middle = motor.resistance * current;
      amplitude = kVoltageRate * motor.torque_constant * motor.gear;
    }
    script.values.row(j) =
        (middle + amplitude * swing_of(script.time, j).value.array()).transpose();
  }

  return script;
}

/// Gains within a factor of those that would suit what hangs on each joint.
void state_gain_ranges(trajectory::Dataset& dataset, const RobotFiles& files) {
  trajectory::StatedController& c = dataset.controller;
  for (const std::string& name : files.planar_motors) {
    const model::PlanarMotor& motor = *files.motor_of(name);
    const double per_shaft =
        load_of(files, name).inertia / (motor.gear * motor.gear * motor.efficiency);
    const double p = kBandwidth * kBandwidth * per_shaft;
    const double d = 2.0 * kLoopDamping * kBandwidth * per_shaft;
    c.kp[name].range = {p / kGainRange, p * kGainRange};
    c.kd[name].range = {d / kGainRange, d * kGainRange};
  }
}

void start_at_rest(trajectory::Dataset& dataset, const RobotFiles& files) {
  for (const std::string& name : files.planar_motors) dataset.initial[name] = files.rest_of(name);
}

void drive_by_script(trajectory::Dataset& dataset, const RobotFiles& files, ControllerKind kind,
                     Quantity quantity) {
  dataset.controller.kind = kind;
  dataset.controller.quantity = quantity;
  dataset.controller.quantity_stated = dataset.controller.gains_stated = true;
  dataset.script = swing_script(files, quantity);
}

bool has_windings(const RobotFiles& files) {
  return std::none_of(files.drives.begin(), files.drives.end(),
                      [](const Drive& drive) { return drive.motor.ideal(); });
}

[[noreturn]] void refuse_robot(const RobotFiles& files, const std::string& given,
                               const std::string& allowed) {
  throw InputError(fmt::format("robot '{}': {}; allowed: {}", files.name, given, allowed));
}

/// A robot of legs alone, for what a robot with a tail does otherwise.
void need_legs_alone(const RobotFiles& files, const std::string& what) {
  if (!files.floating)
    refuse_robot(files, "a fixed base", fmt::format("for {}: a floating one", what));
  if (!files.pins.empty()) refuse_robot(files, "legs with pins", fmt::format("for {}: none", what));
  if (!files.motors_of(Limb::tail).empty())
    refuse_robot(files, "a tail", fmt::format("for {}: legs alone", what));
}

}  // namespace

bool can_swing(const RobotFiles& files, SwingInput input) {
  return !files.floating && files.pins.empty() && !files.drives.empty() &&
         files.motors_of(Limb::tail).empty() &&
         (input != SwingInput::voltage || has_windings(files));
}

bool can_swing_legs(const RobotFiles& files) {
  return files.floating && files.pins.empty() && files.motors_of(Limb::tail).empty() &&
         has_windings(files);
}

const NameTable<SwingInput>& swing_inputs() {
  static const NameTable<SwingInput> kNames({{SwingInput::torque, "torque"},
                                             {SwingInput::logged_torque, "logged_torque"},
                                             {SwingInput::unknown_gains, "unknown_gains"},
                                             {SwingInput::voltage, "voltage"}});
  return kNames;
}

trajectory::Dataset swing(const std::filesystem::path& robot_folder, SwingInput input) {
  const RobotFiles files = read_robot_files(robot_folder);
  if (!can_swing(files, input)) {
    refuse_robot(files, "no robot for a swing",
                 "a fixed base, a motor or more, neither tail nor pins; for voltages motors with "
                 "windings");
  }

  trajectory::Dataset dataset;
  dataset.experiment = ExperimentKind::pendulum;
  dataset.robot = robot_name(robot_folder);
  start_at_rest(dataset, files);

  switch (input) {
    case SwingInput::torque:
      drive_by_script(dataset, files, ControllerKind::torque, Quantity::torque);
      break;
    case SwingInput::logged_torque:
      drive_by_script(dataset, files, ControllerKind::measured, Quantity::torque);
      dataset.controller.input = Quantity::torque;
      break;
    case SwingInput::voltage:
      drive_by_script(dataset, files, ControllerKind::voltage, Quantity::voltage);
      break;
    case SwingInput::unknown_gains:
      state_gains(dataset, files, Quantity::torque);
      state_gain_ranges(dataset, files);
      dataset.plan = swing_plan(files, grid(kSwingTime, kSampling), kTracked);
      break;
  }
  return dataset;
}

trajectory::Dataset leg_drop(const std::filesystem::path& robot_folder) {
  const RobotFiles files = read_robot_files(robot_folder);
  need_legs_alone(files, "a drop");
  trajectory::Dataset dataset;
  dataset.experiment = ExperimentKind::self_righting;
  dataset.robot = robot_name(robot_folder);
  state_gains(dataset, files, Quantity::torque);
  dataset.plan = swing_plan(files, grid(kDropTime, kDropSampling), kDropTracked);
  // nothing hangs on the joints of a robot that falls
  for (const std::string& name : files.planar_motors) {
    set_column(*dataset.plan, channel_name(name, Quantity::torque), "N m",
               Vector::Zero(dataset.plan->values.rows()));
  }
  dataset.initial = {{"x", 0.0}, {"z", kDropHeight}, {"pitch", 0.0}};
  return dataset;
}

trajectory::Dataset leg_bench(const std::filesystem::path& robot_folder) {
  const RobotFiles files = read_robot_files(robot_folder);
  need_legs_alone(files, "a bench");
  if (!has_windings(files))
    refuse_robot(files, "ideal motors", "for a bench: motors with windings");
  trajectory::Dataset dataset;
  dataset.experiment = ExperimentKind::tail_bench;
  dataset.robot = robot_name(robot_folder);
  drive_by_script(dataset, files, ControllerKind::voltage, Quantity::voltage);
  start_at_rest(dataset, files);
  return dataset;
}

}  // namespace jaculus::testbed
