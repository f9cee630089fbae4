// jaculus view: a robot moving along a plan or a log, in the browser.

#include <fmt/format.h>

#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <variant>

#include "cli/command.h"
#include "jaculus/core/error.h"
#include "jaculus/report/view3d.h"

namespace jaculus::cli {
namespace {

namespace fs = std::filesystem;

struct ViewOptions {
  Common common;
  std::string motion;
  std::string robot;
  std::string trial;
};

/// What is to be seen: a motion, its robot, and where the robot's name was found.
struct Seen {
  std::variant<trajectory::Table, trajectory::Trial> motion;
  std::string robot, title;
  fs::path from;
};

/// The robot of the problem behind a plan, as found from the plan's folder; empty where no summary
/// tells.
std::string robot_of_plan(const fs::path& folder) {
  std::ifstream stream(folder / "summary.json");
  if (!stream) return {};
  const auto json = nlohmann::ordered_json::parse(stream, nullptr, false);
  if (!json.is_object() || !json.contains("problem")) return {};
  return json.value("robot_folder", json["problem"].value("robot", ""));
}

Seen see_dataset(const ViewOptions& options) {
  const trajectory::Dataset dataset = trajectory::read_dataset(options.motion);
  std::vector<std::string> names;
  for (const trajectory::Trial& trial : dataset.trials) {
    names.push_back(trial.name);
    if (options.trial.empty() || trial.name == options.trial)
      return {trial, dataset.robot,
              fmt::format("{}, {}", dataset.folder.filename().string(), trial.name),
              dataset.folder};
  }
  throw InputError(fmt::format("--trial {}: no such trial{}; allowed: {}", options.trial,
                               yaml::did_you_mean(options.trial, names),
                               names.empty() ? "none" : names.front() + ", ..."));
}

Seen see(const ViewOptions& options) {
  const fs::path path = options.motion;
  if (fs::exists(path / "dataset.yaml") || path.filename() == "dataset.yaml")
    return see_dataset(options);
  if (!options.trial.empty())
    throw InputError("--trial: given with a plan; allowed: with a dataset");
  const fs::path file = fs::is_directory(path) ? path / "plan.csv" : path;
  if (!fs::is_regular_file(file)) {
    throw InputError(fmt::format(
        "{}: not found; allowed: the folder of a solve, a plan.csv, or a dataset", file.string()));
  }
  const trajectory::Table table = trajectory::read_csv(file);
  if (table.column("time") < 0)
    throw InputError(fmt::format("{}:1: no column 'time [s]'; allowed: a plan", file.string()));
  const fs::path folder = fs::absolute(file).parent_path();
  return {table, robot_of_plan(folder), folder.filename().string(), folder};
}

int run_view(const ViewOptions& options) {
  const Seen seen = see(options);
  const std::string name = options.robot.empty() ? seen.robot : options.robot;
  if (name.empty())
    throw InputError(
        fmt::format("{}: nothing beside it names its robot; give --robot", options.motion));
  const model::Robot robot = model::read_robot(
      model::find_robot(name, options.robot.empty() ? seen.from : fs::current_path()));

  const std::string page =
      std::visit([&](const auto& motion) { return report::view3d_html(robot, motion, seen.title); },
                 seen.motion);
  trajectory::write_file(options.common.out, page);
  if (!options.common.quiet) print(fmt::format("view: {}\n", options.common.out));
  return kDone;
}

}  // namespace

void add_view(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<ViewOptions>();
  CLI::App* command = app.add_subcommand(
      "view", "Shows a robot moving along a plan or a log, in three dimensions.");
  command->footer(
      "Writes one HTML file that opens from disk.\nExample:\n  jaculus view leap --out leap.html");
  command->add_option("motion", options->motion, "folder of a solve, a plan.csv, or a dataset")
      ->required();
  command->add_option("--robot", options->robot,
                      "robot, where the plan does not say it or for another one");
  command->add_option("--trial", options->trial, "trial of a dataset, the first one unless given");
  command->add_option("--out", options->common.out, "HTML file")->required();
  command->add_flag("--quiet", options->common.quiet, "print nothing but errors");
  command->callback([options, &chosen] { chosen = [options] { return run_view(*options); }; });
}

}  // namespace jaculus::cli
