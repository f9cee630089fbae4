// jaculus simulate: plays a plan or an experiment on a plant and writes what its sensors saw.

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/margins.h"
#include "cli/reporting.h"
#include "jaculus/core/error.h"
#include "jaculus/core/executor.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/core/journal.h"
#include "jaculus/core/tasks.h"
#include "jaculus/effects/select.h"
#include "jaculus/effects/trials.h"
#include "jaculus/report/dataset_report.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::cli {
namespace {

namespace fs = std::filesystem;

struct SimulateOptions {
  Common common;
  std::string target;
  std::string robot;
  std::string controller;
  std::optional<int> trials;
  std::vector<std::string> effects;
  std::vector<std::string> effect_files;
  std::string augmented;  ///< file of a diagnosis
  bool explain = false;
  int perturb = 0;
  bool resume = false;  ///< of replays on a cluster
};

bool is_plan(const fs::path& target) { return target.extension() == ".csv"; }

/// The target as a file: a folder stands for the plan that `solve` wrote into it.
fs::path target_file(const SimulateOptions& options) {
  const fs::path target = find_problem_file(options.target);
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

/// Why trials did not end, which --quiet prints as well.
void show_failures(const nlohmann::ordered_json& summary) {
  for (const auto& trial : summary["trials"])
    if (trial.contains("message"))
      fmt::print(stderr, "jaculus: {}: {}\n", trial["name"].get<std::string>(),
                 trial["message"].get<std::string>());
}

void show(const simulation::Experiment& experiment, const effects::SimulatedTrials& result,
          const SimulateOptions& options) {
  if (options.common.json) return print(result.summary.dump(1) + "\n");
  if (options.common.quiet) return show_failures(result.summary);

  std::string text = report::simulation_text(experiment, result.summary);
  if (result.summary.contains("perturb")) text += "\n" + perturb_text(result.summary["perturb"]);
  if (!options.common.out.empty() && !result.dataset.trials.empty())
    text += fmt::format("written to {}\n", options.common.out);
  print(text);
}

/// Everything that replays depend on.
std::string replay_key(const SimulateOptions& options, const simulation::Experiment& experiment) {
  std::string text(version());
  const fs::path robot = model::find_robot(experiment.setup.robot, experiment.setup.folder);
  std::vector<fs::path> files = {target_file(options), robot / "robot.urdf", robot / "robot.yaml"};
  files.insert(files.end(), options.effect_files.begin(), options.effect_files.end());
  if (!options.augmented.empty()) files.emplace_back(options.augmented);
  for (const fs::path& file : files) {
    std::ifstream stream(file, std::ios::binary);
    text.append(std::istreambuf_iterator<char>(stream), {});
  }
  for (const std::string& effect : options.effects) text += " " + effect;
  return fmt::format("replays {:016x} {} {} {}", hash64(text + options.controller), experiment.seed,
                     options.perturb, fs::weakly_canonical(robot).string());
}

/// Replays here or on a cluster; nothing where they were interrupted.
void add_replays(const SimulateOptions& options, const simulation::Experiment& experiment,
                 const std::vector<effects::EffectValue>& effects,
                 effects::SimulatedTrials& result) {
  TaskOptions tasks;
  tasks.workers = options.common.jobs;
  tasks.isolate = false;
  tasks.stage = "replays";
  tasks.notice = notices(options.common);
  tasks.progress = progress_bar(options.common, "replays");
  tasks.executor = make_executor(options.common, jobs_folder(options.common.out));
  if (tasks.executor) tasks.fingerprint = replay_key(options, experiment);

  const auto replays = simulation::replays(
      experiment, options.perturb, experiment.seed,
      [&](simulation::Plant& plant) { effects::apply_effects(effects, plant); }, tasks);
  clear_progress(options.common);
  if (count_of(replays) > options.perturb) result.summary["perturb"] = perturb_json(replays);
}

void check_executor(const SimulateOptions& options) {
  const auto executor = make_executor(options.common, jobs_folder(options.common.out));
  if (executor && options.perturb == 0)
    throw InputError("--executor slurm: given without --perturb; allowed: with replays to run");
  if (!executor && options.resume)
    throw InputError("--resume: given without --executor slurm; allowed: with it");
}

int run_simulate(const SimulateOptions& options) {
  if (options.explain) {
    print(
        "Effects: name, what it is, where it acts; each parameter with its unit, nominal value (no "
        "effect), bounds\nand the standard deviation of its prior.\n" +
        effects::catalogue_text());
    return kDone;
  }
  if (options.target.empty())
    throw InputError("simulate: target is required; allowed: see jaculus simulate --help");
  check_executor(options);
  const simulation::Experiment experiment = load_experiment(options);
  const model::PlanarModel model = simulation::dataset_robot(experiment.setup).planar;
  const std::vector<effects::EffectValue> effects = effects::choose_effects(
      {options.effects, options.effect_files, options.augmented, "--effect", "--effects"}, model);
  if (options.perturb > 0 && experiment.uncertainties.empty())
    throw InputError(
        fmt::format("--perturb: {} states no uncertainties; allowed: an experiment with a block "
                    "`uncertainties:`",
                    experiment.name));
  check_figures(options.common);
  if (!options.common.out.empty()) prepare_folder(options.common.out);
  effects::SimulatedTrials result = effects::simulate_trials(experiment, effects, model);
  if (options.perturb > 0 && !interrupt_requested())
    add_replays(options, experiment, effects, result);

  if (!options.common.out.empty() && !result.dataset.trials.empty()) {
    trajectory::write_dataset(result.dataset, options.common.out);
    trajectory::write_file(fs::path(options.common.out) / "summary.json",
                           result.summary.dump(1) + "\n");
  }

  const auto executor = make_executor(options.common, jobs_folder(options.common.out));
  if (executor && !interrupt_requested()) remove_jobs(*executor);
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
  command->add_option("target", options->target,
                      "experiment (YAML), plan (CSV) or folder of a plan");
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
  command->add_flag("--explain", options->explain,
                    "print every effect of the catalogue with its parameters");
  add_executor(*command, options->common);
  command->add_flag(
      "--resume", options->resume,
      "go on with the replays that an interrupted run on Slurm has finished in --out");
  command->callback([options, &chosen] { chosen = [options] { return run_simulate(*options); }; });
}

}  // namespace jaculus::cli
