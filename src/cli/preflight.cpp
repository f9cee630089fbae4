// jaculus preflight: what a planned experiment could tell, before it is done.

#include "jaculus/diagnosis/preflight.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <memory>

#include "cli/reporting.h"
#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/effects/trials.h"
#include "jaculus/report/preflight_report.h"

namespace jaculus::cli {
namespace {

struct PreflightCommand {
  Common common;
  std::string experiment;
  std::string settings;  ///< file
  std::vector<std::string> effect_files;
  std::optional<int> trials;
  double size = 1.0;
  bool planned_only = false;
};

simulation::Experiment planned_experiment(const PreflightCommand& command) {
  const std::filesystem::path file = find_problem_file(command.experiment);
  if (!std::filesystem::is_regular_file(file))
    throw InputError(fmt::format("{}: there is no such file; allowed: an experiment (YAML)",
                                 command.experiment));
  simulation::Experiment experiment = simulation::read_experiment(file);
  if (command.trials) experiment.trials = *command.trials;
  if (command.common.seed) experiment.seed = *command.common.seed;
  return experiment;
}

int run_preflight(const PreflightCommand& command) {
  restore_default_interrupts();
  const simulation::Experiment experiment = planned_experiment(command);
  diagnosis::PreflightOptions options;
  if (!command.settings.empty())
    options.diagnosis.settings = diagnosis::read_settings(command.settings);
  options.diagnosis.catalogue = std::make_shared<const effects::Catalogue>(
      effects::catalogue_for(command.effect_files, {experiment.setup}));
  options.size = command.size;
  options.alternatives = !command.planned_only;

  check_figures(command.common);
  if (!command.common.out.empty()) prepare_folder(command.common.out);
  const tbb::global_control workers(tbb::global_control::max_allowed_parallelism,
                                    command.common.jobs);
  options.diagnosis.progress = stage_bar(command.common, {});
  const diagnosis::Preflight preflight = diagnosis::preflight(experiment, options);
  options.diagnosis.progress = {};
  clear_progress(command.common);

  if (!command.common.out.empty()) diagnosis::write_preflight(preflight, command.common.out);
  if (command.common.json)
    print(diagnosis::preflight_json(preflight));
  else if (!command.common.quiet)
    print(diagnosis::preflight_text(preflight));
  write_reporting(report::preflight_report(preflight), command.common);
  return preflight.reasons.empty() ? kDone : kNotSolved;
}

}  // namespace

void add_preflight(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<PreflightCommand>();
  options->common.jobs = 2;
  CLI::App* command = app.add_subcommand(
      "preflight", "which effects a planned experiment could show and tell apart, and what next");
  command->footer(
      "Simulates; a minute for a pendulum, some for a leap. Exit code 1 where data of the "
      "experiment could not be diagnosed.\n"
      "Example:\n  jaculus preflight problems/pendulum_trials.yaml --out out/preflight");

  command->add_option("experiment", options->experiment, "experiment (YAML), as for simulate")
      ->required();
  command->add_option("--trials", options->trials, "number of trials, instead of the experiment's")
      ->check(whole_number(1, 100000));
  command
      ->add_option("--size", options->size,
                   "of each effect at work, in its probing steps: a prior scale unless it states "
                   "another; default: 1")
      ->check(CLI::Range(1e-3, 1e3));

  command
      ->add_option("--effects", options->effect_files,
                   "file of an effect of your own, judged beside the others; may be given several "
                   "times")
      ->allow_extra_args(false);
  command->add_option(
      "--settings", options->settings,
      "YAML file of settings that replace defaults (diagnose --explain lists them)");
  command->add_flag("--planned-only", options->planned_only,
                    "without sensors and motions that would tell more");

  add_common(*command, options->common, "folder for preflight.json and report.html");
  add_figures(*command, options->common);
  command->callback([options, &chosen] { chosen = [options] { return run_preflight(*options); }; });
}

}  // namespace jaculus::cli
