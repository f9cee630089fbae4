#pragma once
// A dataset: what was commanded to a robot and what was measured on it, over several trials. The
// folder's format is in docs/commands.md (dataset.yaml, plan.csv, a folder a trial with a CSV a
// stream). Real logs, simulated ones and those of the testbed are the same to everything that reads
// them.
//
// Channels, by the name of their column without unit, SI:
//   mocap   x, z [m], pitch [rad] of the base (x and pitch relative to rest), tail pitch or others
//           where tracked
//   joints  <joint> [rad], <joint>_velocity [rad/s], <joint>_torque [N m], <joint>_current [A],
//           <joint>_voltage [V], <joint>_duty [-], bus_voltage [V], imu_pitch [rad],
//           imu_pitch_velocity [rad/s]; <joint>_apart [rad]: of left and right that are one joint,
//           whose mean <joint> is, the first of the two less the second

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/error.h"
#include "jaculus/core/types.h"
#include "jaculus/trajectory/csv.h"
#include "jaculus/trajectory/kinds.h"
#include "jaculus/trajectory/quantity.h"

namespace jaculus::trajectory {

/// Streams that every tool knows; a dataset may have others.
inline constexpr const char* kMocapStream = "mocap";
inline constexpr const char* kJointStream = "joints";

/// One sensor system's samples in one trial. An empty cell of the file is NaN here.
struct Stream {
  std::string name;                   ///< "mocap", "joints"
  double rate_hz = kNaN;              ///< as stated; NaN where the file alone tells [Hz]
  Vector time;                        ///< [s], strictly rising
  std::vector<std::string> channels;  ///< "x", "front_a", "front_a_velocity", ...
  std::vector<std::string> units;     ///< SI unit of each channel, "m"
  Matrix values;                      ///< channels x samples, SI

  /// index, -1 where there is none
  [[nodiscard]] int channel(const std::string& channel_name) const;
};

struct Trial {
  std::string name;  ///< "trial_01"
  std::vector<Stream> streams;

  /// null where there is none
  [[nodiscard]] const Stream* stream(const std::string& stream_name) const;
};

/// A controller's gain as stated: a number, a range, or unknown (0 to infinity).
struct StatedGain {
  Bounds range{0.0, 0.0};  ///< in the unit of `quantity` per rad or per rad/s

  [[nodiscard]] bool known() const { return range.fixed(); }
};

/// How the commands became torques.
struct StatedController {
  ControllerKind kind = ControllerKind::feedforward_pd;
  /// What the feed-forward and the gains are: torque [N m], duty [-] or voltage [V].
  Quantity quantity = Quantity::torque;
  double rate_hz = 1000.0;  ///< of the loop, zero-order hold [Hz]
  /// false: `quantity` is what the format takes where nothing is said
  bool quantity_stated = false;
  /// false: neither kp nor kd stood in the file, so every gain is unknown
  bool gains_stated = false;
  /// true: gains are at the joint, behind the gear, as many drivers take them; else the motor's
  bool gains_at_joint = false;
  std::map<std::string, StatedGain> kp;  ///< by joint; "*" any other joint
  std::map<std::string, StatedGain> kd;
  std::optional<double> bus_voltage;  ///< [V]
  /// Of kind measured: the quantity whose logged column drove the joint.
  Quantity input = Quantity::torque;
  std::optional<AfterEnd> after_end;  ///< nothing: hold after a plan, repeat after a script
  /// Of AfterEnd::pose: by joint, "*" any other [rad or m].
  std::map<std::string, double> landing_pose;
  double landing_time = 0.0;  ///< in which the reference goes there from the plan's end [s]
};

/// End of a joint's travel as it was built into the experiment.
struct StatedStop {
  Bounds range;              ///< [rad]
  double restitution = 0.0;  ///< [-]
};

/// A script of commands in place of a plan: one column a motor against time, held.
struct InputScript {
  /// Voltage [V], torque [N m] at the joint or duty [-].
  Quantity quantity = Quantity::voltage;
  Vector time;  ///< [s]
  std::vector<std::string> joints;
  Matrix values;  ///< joints x samples
};

struct Dataset {
  std::filesystem::path folder;
  ExperimentKind experiment = ExperimentKind::leap;
  std::string robot;  ///< as stated: a folder of models/ or a path
  /// model values that this robot had, by path, as text
  std::map<std::string, std::string> overrides;
  std::map<std::string, InputPlace> override_places;  ///< where a file states them, for messages
  /// where a file states "controller", "controller.kp", "input", ..., for messages
  std::map<std::string, InputPlace> places;
  std::optional<Table> plan;          ///< what was commanded, columns of plan.csv
  std::optional<InputScript> script;  ///< or this
  /// stated initial coordinates, SI, where no plan gives them
  std::map<std::string, double> initial;
  std::map<std::string, StatedStop> stops;  ///< by joint
  StatedController controller;
  std::vector<Trial> trials;
  std::string provenance;
  /// what the files leave open and what was taken for it, one sentence each
  std::vector<std::string> notes;

  /// Where a key stands; in dataset.yaml where no file states it.
  [[nodiscard]] InputPlace place_of(const std::string& key) const;
};

/// Reads a dataset's folder (or its dataset.yaml). Every fault is an InputError with file:line:
/// missing file, time that runs backwards, duplicate stamps, empty or truncated CSV, unit missing
/// or of another dimension, a stream that begins after the plan's end. A channel of NaN alone is
/// kept. A trial may lack a stream's file where another trial has it (a note says so).
Dataset read_dataset(const std::filesystem::path& folder);
/// Every key of dataset.yaml with its meaning, unit and default.
std::string explain_dataset();

/// Writes dataset.yaml last, so that a folder without it is one that was interrupted.
/// `dataset.folder` is set to it. The robot is written as stated: a relative path must hold from
/// the new folder. InputError where it can't be written.
void write_dataset(Dataset& dataset, const std::filesystem::path& folder);

}  // namespace jaculus::trajectory
