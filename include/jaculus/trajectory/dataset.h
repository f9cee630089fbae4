#pragma once
// A dataset: what was commanded to a robot and what was measured on it, over several trials. The folder's format is in the
// README (dataset.yaml, plan.csv, a folder a trial with a CSV a stream). Real logs, simulated ones and those of the testbed
// are the same to everything that reads them.
//
// Channels, by the name of their column without unit, SI:
//   mocap   x, z [m], pitch [rad] of the base (x and pitch relative to rest), tail pitch or others where tracked
//   joints  <joint> [rad], <joint>_velocity [rad/s], <joint>_torque [N m], <joint>_current [A], <joint>_voltage [V],
//           <joint>_duty [-], bus_voltage [V], imu_pitch [rad], imu_pitch_velocity [rad/s]

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus {

/// One sensor system's samples in one trial. An empty cell of the file is NaN here.
struct Stream {
  std::string name;                   ///< "mocap", "joints"
  double rate_hz = kNaN;              ///< as stated; NaN where the file alone tells [Hz]
  Vector time;                        ///< [s], strictly rising
  std::vector<std::string> channels;  ///< "x", "front_a", "front_a_velocity", ...
  std::vector<std::string> units;     ///< SI unit of each channel, "m"
  Matrix values;                      ///< channels x samples, SI

  [[nodiscard]] int channel(const std::string& channel_name) const;  ///< index, -1 where there is none
};

struct Trial {
  std::string name;  ///< "trial_01"
  std::vector<Stream> streams;

  [[nodiscard]] const Stream* stream(const std::string& stream_name) const;  ///< null where there is none
};

/// A controller's gain as stated: a number, a range, or unknown (0 to infinity).
struct StatedGain {
  Bounds range{0.0, 0.0};  ///< in the unit of `quantity` per rad or per rad/s

  [[nodiscard]] bool known() const { return range.fixed(); }
};

/// How the commands became torques.
struct StatedController {
  std::string kind;  ///< "feedforward_pd", "voltage", "torque", "measured"
  std::string quantity =
      "torque";                  ///< what the feed-forward and the gains are: "torque" [N m], "duty" [-], "voltage" [V]
  double rate_hz = 1000.0;       ///< of the loop, zero-order hold [Hz]
  bool quantity_stated = false;  ///< false: `quantity` is what the format takes where nothing is said
  bool gains_stated = false;     ///< false: neither kp nor kd stood in the file, so every gain is unknown
  std::map<std::string, StatedGain> kp;  ///< by joint; "*" any other joint
  std::map<std::string, StatedGain> kd;
  std::optional<double> bus_voltage;  ///< [V]
  std::string input;                  ///< of kind measured: the quantity whose logged column drove the joint, "torque"
  std::string after_end;  ///< "hold", "relax", "repeat", "pose"; empty: hold after a plan, repeat after a script
  std::map<std::string, double> landing_pose;  ///< of after_end "pose": by joint, "*" any other [rad or m]
  double landing_time = 0.0;                   ///< in which the reference goes there from the plan's end [s]
  std::string after_end_place;                 ///< "file:line: controller.after_end", for messages; empty: from no file
};

/// End of a joint's travel as it was built into the experiment.
struct StatedStop {
  Bounds range;              ///< [rad]
  double restitution = 0.0;  ///< [-]
};

/// A script of commands in place of a plan: one column a motor against time, held.
struct InputScript {
  std::string quantity = "voltage";  ///< "voltage" [V], "torque" [N m] at the joint, "duty" [-]
  Vector time;                       ///< [s]
  std::vector<std::string> joints;
  Matrix values;  ///< joints x samples
};

struct Dataset {
  std::filesystem::path folder;
  std::string experiment;                        ///< "leap", "self_righting", "tail_bench", "pendulum"
  std::string robot;                             ///< as stated: a folder of models/ or a path
  std::map<std::string, std::string> overrides;  ///< model values that this robot had, by path, as text
  std::optional<Table> plan;                     ///< what was commanded, columns of plan.csv
  std::optional<InputScript> script;             ///< or this
  std::map<std::string, double> initial;         ///< stated initial coordinates, SI, where no plan gives them
  std::map<std::string, StatedStop> stops;       ///< by joint
  StatedController controller;
  std::vector<Trial> trials;
  std::string provenance;
  std::vector<std::string> notes;  ///< what the files leave open and what was taken for it, one sentence each
};

/// Reads a dataset's folder (or its dataset.yaml). Every fault is an InputError with file:line: missing file, time that runs
/// backwards, duplicate stamps, empty or truncated CSV, unit missing or of another dimension, a stream that begins after the
/// plan's end. A channel of NaN alone is kept. A trial may lack a stream's file where another trial has it (a note says so).
Dataset read_dataset(const std::filesystem::path& folder);

/// Writes dataset.yaml last, so that a folder without it is one that was interrupted. `dataset.folder` is set to it. The robot is
/// written as stated: a relative path must hold from the new folder. InputError where it can't be written.
void write_dataset(Dataset& dataset, const std::filesystem::path& folder);

}  // namespace jaculus
