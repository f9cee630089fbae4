// Plans to export: as solved, or read back from what a solve wrote.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "jaculus/core/error.h"
#include "jaculus/export/export.h"
#include "jaculus/trajectory/quantity.h"

namespace jaculus::exporting {
namespace {

namespace fs = std::filesystem;

using trajectory::Quantity;

std::optional<solver::Summary> read_summary(const fs::path& file) {
  if (!fs::is_regular_file(file)) return std::nullopt;
  return solver::read_summary(file);
}

fs::path plan_file(const fs::path& path) {
  if (fs::is_directory(path)) return path / "plan.csv";
  if (!fs::exists(path)) {
    throw InputError(
        fmt::format("{}: not found; allowed: a folder that `jaculus solve` wrote, its plan.csv or "
                    "its solution.json",
                    path.string()));
  }
  if (path.extension() == ".csv") return path;
  if (path.filename() == "solution.json" || path.filename() == "summary.json")
    return path.parent_path() / "plan.csv";
  throw InputError(
      fmt::format("{}: no plan; allowed: a folder that `jaculus solve` wrote, its plan.csv or its "
                  "solution.json",
                  path.string()));
}

std::vector<solver::MotorFigures> motors_of(const trajectory::Table& table, const fs::path& file) {
  std::vector<solver::MotorFigures> motors;
  for (const trajectory::Column& column : table.columns) {
    const trajectory::ChannelName name = trajectory::parse_channel(column.name);
    if (name.quantity != Quantity::torque) continue;
    solver::MotorFigures motor;
    motor.joint = name.of;
    motors.push_back(motor);
  }
  if (motors.empty()) {
    throw InputError(
        fmt::format("{}:1: no column '<joint>_torque [N m]'; allowed: a plan with motor torques",
                    file.string()));
  }
  return motors;
}

/// Joints and limits of the robot, for the motors that the plan has.
void take_robot(const model::PlanarModel& robot, const fs::path& file, Source& source) {
  const std::vector<solver::MotorFigures> known = solver::motor_figures(robot);
  for (solver::MotorFigures& motor : source.motors) {
    const auto found = std::find_if(known.begin(), known.end(),
                                    [&](const auto& m) { return m.joint == motor.joint; });
    if (found == known.end()) {
      std::vector<std::string> names;
      for (const solver::MotorFigures& m : known) names.push_back(m.joint);
      throw InputError(
          fmt::format("{}:1: column '{}_torque' is of no motor of this robot; allowed: {}",
                      file.string(), motor.joint, fmt::join(names, ", ")));
    }
    motor = *found;
  }
  source.held_joints = robot.held;
  source.limits_known = true;
}

void check_columns(const trajectory::Table& table, const std::vector<solver::MotorFigures>& motors,
                   const fs::path& file) {
  std::vector<std::string> needed = {"time"};
  for (const solver::MotorFigures& motor : motors) {
    for (const Quantity quantity : {Quantity::position, Quantity::velocity, Quantity::torque})
      needed.push_back(channel_name(motor.joint, quantity));
  }

  for (const std::string& name : needed) {
    const int column = table.column(name);
    if (column < 0) {
      throw InputError(fmt::format("{}:1: column '{}' is missing; a plan to export must have it",
                                   file.string(), name));
    }
    if (!table.values.col(column).allFinite()) {
      throw InputError(fmt::format(
          "{}: column '{}' has empty cells; allowed: a number in every row", file.string(), name));
    }
  }

  const auto time = table.values.col(table.column("time"));
  for (Eigen::Index i = 1; i < time.size(); ++i) {
    if (time[i] >= time[i - 1]) continue;
    throw InputError(
        fmt::format("{}:{}: time falls from {} to {} s; allowed: times that never fall",
                    file.string(), i + 2, time[i - 1], time[i]));
  }
}

}  // namespace

Source source(const solver::SolvedPlan& solved) {
  const solver::Summary& summary = solved.summary;
  Source source;
  source.name = summary.name;
  source.table = solver::plan_tables(solved).plan;
  source.hold = summary.input_hold;
  source.motors = summary.motors;
  source.held_joints = summary.held_joints;
  source.limits_known = true;
  source.converged = summary.converged();
  source.verified = summary.verification.passed;
  return source;
}

Source read_source(const fs::path& path, const std::optional<transcription::InputHold>& hold,
                   const model::PlanarModel* robot) {
  const fs::path file = plan_file(path);
  Source source;
  source.table = trajectory::read_csv(file);
  const std::optional<solver::Summary> summary = read_summary(file.parent_path() / "summary.json");
  source.name = summary ? summary->name : file.stem().string();

  if (summary) {
    if (robot != nullptr) {
      throw InputError(
          fmt::format("--robot: {} says which joints and limits the plan has; allowed: "
                      "--robot with a plan.csv alone",
                      (file.parent_path() / "summary.json").string()));
    }
    source.motors = summary->motors;
    source.held_joints = summary->held_joints;
    source.limits_known = true;
    source.converged = summary->converged();
    source.verified = summary->verification.passed;
    source.hold = summary->input_hold;
    if (hold && *hold != source.hold) {
      throw InputError(
          fmt::format("--hold {}: the plan's inputs are {}, says {}; allowed: --hold {}, or none",
                      name_of(*hold), name_of(source.hold),
                      (file.parent_path() / "summary.json").string(), name_of(source.hold)));
    }
  } else {
    source.motors = motors_of(source.table, file);
    if (robot != nullptr) take_robot(*robot, file, source);
    if (!hold) {
      throw InputError(
          fmt::format("{}: no summary.json beside it says how torques go on between samples; give "
                      "--hold held or "
                      "--hold linear",
                      file.string()));
    }
    source.hold = *hold;
  }

  check_columns(source.table, source.motors, file);
  return source;
}

}  // namespace jaculus::exporting
