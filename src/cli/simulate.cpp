// jaculus simulate: plays a plan or an experiment on a plant and writes what its sensors saw.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/margins.h"
#include "cli/reporting.h"
#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/core/json.h"
#include "jaculus/effects/select.h"
#include "jaculus/effects/user_effect.h"
#include "jaculus/report/dataset_report.h"
#include "jaculus/simulation/experiment.h"
#include "report/document/text_table.h"

namespace jaculus::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct SimulateOptions {
  Common common;
  std::string target;
  std::string robot;
  std::string controller;
  std::optional<int> trials;
  std::vector<std::string> effects;
  std::vector<std::string> effect_files;
  std::string augmented;  ///< file of a diagnosis
  int perturb = 0;
};

bool is_plan(const fs::path& target) { return target.extension() == ".csv"; }

/// The target as a file: a folder stands for the plan that `solve` wrote into it.
fs::path target_file(const SimulateOptions& options) {
  const fs::path target = options.target;
  if (!fs::exists(target))
    throw InputError(
        fmt::format("{}: there is no such file; allowed: an experiment (YAML), a plan (CSV) or the "
                    "folder of a plan",
                    options.target));
  if (!fs::is_directory(target)) return target;
  if (fs::is_regular_file(target / "plan.csv")) return target / "plan.csv";
  throw InputError(fmt::format(
      "{}: no plan.csv in this folder; allowed: an experiment (YAML), a plan (CSV) or its folder",
      options.target));
}

simulation::Experiment load_experiment(const SimulateOptions& options) {
  const fs::path file = target_file(options);
  simulation::Experiment experiment;
  if (is_plan(file)) {
    if (options.robot.empty())
      throw InputError(fmt::format(
          "{}: a plan needs --robot; allowed: a folder of models/, or a path", options.target));
    experiment = simulation::plan_experiment(file, options.robot, options.controller);
  } else {
    if (!options.robot.empty() || !options.controller.empty())
      throw InputError(
          fmt::format("{}: given for an experiment, which states its own; allowed: with a plan",
                      options.robot.empty() ? "--controller" : "--robot"));
    experiment = simulation::read_experiment(file);
  }
  if (options.trials) experiment.trials = *options.trials;
  if (options.common.seed) experiment.seed = *options.common.seed;
  return experiment;
}

Json state_json(const simulation::LeapState& state, double duration) {
  return {{"time_s", json_number(state.time)},
          {"speed_m_s", json_number(state.speed)},
          {"acceleration_m_s2", json_number(state.speed / duration)},
          {"pitch_rad", json_number(state.pitch)},
          {"landing_pitch_rad", json_number(state.landing_pitch)}};
}

Json figures_json(const simulation::LeapFigures& figures) {
  Json json = {{"duration_s", json_number(figures.duration)}};
  const double true_acceleration = figures.plan_end.speed / figures.duration;
  for (const auto& [key, recipe] : {std::pair("recipe", &figures.recipe),
                                    std::pair("recipe_without_noise", &figures.recipe_exact)}) {
    json[key] = nullptr;
    if (!*recipe) continue;
    json[key] = {{"start_s", (*recipe)->start},
                 {"speed_m_s", (*recipe)->speed},
                 {"acceleration_m_s2", (*recipe)->acceleration},
                 {"bias_m_s2", json_number((*recipe)->acceleration - true_acceleration)}};
  }
  json["plan_end"] = state_json(figures.plan_end, figures.duration);
  json["lift_off"] =
      figures.lift_off ? state_json(*figures.lift_off, figures.duration) : Json(nullptr);
  return json;
}

Json trial_json(const simulation::Experiment& experiment, const model::PlanarModel& model,
                const simulation::TrialRun& run) {
  Json json = {{"name", run.trial.name},
               {"status", simulation::status_name(run.truth.status)},
               {"end_time_s", json_number(run.truth.end_time)}};
  if (!run.truth.message.empty()) json["message"] = run.truth.message;
  json["streams"] = Json::array();
  for (const trajectory::Stream& stream : run.trial.streams)
    json["streams"].push_back({{"name", stream.name},
                               {"samples", stream.time.size()},
                               {"gaps", stream.values.array().isNaN().count()}});
  json["final"] = Json::object();

  for (int i = 0; i < model.size() && run.truth.time.size() > 0; ++i)
    json["final"][model.coordinates[i].name] = json_number(run.truth.q(i, run.truth.q.cols() - 1));
  json["events"] = Json::array();
  const char* const kinds[] = {"lift", "land", "slip", "stick", "stop", "release", "limit"};
  for (const simulation::Event& event : run.truth.events)
    json["events"].push_back({{"time_s", event.time},
                              {"kind", kinds[static_cast<int>(event.kind)]},
                              {"what", event.what}});
  if (experiment.setup.experiment == trajectory::ExperimentKind::leap)
    json["leap"] = figures_json(simulation::leap_figures(experiment, model, run));

  return json;
}

std::string leap_text(const Json& trials) {
  report::TextTable table({"trial", "start [s]", "recipe v/T", "bias", "without noise", "bias",
                           "v/T at plan end", "lift-off [s]", "v at lift-off", "landing pitch"});

  for (const Json& trial : trials) {
    const Json& leap = trial["leap"];
    const auto at = [&](const char* part, const char* key) {
      return leap[part].is_object() ? leap[part][key] : Json(nullptr);
    };
    table.row({trial["name"].get<std::string>(), cell(at("recipe", "start_s"), "{:.4f}"),
               cell(at("recipe", "acceleration_m_s2")), cell(at("recipe", "bias_m_s2"), "{:+.3f}"),
               cell(at("recipe_without_noise", "acceleration_m_s2")),
               cell(at("recipe_without_noise", "bias_m_s2"), "{:+.3f}"),
               cell(at("plan_end", "acceleration_m_s2")), cell(at("lift_off", "time_s"), "{:.4f}"),
               cell(at("lift_off", "speed_m_s")), cell(at("plan_end", "landing_pitch_rad"))});
  }

  return table.text() +
         "recipe: the authors' way from motion capture to v/T [m/s^2], with its bias against the "
         "simulated state at "
         "the plan's end\n";
}

std::string trials_text(const Json& trials) {
  report::TextTable table({"trial", "status", "end [s]", "stream", "samples", "gaps", "events"});
  for (const Json& trial : trials) {
    bool first = true;
    for (const Json& stream : trial["streams"]) {
      table.row({first ? trial["name"].get<std::string>() : "",
                 first ? trial["status"].get<std::string>() : "",
                 first ? cell(trial["end_time_s"]) : "", stream["name"].get<std::string>(),
                 stream["samples"].dump(), stream["gaps"].dump(),
                 first ? fmt::format("{}", trial["events"].size()) : ""});
      first = false;
    }
    if (first)
      table.row({trial["name"].get<std::string>(), trial["status"].get<std::string>(),
                 cell(trial["end_time_s"]), "-", "0", "0", "0"});
  }
  return table.text();
}

std::string effects_text(const std::vector<effects::EffectValue>& effects) {
  std::string text;
  for (const effects::EffectValue& value : effects) {
    text += (text.empty() ? "" : "; ") + value.effect->name;
    for (const effects::ShownParameter& p : effects::shown_parameters(*value.effect, value.theta))
      text += fmt::format(" {}={} {}", p.name, p.value, p.unit);
  }
  return text.empty() ? "none" : text;
}

/// A robot that is named by its place stands in the dataset in full, for the dataset lies
/// elsewhere.
std::string robot_of(const simulation::Experiment& experiment) {
  const fs::path folder = model::find_robot(experiment.setup.robot, experiment.setup.folder);
  const fs::path beside = (experiment.setup.folder / experiment.setup.robot).lexically_normal();
  return folder == beside ? fs::absolute(folder).lexically_normal().string()
                          : experiment.setup.robot;
}

struct Result {
  trajectory::Dataset dataset;
  Json summary;
  bool done = true;
};

Result run_trials(const simulation::Experiment& experiment,
                  const std::vector<effects::EffectValue>& effects,
                  const model::PlanarModel& model) {
  simulation::Plant plant = simulation::dataset_plant(experiment.setup, model);
  effects::apply_effects(effects, plant);
  const simulation::Controller controller = simulation::experiment_controller(experiment, model);
  Result result;
  result.dataset = experiment.setup;
  result.dataset.robot = robot_of(experiment);
  result.dataset.provenance =
      fmt::format("Simulated by jaculus {} from {}, seed {}; effects: {}.", version(),
                  experiment.name, experiment.seed, effects_text(effects));
  result.summary = {{"experiment", experiment.name},    {"robot", experiment.setup.robot},
                    {"seed", experiment.seed},          {"version", version()},
                    {"effects", effects_text(effects)}, {"trials", Json::array()}};

  for (int i = 0; i < experiment.trials && !interrupt_requested(); ++i) {
    simulation::TrialRun run =
        simulation::run_trial(experiment, plant, controller, i, experiment.seed);
    result.summary["trials"].push_back(trial_json(experiment, model, run));
    result.done = result.done && run.truth.status == simulation::SimulationStatus::done;
    result.dataset.trials.push_back(std::move(run.trial));
  }

  return result;
}

void show(const simulation::Experiment& experiment, const Result& result,
          const SimulateOptions& options) {
  if (options.common.json) return print(result.summary.dump(1) + "\n");
  if (options.common.quiet) return;

  const trajectory::StatedController& c = experiment.setup.controller;
  std::string text =
      fmt::format("{}: {} on {}, {} controller ({}) at {} Hz, effects: {}\n", experiment.name,
                  name_of(experiment.setup.experiment), experiment.setup.robot, name_of(c.kind),
                  name_of(c.quantity), c.rate_hz, result.summary["effects"].get<std::string>());
  for (const std::string& note : experiment.setup.notes) text += "note: " + note + "\n";
  text += trials_text(result.summary["trials"]);

  for (const Json& trial : result.summary["trials"])
    if (trial.contains("message"))
      text += fmt::format("{}: {}\n", trial["name"].get<std::string>(),
                          trial["message"].get<std::string>());
  if (experiment.setup.experiment == trajectory::ExperimentKind::leap)
    text += "\n" + leap_text(result.summary["trials"]);
  if (result.summary.contains("perturb")) text += "\n" + perturb_text(result.summary["perturb"]);
  if (!options.common.out.empty() && !result.dataset.trials.empty())
    text += fmt::format("written to {}\n", options.common.out);
  print(text);
}

/// Effects of --augmented, then those of --effect.
std::vector<effects::EffectValue> effects_of(const SimulateOptions& options,
                                             const model::PlanarModel& model) {
  std::vector<std::string> files = options.effect_files;
  std::vector<std::pair<std::string, std::string>> texts;  // with their places
  if (!options.augmented.empty()) {
    const effects::AugmentedEffects augmented = effects::read_augmented(options.augmented);
    files.insert(files.end(), augmented.files.begin(), augmented.files.end());
    for (const std::string& text : augmented.effects) texts.emplace_back(text, options.augmented);
  }
  for (const std::string& text : options.effects) texts.emplace_back(text, "--effect");

  const effects::Catalogue catalogue = effects::catalogue_with(files, {model});
  std::vector<effects::EffectValue> values;
  for (const auto& [text, place] : texts)
    values.push_back(effects::read_effect(text, model, place, catalogue));
  for (const effects::Effect& own : catalogue) {
    const auto is_own = [&](const effects::EffectValue& v) { return v.effect->file == own.file; };
    if (!own.file.empty() && std::none_of(values.begin(), values.end(), is_own))
      throw InputError(fmt::format("--effects: no --effect names '{}' of {}; allowed: {}:{}=...",
                                   own.name, own.file, own.name, own.parameters.front().name));
  }
  return values;
}

int run_simulate(const SimulateOptions& options) {
  const simulation::Experiment experiment = load_experiment(options);
  const model::PlanarModel model = simulation::dataset_robot(experiment.setup).planar;
  const std::vector<effects::EffectValue> effects = effects_of(options, model);
  if (options.perturb > 0 && experiment.uncertainties.empty())
    throw InputError(
        fmt::format("--perturb: {} states no uncertainties; allowed: an experiment with a block "
                    "`uncertainties:`",
                    experiment.name));
  check_figures(options.common);
  if (!options.common.out.empty()) prepare_folder(options.common.out);
  Result result = run_trials(experiment, effects, model);
  if (options.perturb > 0 && !interrupt_requested()) {
    result.summary["perturb"] = perturb_json(simulation::replays(
        experiment, options.perturb, experiment.seed,
        [&](simulation::Plant& plant) { effects::apply_effects(effects, plant); }));
  }

  std::erase_if(result.dataset.trials,
                [](const trajectory::Trial& trial) { return trial.streams.empty(); });
  if (!options.common.out.empty() && !result.dataset.trials.empty()) {
    trajectory::write_dataset(result.dataset, options.common.out);
    trajectory::write_file(fs::path(options.common.out) / "summary.json",
                           result.summary.dump(1) + "\n");
  }

  show(experiment, result, options);
  if (!result.dataset.trials.empty())
    write_reporting(report::dataset_report(result.dataset, model, experiment.name), options.common);
  if (interrupt_requested())
    fmt::print(stderr, "jaculus: interrupted; the trials that are done are kept\n");

  return result.done && !interrupt_requested() ? kDone : kNotSolved;
}

}  // namespace

void add_simulate(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<SimulateOptions>();
  CLI::App* command =
      app.add_subcommand("simulate", "Plays a plan or an experiment on a plant; writes a dataset.");
  command->footer(
      "Writes dataset.yaml, the trials, summary.json and report.html into --out; exit code 1 where "
      "a simulation did "
      "not end.\n"
      "Example:\n  jaculus simulate problems/leap_trials.yaml --trials 6 --seed 1 --effect "
      "tail_compliance:stiffness=98 "
      "--out out/trials\n  jaculus simulate out/leap/plan.csv --robot minitaur_tail");
  command
      ->add_option("target", options->target, "experiment (YAML), plan (CSV) or folder of a plan")
      ->required();
  add_common(*command, options->common, "folder for the dataset; nothing is written unless given");
  add_figures(*command, options->common);
  command->add_option("--robot", options->robot,
                      "robot that a plan is played on: a folder of models/, or a path");

  command->add_option("--controller", options->controller,
                      "controller that a plan is played with, as in a dataset: \"{kind: "
                      "feedforward_pd, quantity: torque, "
                      "rate_hz: 1000, kp: 3.3, kd: 0.08}\"");
  command->add_option("--trials", options->trials, "number of trials, instead of the experiment's")
      ->check(whole_number(1, 100000));
  command
      ->add_option("--effect", options->effects,
                   "name:parameter=value,... of an effect of the plant in SI units; may be given "
                   "several times")
      ->allow_extra_args(false);
  command
      ->add_option("--effects", options->effect_files,
                   "file of an effect of your own, for --effect; may be given several times")
      ->allow_extra_args(false);
  command->add_option("--augmented", options->augmented,
                      "augmented.yaml of a diagnosis: its effects, those of your own among them");
  command
      ->add_option("--perturb", options->perturb,
                   "replays under the experiment's uncertainties, with their margins")
      ->check(whole_number(0, 100000));
  command->callback([options, &chosen] { chosen = [options] { return run_simulate(*options); }; });
}

}  // namespace jaculus::cli
