#pragma once
// Joint torque trajectories for robots, resampled from a plan at a fixed rate and checked against its limits again.
//
// Between samples of the plan: positions follow the cubic through positions and velocities at both ends, velocities its
// derivative. Torques keep the hold that they were planned with: `held` counts from its sample to the next one, `linear`
// goes straight between them. What is exported is held from sample to sample, so limits are looked at where each sample
// begins and where it ends, with the torque of that sample.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/report/summary.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus {

/// A plan as read back from files.
struct ExportSource {
  std::string name;
  Table table;                       ///< plan.csv
  std::string hold;                  ///< "held" or "linear"
  std::vector<MotorFigures> motors;  ///< from summary.json; without it names only, no limits
  bool limits_known = false;
  bool converged = true;  ///< false where the summary says that the solve did not converge
  bool verified = true;   ///< false where the summary says that the plan failed its check
};

/// Reads a plan from the folder of a solve, its plan.csv or its solution.json. summary.json beside it gives hold and limits; a
/// lone plan.csv needs `hold`. InputError where files are missing or hold no motor torques, or where `hold` contradicts.
ExportSource read_export_source(const std::filesystem::path& path, const std::optional<std::string>& hold);

enum class ExportSide { joint, motor };

/// Everything of one motor, one value a sample, on the side that Export states.
struct ExportedMotor {
  std::string name;
  int count = 1;                 ///< left and right: 2, each plays the same
  std::vector<double> position;  ///< [rad or m]
  std::vector<double> velocity;  ///< [rad/s or m/s]
  std::vector<double> torque;    ///< [N m or N]
  std::vector<double> current;   ///< [A]; empty where the motor's constants are unknown
  std::vector<double> voltage;   ///< [V], at the start of the sample; empty likewise
};

/// Peak of one quantity of one motor after resampling, held against its limit.
struct LimitCheck {
  std::string motor;
  std::string quantity;  ///< "torque", "current", "voltage"
  std::string unit;
  double peak = 0.0;  ///< absolute value
  double time = 0.0;  ///< where it occurs [s]
  double limit = kInfinity;
  bool exceeded = false;  ///< by more than 0.1 %
};

struct Export {
  std::string name;
  double rate = 0.0;      ///< [Hz]
  double duration = 0.0;  ///< of the plan [s]; the last sample is held until then
  ExportSide side = ExportSide::joint;
  std::string plan_hold;     ///< of the plan's inputs
  std::vector<double> time;  ///< [s], k / rate
  std::vector<ExportedMotor> motors;
  std::vector<LimitCheck> checks;  ///< empty where limits are unknown
};

/// Resamples at `rate` [Hz], which must be positive.
Export resample(const ExportSource& source, double rate, ExportSide side);

std::string export_csv(const Export& plan);
std::string export_json(const Export& plan);
/// YAML of a ROS trajectory_msgs/JointTrajectory message.
std::string export_joint_trajectory(const Export& plan);
/// A C header with constant arrays, single precision.
std::string export_c(const Export& plan);

}  // namespace jaculus
