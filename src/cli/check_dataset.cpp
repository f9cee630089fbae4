#include "cli/check_dataset.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/error.h"
#include "jaculus/core/json.h"
#include "jaculus/report/text_table.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string format_of(const fs::path& path) {
  if (!fs::is_regular_file(path) || (path.extension() != ".yaml" && path.extension() != ".yml")) return "";
  const yaml::Node root = yaml::Node::load(path);
  if (!root.is_map()) return "";
  const auto format = root.find("format");
  return format && format->is_scalar() ? format->dump() : "";
}

double duration_of(const Table& plan) { return plan.values(plan.values.rows() - 1, plan.column("time")); }

/// v/T as the plan itself has it, at its end.
double plan_acceleration(const Table& plan) {
  const int v = plan.column("x_velocity");
  return v < 0 ? kNaN : plan.values(plan.values.rows() - 1, v) / duration_of(plan);
}

std::string shown(double value) { return std::isfinite(value) ? fmt::format("{:.3f}", value) : "-"; }

/// Channels that this robot can't have: the plan or the log is of another robot.
std::vector<std::string> strange_channels(const Dataset& dataset, const PlanarModel& model) {
  std::vector<std::string> strange;
  for (const Trial& trial : dataset.trials) {
    for (const Stream& stream : trial.streams) {
      for (const std::string& channel : stream.channels) {
        for (const char* suffix : {"_torque", "_current", "_voltage", "_duty"}) {
          const std::string joint =
              channel.substr(0, channel.size() - std::min(channel.size(), std::string(suffix).size()));
          if (channel == "bus_voltage" || !channel.ends_with(suffix) || model.body_of_joint(joint) >= 0) continue;
          if (std::find(strange.begin(), strange.end(), channel) == strange.end()) strange.push_back(channel);
        }
      }
    }
  }
  return strange;
}

Json streams_of(const Dataset& dataset, std::string& text) {
  TextTable table({"trial", "stream", "channels", "samples", "from [s]", "to [s]", "stated [Hz]", "gaps"});
  Json json = Json::array();
  for (const Trial& trial : dataset.trials) {
    for (const Stream& stream : trial.streams) {
      const auto gaps = stream.values.array().isNaN().count();
      const double to = stream.time[stream.time.size() - 1];
      table.row({trial.name, stream.name, fmt::format("{}", stream.channels.size()),
                 fmt::format("{}", stream.time.size()), shown(stream.time[0]), shown(to),
                 std::isnan(stream.rate_hz) ? "-" : fmt::format("{}", stream.rate_hz), fmt::format("{}", gaps)});
      json.push_back({{"trial", trial.name},
                      {"stream", stream.name},
                      {"channels", stream.channels},
                      {"units", stream.units},
                      {"samples", stream.time.size()},
                      {"from_s", stream.time[0]},
                      {"to_s", to},
                      {"gaps", gaps}});
    }
  }
  text += table.text();
  return json;
}

/// The recipe's acceleration of every trial with motion capture, their mean, and the plan's own.
Json accelerations(const Dataset& dataset, std::string& text) {
  if (dataset.experiment != "leap" || !dataset.plan) return nullptr;
  const double duration = duration_of(*dataset.plan);
  Json trials = Json::object();
  double sum = 0.0;
  int count = 0;
  TextTable table({"trial", "start [s]", "v at start + T [m/s]", "v/T [m/s^2]"});
  for (const Trial& trial : dataset.trials) {
    const Stream* mocap = trial.stream("mocap");
    if (mocap == nullptr || mocap->channel("x") < 0) continue;
    const int y = mocap->channel("y");
    const auto found = leap_speed(mocap->time, mocap->values.row(mocap->channel("x")).transpose(),
                                  y < 0 ? Vector() : Vector(mocap->values.row(y).transpose()), duration);
    table.row({trial.name, found ? fmt::format("{:.4f}", found->start) : "-", found ? shown(found->speed) : "-",
               found ? shown(found->acceleration) : "-"});
    trials[trial.name] = found ? Json(found->acceleration) : Json(nullptr);
    if (!found) continue;
    sum += found->acceleration;
    ++count;
  }
  if (trials.empty()) return nullptr;
  const double plan = plan_acceleration(*dataset.plan), mean = count > 0 ? sum / count : kNaN;
  text += "acceleration from motion capture by the authors' recipe\n" + table.text() +
          fmt::format("mean {} m/s^2; the plan's own v/T at its end {} m/s^2 (T = {:.5f} s)\n", shown(mean),
                      shown(plan), duration);
  return {
      {"trials", trials}, {"mean_m_s2", json_number(mean)}, {"plan_m_s2", json_number(plan)}, {"duration_s", duration}};
}

std::string head_text(const Dataset& dataset, const Robot& robot) {
  const StatedController& c = dataset.controller;
  std::string text = fmt::format("  robot         {} ({} coordinates, {} motors, {:.4g} kg)\n", robot.name,
                                 robot.planar.size(), robot.planar.motors.size(), robot.planar.total_mass());
  text +=
      fmt::format("  controller    {}{}{}\n", c.kind, c.kind == "measured" ? ", input " + c.input : ", " + c.quantity,
                  c.kind == "measured" ? "" : fmt::format(" at {} Hz", c.rate_hz));
  if (dataset.plan)
    text +=
        fmt::format("  plan          {} samples, {:.5g} s\n", dataset.plan->values.rows(), duration_of(*dataset.plan));
  if (dataset.script)
    text += fmt::format("  input         {} of {}, {} steps\n", dataset.script->quantity,
                        fmt::join(dataset.script->joints, ", "), dataset.script->time.size());
  for (const std::string& note : robot.notes) text += "  robot: " + note + "\n";
  for (const std::string& note : dataset.notes) text += "  note: " + note + "\n";
  return text;
}

/// What is commanded must be this robot's: the plan names every motor of it, the script only motors of it.
void check_command(const Dataset& dataset, const PlanarModel& model) {
  if (dataset.plan || dataset.script) (void)stated_controller(dataset, model, {});
  (void)dataset_plant(dataset, model);
}

Json check_experiment(const fs::path& path, std::string& text) {
  const Experiment experiment = read_experiment(path);
  const Robot robot = dataset_robot(experiment.setup);
  text += fmt::format("{}: {} experiment, {} trials of {} s after {} s at rest, seed {}\n", experiment.name,
                      experiment.setup.experiment, experiment.trials, experiment.duration, experiment.lead,
                      experiment.seed);
  text += head_text(experiment.setup, robot);
  Json streams = Json::array();
  for (const SensorStream& stream : experiment.streams) {
    text += fmt::format("  {:<13} {} Hz: {}\n", stream.name, stream.rate_hz, fmt::join(stream.channels, ", "));
    streams.push_back(
        {{"name", stream.name}, {"rate_hz", stream.rate_hz}, {"channels", stream.channels}, {"noise", stream.noise}});
  }
  return {{"experiment", experiment.name},
          {"kind", experiment.setup.experiment},
          {"robot", robot.name},
          {"trials", experiment.trials},
          {"seed", experiment.seed},
          {"streams", streams},
          {"notes", experiment.setup.notes}};
}

}  // namespace

bool names_dataset(const fs::path& path) {
  if (fs::is_directory(path)) return fs::is_regular_file(path / "dataset.yaml");
  const std::string format = format_of(path);
  return path.filename() == "dataset.yaml" || format.starts_with("jaculus-dataset/") ||
         format.starts_with("jaculus-experiment/");
}

Json check_dataset(const fs::path& path, std::string& text) {
  if (!fs::is_directory(path) && format_of(path).starts_with("jaculus-experiment/"))
    return check_experiment(path, text);
  const Dataset dataset = read_dataset(path);
  const Robot robot = dataset_robot(dataset);
  check_command(dataset, robot.planar);
  text += fmt::format("{}: {} dataset, {} trials\n",
                      dataset.folder.filename().empty() ? "dataset" : dataset.folder.filename().string(),
                      dataset.experiment, dataset.trials.size());
  text += head_text(dataset, robot);
  const std::vector<std::string> strange = strange_channels(dataset, robot.planar);
  if (!strange.empty())
    text += fmt::format("  note: channels of no joint of this robot: {}\n", fmt::join(strange, ", "));
  Json json = {{"dataset", dataset.experiment}, {"robot", robot.name}, {"trials", dataset.trials.size()}};
  json["streams"] = streams_of(dataset, text);
  json["recipe"] = accelerations(dataset, text);
  json["notes"] = dataset.notes;
  json["robot_notes"] = robot.notes;
  json["strange_channels"] = strange;
  return json;
}

}  // namespace jaculus::cli
