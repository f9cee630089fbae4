#include "cli/check_dataset.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "cli/dataset_doubts.h"
#include "jaculus/core/error.h"
#include "jaculus/core/json.h"
#include "jaculus/model/unusual.h"
#include "jaculus/simulation/experiment.h"
#include "jaculus/trajectory/leap_accelerations.h"
#include "report/document/text_table.h"

namespace jaculus::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string format_of(const fs::path& path) {
  if (!fs::is_regular_file(path) || (path.extension() != ".yaml" && path.extension() != ".yml"))
    return "";
  const yaml::Node root = yaml::Node::load(path);
  if (!root.is_map()) return "";
  const auto format = root.find("format");
  return format && format->is_scalar() ? format->dump() : "";
}

double duration_of(const trajectory::Table& plan) {
  return plan.values(plan.values.rows() - 1, plan.column("time"));
}

std::string shown(double value) {
  return std::isfinite(value) ? fmt::format("{:.3f}", value) : "-";
}

Json streams_of(const trajectory::Dataset& dataset, std::string& text) {
  report::TextTable table(
      {"trial", "stream", "channels", "samples", "from [s]", "to [s]", "stated [Hz]", "gaps"});

  Json json = Json::array();
  for (const trajectory::Trial& trial : dataset.trials) {
    for (const trajectory::Stream& stream : trial.streams) {
      const auto gaps = stream.values.array().isNaN().count();
      const double to = stream.time[stream.time.size() - 1];
      table.row({trial.name, stream.name, fmt::format("{}", stream.channels.size()),
                 fmt::format("{}", stream.time.size()), shown(stream.time[0]), shown(to),
                 std::isnan(stream.rate_hz) ? "-" : fmt::format("{}", stream.rate_hz),
                 fmt::format("{}", gaps)});
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
Json accelerations(const trajectory::Dataset& dataset, std::string& text) {
  const auto all = trajectory::leap_accelerations(dataset);
  if (!all) return nullptr;

  Json trials = Json::object();
  report::TextTable table({"trial", "start [s]", "v at start + T [m/s]", "v/T [m/s^2]"});
  for (const auto& [trial, found] : all->trials) {
    table.row({trial, found ? fmt::format("{:.4f}", found->start) : "-",
               found ? shown(found->speed) : "-", found ? shown(found->acceleration) : "-"});
    trials[trial] = found ? Json(found->acceleration) : Json(nullptr);
  }

  text += "acceleration from motion capture by the authors' recipe\n" + table.text() +
          fmt::format("mean {} m/s^2; the plan's own v/T at its end {} m/s^2 (T = {:.5f} s)\n",
                      shown(all->mean), shown(all->plan), all->duration);
  return {{"trials", trials},
          {"mean_m_s2", json_number(all->mean)},
          {"plan_m_s2", json_number(all->plan)},
          {"duration_s", all->duration}};
}

/// Of the robot with the dataset's bus voltage.
std::vector<std::string> unusual_values(const trajectory::Dataset& dataset,
                                        const model::Robot& robot) {
  return model::unusual_values(simulation::dataset_plant(dataset, robot.planar).model);
}

std::string head_text(const trajectory::Dataset& dataset, const model::Robot& robot,
                      const std::vector<std::string>& unusual) {
  const trajectory::StatedController& c = dataset.controller;
  std::string text =
      fmt::format("  robot         {} ({} coordinates, {} motors, {:.4g} kg)\n", robot.name,
                  robot.planar.size(), robot.planar.motors.size(), robot.planar.total_mass());
  text += fmt::format("  controller    {}, ", name_of(c.kind));
  text += c.kind == trajectory::ControllerKind::measured
              ? fmt::format("input {}\n", name_of(c.input))
              : fmt::format("{} at {} Hz\n", name_of(c.quantity), c.rate_hz);
  if (dataset.plan)
    text += fmt::format("  plan          {} samples, {:.5g} s\n", dataset.plan->values.rows(),
                        duration_of(*dataset.plan));
  if (dataset.script)
    text += fmt::format("  input         {} of {}, {} steps\n", name_of(dataset.script->quantity),
                        fmt::join(dataset.script->joints, ", "), dataset.script->time.size());
  for (const std::string& note : robot.notes) text += "  robot: " + note + "\n";
  for (const std::string& value : unusual) text += "  note: " + value + "\n";
  for (const std::string& note : dataset.notes) text += "  note: " + note + "\n";
  return text;
}

/// What is commanded must be this robot's: the plan names every motor of it, the script only motors
/// of it.
void check_command(const trajectory::Dataset& dataset, const model::PlanarModel& model) {
  if (dataset.plan || dataset.script) (void)simulation::stated_controller(dataset, model, {});
  (void)simulation::dataset_plant(dataset, model);
  simulation::require_units(dataset, model);
}

/// Plays the first instant of a trial: what a run refuses is refused here.
void begin_trial(simulation::Experiment experiment, const model::PlanarModel& model) {
  constexpr double kInstant = 1e-3;  // [s] two steps of what a simulation records
  experiment.duration = kInstant;
  (void)simulation::run_trial(experiment, simulation::dataset_plant(experiment.setup, model),
                              simulation::experiment_controller(experiment, model), 0, 0);
}

Json check_experiment(const fs::path& path, std::string& text) {
  const simulation::Experiment experiment = simulation::read_experiment(path);
  const model::Robot robot = simulation::dataset_robot(experiment.setup);
  begin_trial(experiment, robot.planar);
  text += fmt::format("{}: {} experiment, {} trials of {} s after {} s at rest, seed {}\n",
                      experiment.name, name_of(experiment.setup.experiment), experiment.trials,
                      experiment.duration, experiment.lead, experiment.seed);
  const std::vector<std::string> unusual = unusual_values(experiment.setup, robot);
  text += head_text(experiment.setup, robot, unusual);

  Json streams = Json::array();
  for (const simulation::SensorStream& stream : experiment.streams) {
    text += fmt::format("  {:<13} {} Hz: {}\n", stream.name, stream.rate_hz,
                        fmt::join(stream.channels, ", "));
    streams.push_back({{"name", stream.name},
                       {"rate_hz", stream.rate_hz},
                       {"channels", stream.channels},
                       {"noise", stream.noise}});
  }

  return {{"experiment", experiment.name},
          {"kind", name_of(experiment.setup.experiment)},
          {"robot", robot.name},
          {"trials", experiment.trials},
          {"seed", experiment.seed},
          {"streams", streams},
          {"notes", experiment.setup.notes},
          {"unusual", unusual}};
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

  const trajectory::Dataset dataset = trajectory::read_dataset(path);
  const model::Robot robot = simulation::dataset_robot(dataset);
  check_command(dataset, robot.planar);
  text += fmt::format(
      "{}: {} dataset, {} trials\n",
      dataset.folder.filename().empty() ? "dataset" : dataset.folder.filename().string(),
      name_of(dataset.experiment), dataset.trials.size());
  const std::vector<std::string> unusual = unusual_values(dataset, robot);
  text += head_text(dataset, robot, unusual);
  const DatasetDoubts doubts = dataset_doubts(dataset, robot);
  text += to_text(doubts);
  Json json = {{"dataset", name_of(dataset.experiment)},
               {"robot", robot.name},
               {"trials", dataset.trials.size()}};
  json["streams"] = streams_of(dataset, text);
  json["recipe"] = accelerations(dataset, text);
  json["notes"] = dataset.notes;
  json["robot_notes"] = robot.notes;
  json["unusual"] = unusual;
  json["strange_channels"] = doubts.strange_channels;
  json["contradictions"] = doubts.contradictions;

  return json;
}

}  // namespace jaculus::cli
