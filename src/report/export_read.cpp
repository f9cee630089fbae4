// Plans read back from what a solve wrote.

#include <fmt/format.h>

#include <fstream>

#include "jaculus/core/error.h"
#include "jaculus/report/export.h"

namespace jaculus {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr std::string_view kSuffix = "_torque";
constexpr std::string_view kMotorSuffix = "_motor_torque";

std::optional<Summary> read_summary(const fs::path& file) {
  if (!fs::is_regular_file(file)) return std::nullopt;
  std::ifstream stream(file);
  if (!stream) throw InputError(fmt::format("{}: can't be read; allowed: a readable summary.json", file.string()));
  const Json json = Json::parse(stream, nullptr, false);
  if (json.is_discarded()) {
    throw InputError(fmt::format("{}: not JSON; allowed: a summary.json that jaculus wrote", file.string()));
  }
  return summary_from_json(json, file.string());
}

fs::path plan_file(const fs::path& path) {
  if (fs::is_directory(path)) return path / "plan.csv";
  if (!fs::exists(path)) {
    throw InputError(
        fmt::format("{}: not found; allowed: a folder that `jaculus solve` wrote, its plan.csv or its solution.json",
                    path.string()));
  }
  if (path.extension() == ".csv") return path;
  if (path.filename() == "solution.json" || path.filename() == "summary.json") return path.parent_path() / "plan.csv";
  throw InputError(fmt::format(
      "{}: no plan; allowed: a folder that `jaculus solve` wrote, its plan.csv or its solution.json", path.string()));
}

std::vector<MotorFigures> motors_of(const Table& table, const fs::path& file) {
  std::vector<MotorFigures> motors;
  for (const Column& column : table.columns) {
    if (!column.name.ends_with(kSuffix) || column.name.ends_with(kMotorSuffix)) continue;
    MotorFigures motor;
    motor.motor = column.name.substr(0, column.name.size() - kSuffix.size());
    motors.push_back(motor);
  }
  if (motors.empty()) {
    throw InputError(
        fmt::format("{}:1: no column '<joint>_torque [N m]'; allowed: a plan with motor torques", file.string()));
  }
  return motors;
}

void check_columns(const Table& table, const std::vector<MotorFigures>& motors, const fs::path& file) {
  std::vector<std::string> needed = {"time"};
  for (const MotorFigures& motor : motors) {
    for (const char* suffix : {"", "_velocity", "_torque"}) needed.push_back(motor.motor + suffix);
  }
  for (const std::string& name : needed) {
    const int column = table.column(name);
    if (column < 0) {
      throw InputError(fmt::format("{}:1: column '{}' is missing; a plan to export must have it", file.string(), name));
    }
    if (!table.values.col(column).allFinite()) {
      throw InputError(
          fmt::format("{}: column '{}' has empty cells; allowed: a number in every row", file.string(), name));
    }
  }
  const auto time = table.values.col(table.column("time"));
  for (Eigen::Index i = 1; i < time.size(); ++i) {
    if (time[i] >= time[i - 1]) continue;
    throw InputError(fmt::format("{}:{}: time falls from {} to {} s; allowed: times that never fall", file.string(),
                                 i + 2, time[i - 1], time[i]));
  }
}

}  // namespace

ExportSource read_export_source(const fs::path& path, const std::optional<std::string>& hold) {
  const fs::path file = plan_file(path);
  ExportSource source;
  source.table = read_csv(file);
  const std::optional<Summary> summary = read_summary(file.parent_path() / "summary.json");
  source.name = summary ? summary->name : file.stem().string();
  if (summary) {
    source.motors = summary->motors;
    source.limits_known = true;
    source.converged = summary->converged;
    source.verified = summary->verification.passed;
    source.hold = summary->input_hold;
    if (hold && *hold != source.hold) {
      throw InputError(fmt::format("--hold {}: the plan's inputs are {}, says {}; allowed: --hold {}, or none", *hold,
                                   source.hold, (file.parent_path() / "summary.json").string(), source.hold));
    }
  } else {
    source.motors = motors_of(source.table, file);
    if (!hold) {
      throw InputError(
          fmt::format("{}: no summary.json beside it says how torques go on between samples; give --hold held or "
                      "--hold linear",
                      file.string()));
    }
    source.hold = *hold;
  }
  check_columns(source.table, source.motors, file);
  return source;
}

}  // namespace jaculus
