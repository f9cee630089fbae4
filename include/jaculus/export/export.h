#pragma once
// Joint torque trajectories for robots, resampled from a plan at a fixed rate and checked against
// its limits again. The namespace is `exporting`, since `export` is a keyword.
//
// Between samples of the plan: positions follow the cubic through positions and velocities at both
// ends, velocities its derivative. Torques keep the hold that they were planned with: `held` counts
// from its sample to the next one, `linear` goes straight between them.
//
// What is exported is held from sample to sample. Position and velocity are those where a sample
// begins; its torque is the mean of the planned one until it ends,
//   tau_k = rate * integral of tau(t) dt over [k/rate, (k + 1)/rate] (or until the plan's end),
// which has the plan's impulse, without the lag of half a sample that the torque at its start would
// have. Limits are looked at where each sample begins and where it ends, with its torque.
//
// Where a motor makes up for dry friction (components/motor.h), that share of its torque follows
// from the velocity v at each instant, not from samples of the plan, between which joints turn:
//   tau(t) = u(t) + c tanh(v(t)/s),
// u by the hold as above. Its mean over a sample is taken too; that in which a joint turns has a
// part of c.
//
// Joints are those of the robot's file, and of what its robot.yaml attaches: a planar joint that
// stands for a left and a right one is written out as both, each with its own sign. Of a joint that
// is only held nothing is known but its place, on the joint's side of its gear.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/solver/plan_files.h"
#include "jaculus/solver/summary.h"
#include "jaculus/trajectory/csv.h"
#include "jaculus/trajectory/quantity.h"
#include "jaculus/transcription/describe.h"

namespace jaculus::exporting {

/// A plan to export.
struct Source {
  std::string name;         ///< of its problem, else of its file
  trajectory::Table table;  ///< plan.csv
  transcription::InputHold hold = transcription::InputHold::held;  ///< of its torques
  /// from summary.json; without it names only, no limits
  std::vector<solver::MotorFigures> motors;
  /// joints of the robot's file that stand still, for its controller to hold
  std::vector<model::HeldJoint> held_joints;
  bool limits_known = false;
  bool converged = true;  ///< false where the summary says that the solve did not converge
  bool verified = true;   ///< false where the summary says that the plan failed its check
};

/// A plan as solved. It must have a trajectory.
Source source(const solver::SolvedPlan& solved);

/// Reads a plan from the folder of a solve, its plan.csv or its solution.json. summary.json beside
/// it gives hold, joints and limits; a lone plan.csv needs `hold`, and takes joints and the robot's
/// own limits from `robot`, where given. InputError where files are missing or hold no motor
/// torques, or where `hold` or `robot` contradict.
Source read_source(const std::filesystem::path& path,
                   const std::optional<transcription::InputHold>& hold,
                   const model::PlanarModel* robot = nullptr);

enum class Side {
  joint,  ///< behind the gear
  motor   ///< before it
};

/// "joint", "motor".
const NameTable<Side>& sides();
const char* name_of(Side side);

/// Everything of one motor of the plan, one value a sample, on the side that Export states.
struct ExportedMotor {
  std::string joint;    ///< that it turns in the plane
  bool slides = false;  ///< along a line: m and N, not rad and N m
  /// joints of the robot's file that play it, each `sign` times it; never empty
  std::vector<model::FileJoint> file_joints;
  std::vector<double> position;  ///< [rad or m]
  std::vector<double> velocity;  ///< [rad/s or m/s]
  std::vector<double> torque;    ///< [N m or N]
  std::vector<double> current;   ///< [A]; empty where the motor's constants are unknown
  std::vector<double> voltage;   ///< [V], at the start of the sample; empty likewise
};

/// Peak of one quantity of one motor after resampling, held against its limit.
struct LimitCheck {
  std::string joint;  ///< of the motor
  /// torque, velocity (both before the gear), current or voltage
  trajectory::Quantity quantity = trajectory::Quantity::torque;
  std::string unit;          ///< of `peak` and `limit`
  double peak = 0.0;         ///< absolute value [unit]
  double time = 0.0;         ///< where it occurs [s]
  double limit = kInfinity;  ///< [unit]
  bool exceeded = false;     ///< by more than 0.1 %
};

/// A plan, resampled.
struct Export {
  std::string name;         ///< of the plan
  double rate = 0.0;        ///< [Hz]
  double duration = 0.0;    ///< of the plan [s]; the last sample is held until then
  Side side = Side::joint;  ///< of positions, velocities and torques
  transcription::InputHold plan_hold = transcription::InputHold::held;  ///< of the plan's torques
  std::vector<double> time;                                             ///< [s], k / rate
  std::vector<ExportedMotor> motors;
  std::vector<model::HeldJoint> held_joints;  ///< of the robot's file, to be held
  bool file_joints_known = true;              ///< false: joints are the plan's own, by its names
  std::vector<LimitCheck> checks;             ///< empty where limits are unknown
};

/// One joint in space and the motor that it plays, `sign` times.
struct PlayedJoint {
  std::string name;
  double sign = 1.0;
  const ExportedMotor* motor = nullptr;  ///< never null
  bool attached = false;                 ///< by robot.yaml; the robot's file doesn't have it
};

/// All joints in space that move, motor by motor.
std::vector<PlayedJoint> played_joints(const Export& plan);

/// Resamples at `rate` [Hz], which must be positive.
Export resample(const Source& source, double rate, Side side);

/// A way to write an exported plan.
struct Format {
  std::string name;                     ///< on the command line
  std::string (*write)(const Export&);  ///< the text of the file
};

/// csv, json, joint_trajectory, c.
const std::vector<Format>& formats();

std::string to_csv(const Export& plan);
std::string to_json(const Export& plan);
/// YAML of a ROS trajectory_msgs/JointTrajectory message.
std::string to_joint_trajectory(const Export& plan);
/// A C header with constant arrays, single precision.
std::string to_c(const Export& plan);

/// The limits as to_json() has them.
nlohmann::ordered_json checks_json(const Export& plan);

}  // namespace jaculus::exporting
