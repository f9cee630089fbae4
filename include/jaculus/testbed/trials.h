#pragma once
// Trials on the MuJoCo robot, as a dataset: what a real robot's motion capture and logs would hold,
// and nothing else.
//
// A dataset without trials says what is to be done: robot, plan or script, controller, initial
// pose. Motion capture sees the base's origin, x and pitch relative to rest; joint channels are the
// mean of the left and the right encoder. White noise, rounding of encoders, unknown shifts of
// clocks, lost samples.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "jaculus/core/names.h"
#include "jaculus/testbed/changes.h"
#include "jaculus/testbed/lost.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::testbed {

/// Whether this build has MuJoCo. Without it everything that plays throws InputError saying what to
/// install.
bool available();

/// How noise differs from white and normal (sensor_noise.h). Default-built: it doesn't.
struct NoiseShape {
  double coloured = 0.0;           ///< share of the variance that is correlated in time [-]
  double correlation_time = 0.02;  ///< of that share [s]
  double tails = 0.0;              ///< degrees of freedom of Student's t, above 2; 0: normal [-]
};

struct SensorSpec {
  bool mocap = true;
  double mocap_rate_hz = 240.0;
  double mocap_position = 3e-4;   ///< noise, standard deviation [m]
  double mocap_angle = 2.618e-3;  ///< noise, 0.15 deg [rad]
  double mocap_lost = 0.0;        ///< share of samples that are lost [-]
  bool joints = true;
  double joints_rate_hz = 1000.0;
  double encoder = 1e-3;           ///< noise of one encoder [rad]
  double encoder_step = 3.835e-4;  ///< its resolution at the motor's shaft, 14 bit [rad]
  double tachometer = 0.05;        ///< noise of one motor's rate [rad/s]
  bool rates = true;               ///< whether joint rates are logged
  bool electric = true;            ///< whether current, duty and bus voltage are logged
  double ammeter = 0.1;            ///< noise [A]
  double voltmeter = 0.02;         ///< noise [V]
  bool imu = false;                ///< imu_pitch and its rate, beside the joints
  double imu_angle = 3e-3;         ///< noise [rad]
  double imu_rate = 0.02;          ///< noise [rad/s]
  NoiseShape shape;                ///< of every noise above
  double joints_lost = 0.0;        ///< share of the joints' samples that are lost [-]
  double clock_drift = 0.0;        ///< of each stream's rate, standard deviation [-]
  double ammeter_step = 0.0;       ///< of the current's converter [A]
  double ammeter_filter = 0.0;     ///< time constant of the current's low pass [s]
  bool torque = false;             ///< whether each motor's torque is logged, as from its current
  double torque_noise = 0.0;       ///< of it, share of the largest torque logged [-]
  double torque_step = 0.0;        ///< of its converter, share of the largest torque logged [-]
};

struct TrialSpec {
  int trials = 6;
  std::uint64_t seed = 1;
  bool exact = false;   ///< no noise, scatter or rounding: for measurements on the robot itself
  double after = 0.08;  ///< recorded beyond the commands' end [s]
  double pose_scatter = 2e-3;   ///< of every joint at the start [rad]
  double clock_scatter = 2e-3;  ///< of each stream's zero [s]
  /// of joints at the start, by their planar names [rad]
  std::map<std::string, double> start_offset;
  /// The robot is off its files by a draw from its tolerances (a robot of its own for each seed);
  /// nothing: it is what its files say.
  std::optional<std::uint64_t> clutter_seed;
  /// Where the robot's gains lie within ranges that the dataset states, of all joints alike: 0 at
  /// the lower end, 1 at the upper, by their logarithms. InputError for a range from 0 or without
  /// end.
  double kp_place = 0.5, kd_place = 0.5;
  SensorSpec sensors;
};

/// Plays the trials of `asked` (its own are replaced). Streams are cut to the experiment's
/// duration. InputError for a robot or commands that do not fit, UnreachablePose among
/// them; LostRobot where the simulation is lost. `legs_apart`, if asked for: by how much the left
/// and the right motor of a pair part at most until the commands end [rad]; nothing couples them
/// but base and floor.
trajectory::Dataset run_trials(const trajectory::Dataset& asked, const Changes& changes,
                               const TrialSpec& spec, double* legs_apart = nullptr);

/// A leap: a plan of the robot, replayed with feed-forward and PD. `quantity` torque or duty; for
/// duty the plan's torques and rates are turned into fractions of the robot's bus voltage by the
/// motors as believed, whatever its duty columns say.
trajectory::Dataset leap(const std::filesystem::path& robot_folder,
                         const std::filesystem::path& plan, trajectory::Quantity quantity);
/// Self-righting: falls from 1 m with the tail at full voltage from its lower stop, the other
/// motors holding the rest pose. InputError for a robot without a tail whose joint has stops.
trajectory::Dataset self_righting(const std::filesystem::path& robot_folder);
/// The tail on the bench: the base held, steps of half the bus voltage on the tail. InputError for
/// a robot without a tail.
trajectory::Dataset tail_bench(const std::filesystem::path& robot_folder);
/// A pendulum: torque steps, up to half its limit, on the one motor of a robot on a fixed base.
trajectory::Dataset pendulum(const std::filesystem::path& robot_folder);

/// What drives a swing.
enum class SwingInput {
  torque,         ///< torques by a script
  logged_torque,  ///< the same, but a dataset holds the torques as logged, not as commanded
  unknown_gains,  ///< a reference, tracked by PD of whose gains a range alone is stated
  voltage         ///< voltages by a script
};

const NameTable<SwingInput>& swing_inputs();

/// A pendulum of one joint or more on a fixed base: every motor swings smoothly about its rest pose
/// for 2 s, by a sum of three sines. Amplitudes are far below those at which more than one joint
/// goes its own way: twice as many steps of MuJoCo end at the same angles. InputError for a robot
/// with a tail, pins or a base that floats, and for voltages on ideal motors.
trajectory::Dataset swing(const std::filesystem::path& robot_folder, SwingInput input);
/// A drop of a robot without a tail: falls for 0.3 s, its legs swinging by PD. InputError for
/// another robot, and for legs with pins.
trajectory::Dataset leg_drop(const std::filesystem::path& robot_folder);
/// The base held on a stand, legs swinging by voltages for 2 s. InputError as for leg_drop, and for
/// ideal motors.
trajectory::Dataset leg_bench(const std::filesystem::path& robot_folder);

}  // namespace jaculus::testbed
