// jaculus check: what was understood of problems and robots.

#include "jaculus/effects/check.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "cli/check_dataset.h"
#include "cli/command.h"
#include "jaculus/core/error.h"
#include "jaculus/effects/user_effect.h"
#include "jaculus/model/describe.h"
#include "jaculus/model/robot.h"
#include "jaculus/model/unusual.h"
#include "jaculus/simulation/experiment.h"
#include "jaculus/studies/study.h"
#include "jaculus/trajectory/dataset.h"
#include "jaculus/transcription/describe.h"
#include "jaculus/transcription/nonlinear_program.h"
#include "report/document/text_table.h"

namespace jaculus::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct CheckOptions {
  Common common;
  std::vector<std::string> files;
  std::string experiment;  ///< in which effects are tried
  bool explain = false;
  bool strict = false;
};

/// A folder with a robot.yaml, or a name that no file has: robots are looked up by name.
bool names_robot(const fs::path& path) {
  if (path.filename() == "robot.yaml" || path.filename() == "robot.urdf") return true;
  return fs::is_directory(path) ||
         (!fs::exists(path) && !path.has_extension() && !path.has_parent_path());
}

Json check_robot(const fs::path& path, bool strict, std::string& text) {
  const bool file = path.filename() == "robot.yaml" || path.filename() == "robot.urdf";
  fs::path folder = file ? path.parent_path() : path;
  if (folder.empty()) folder = ".";
  if (!fs::is_directory(folder))
    folder = model::find_robot(path.string(), fs::current_path() / "robot");
  const auto reading = strict ? model::Reading::strict : model::Reading::lenient;
  const model::Robot robot = model::read_robot(folder, {}, reading);
  const model::PlanarModel& m = robot.planar;
  const std::vector<std::string> paths = model::override_paths(folder);
  const std::vector<std::string> unusual = model::unusual_values(m);
  text += model::describe_robot(robot);
  for (const std::string& value : unusual) text += "  note: " + value + "\n";
  text += "values that a problem may override\n";
  for (const std::string& line : paths) text += "  " + line + "\n";
  Json json = {{"robot", robot.name}, {"mass_kg", m.total_mass()}, {"coordinates", Json::array()}};
  for (const model::Coordinate& coordinate : m.coordinates)
    json["coordinates"].push_back(coordinate.name);
  json["notes"] = robot.notes;
  json["unusual"] = unusual;
  json["override_paths"] = paths;

  return json;
}

/// Whether a file's `format` begins so.
bool has_format(const fs::path& path, std::string_view kind) {
  if (!fs::is_regular_file(path) || path.extension() == ".urdf") return false;
  const yaml::Node root = yaml::Node::load(path);
  if (!root.is_map()) return false;
  const auto format = root.find("format");
  return format && format->is_scalar() && format->text().starts_with(kind);
}

bool names_study(const fs::path& path) { return has_format(path, "jaculus-study/"); }

bool names_effect(const fs::path& path) { return has_format(path, "jaculus-effect/"); }

/// Tries a user's effect in an experiment; `passed` turns false where something fails.
Json check_effect_file(const fs::path& file, const std::string& experiment, std::string& text,
                       bool& passed) {
  const effects::UserEffect user = effects::read_user_effect(file);
  const fs::path shown_in = experiment.empty() ? user.experiment : fs::path(experiment);
  if (shown_in.empty())
    throw InputError(
        fmt::format("{}: no experiment to try it in; allowed: --experiment FILE, or the key "
                    "`experiment`",
                    file.string()));
  const simulation::Experiment tried = simulation::read_experiment(shown_in);
  user.require(simulation::dataset_robot(tried.setup).planar);

  text += fmt::format("{}: {}\n  in {} on {}\n", user.effect.name, user.effect.caption, tried.name,
                      tried.setup.robot);
  report::TextTable parameters({"parameter", "unit", "nominal", "bounds", "scale"});
  for (const effects::EffectParameter& p : user.effect.parameters)
    parameters.row({p.name, p.unit, fmt::format("{}", p.nominal),
                    fmt::format("{} to {}", p.bounds.lower, p.bounds.upper),
                    fmt::format("{}", p.scale)});
  text += parameters.text();

  report::TextTable table({"check", "result", "found"});
  Json json = {{"effect", user.effect.name}, {"experiment", tried.name}, {"checks", Json::array()}};
  for (const effects::Check& check : effects::check_effect(user.effect, tried)) {
    table.row({check.what, check.passed ? "ok" : "FAILED", check.found});
    json["checks"].push_back(
        {{"what", check.what}, {"found", check.found}, {"passed", check.passed}});
    passed = passed && check.passed;
  }
  text += table.text();
  json["hints"] = effects::scale_hints(user.effect, tried);
  for (const Json& hint : json["hints"]) text += "  hint: " + hint.get<std::string>() + "\n";
  return json;
}

Json check_study_file(const fs::path& file, std::string& text) {
  const std::string understood = studies::check_study(file);
  text += understood + "\n";
  return {{"study", understood}};
}

Json check_problem_file(const fs::path& file, const Common& common, std::string& text) {
  const Loaded loaded = load(file, common);
  const model::PlanarModel model =
      transcription::planning_model(loaded.problem, loaded.robot.planar);
  text += transcription::describe_problem_text(loaded.problem, loaded.robot);

  // Laid out in full: what the terms refuse is bad input as well.
  const transcription::NonlinearProgram program(loaded.problem, model);
  const int jacobian = program.jacobian_sparsity().size();
  const int hessian = program.hessian_sparsity().size();
  text += fmt::format("  size          {} variables, {} rows, {} Jacobian and {} Hessian entries\n",
                      program.variables(), program.rows(), jacobian, hessian);
  for (const std::string& note : program.notes()) text += "  layout: " + note + "\n";
  for (const std::string& note : loaded.robot.notes) text += "  robot: " + note + "\n";
  const std::vector<std::string> unusual = model::unusual_values(model);
  for (const std::string& value : unusual) text += "  note: " + value + "\n";
  Json json = transcription::describe_problem(loaded.problem);
  json["robot_notes"] = loaded.robot.notes;
  json["unusual"] = unusual;
  json["layout_notes"] = program.notes();
  json["size"] = {{"variables", program.variables()},
                  {"constraints", program.rows()},
                  {"jacobian_nonzeros", jacobian},
                  {"hessian_nonzeros", hessian}};

  return json;
}

/// The help on a kind of file; nothing for what is no kind.
std::optional<std::string> explanation_of(const std::string& kind) {
  if (kind == "problem") return transcription::explain_problem();
  if (kind == "robot") return model::explain_robot();
  if (kind == "experiment") return simulation::explain_experiment();
  if (kind == "dataset") return trajectory::explain_dataset();
  if (kind == "effect") return effects::explain_effect();
  return std::nullopt;
}

/// Prints the help on the kinds that are named, on problems where none is, and takes them out.
void explain(CheckOptions& options) {
  std::string text;
  std::vector<std::string> files;
  for (const std::string& name : options.files) {
    if (const auto found = explanation_of(name)) {
      text += (text.empty() ? "" : "\n") + *found;
    } else if (fs::exists(name) || fs::path(name).has_extension()) {
      files.push_back(name);
    } else {
      throw InputError(fmt::format(
          "--explain: '{}' given; allowed: problem, robot, experiment, dataset, effect, or files",
          name));
    }
  }
  if (text.empty()) text = transcription::explain_problem();
  print(options.common.json ? Json{{"explanation", text}}.dump(1) + "\n" : text);
  options.files = std::move(files);
}

/// What --quiet prints as well: why the exit code is not 0.
void show_contradictions(const Json& json) {
  for (const Json& file : json)
    for (const Json& found : file.value("contradictions", Json::array()))
      fmt::print(stderr, "jaculus: {}: {}\n", file["file"].get<std::string>(),
                 found.get<std::string>());
}

int run_check(CheckOptions options) {
  if (options.explain) {
    explain(options);
    if (options.files.empty()) return kDone;
  }

  if (options.files.empty())
    throw InputError(
        "check: no file given; allowed: problem files, study files, effect files and robots, or "
        "--explain");
  Json json = Json::array();
  std::string text;
  bool passed = true;
  for (const std::string& file : options.files) {
    json.push_back(names_dataset(file)  ? check_dataset(file, text)
                   : names_study(file)  ? check_study_file(file, text)
                   : names_effect(file) ? check_effect_file(file, options.experiment, text, passed)
                   : names_robot(file)  ? check_robot(file, options.strict, text)
                                        : check_problem_file(file, options.common, text));
    json.back()["file"] = file;
    passed = passed && json.back().value("contradictions", Json::array()).empty();
  }

  if (options.common.json) {
    print(json.dump(1) + "\n");
  } else if (!options.common.quiet) {
    print(text);
  } else {
    show_contradictions(json);
  }
  return passed ? kDone : kNotSolved;
}

}  // namespace

void add_check(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App* command = app.add_subcommand(
      "check",
      "Validates problems, studies, effects and robots; prints what was understood, with sizes.");
  command->footer("Example:\n  jaculus check problems/leap_tail.yaml minitaur_tail");
  command->add_option("files", options->files,
                      "files of problems, studies or effects, robot folders or robot names");
  command->add_flag(
      "--explain", options->explain,
      "print every key with its meaning, unit and default: of a problem, or of what is named, "
      "problem, robot, experiment, dataset, effect");
  command->add_option("--experiment", options->experiment,
                      "experiment in which effects are tried, instead of the one that they name");
  command->add_flag("--strict", options->strict,
                    "refuse a robot of whose URDF something is skipped or assumed");
  command->add_flag("--json", options->common.json,
                    "machine-readable result on standard output, nothing else there");
  command->add_flag("--quiet", options->common.quiet, "print nothing but errors");
  command->callback([options, &chosen] { chosen = [options] { return run_check(*options); }; });
}

}  // namespace jaculus::cli
