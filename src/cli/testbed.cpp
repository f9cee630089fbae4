// jaculus testbed: datasets from an independent robot in MuJoCo.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"
#include "jaculus/testbed/effects.h"
#include "jaculus/testbed/trials.h"

namespace jaculus::cli {
namespace {

namespace fs = std::filesystem;

struct RunOptions {
  Common common;
  std::string experiment;
  std::string robot;
  std::string quantity = "torque";
  std::vector<std::string> effects;
  int trials = 6;
  bool exact = false;
};

void need_mujoco() {
  if (testbed::available()) return;
  throw InputError(
      "testbed: this build was made without MuJoCo; install libmujoco-dev (Debian, Ubuntu) and build again");
}

fs::path robot_folder(const RunOptions& options, const std::string& usual) {
  return find_robot(options.robot.empty() ? usual : options.robot, fs::current_path() / "robot");
}

/// A plan's file, or one of the experiments by name.
Dataset asked_for(const RunOptions& options) {
  const std::string& name = options.experiment;
  if (name == "self_righting") return testbed::self_righting(robot_folder(options, "minitaur_tail"));
  if (name == "tail_bench") return testbed::tail_bench(robot_folder(options, "minitaur_tail"));
  if (name == "pendulum") return testbed::pendulum(robot_folder(options, "pendulum"));
  if (!fs::is_regular_file(name)) {
    throw InputError(fmt::format(
        "testbed run: no file '{}'; allowed: a plan (CSV) for a leap, self_righting, tail_bench, pendulum", name));
  }
  const Table plan = read_csv(name);
  return testbed::leap(robot_folder(options, plan.column("tail") >= 0 ? "minitaur_tail" : "minitaur"), name,
                       options.quantity);
}

int run(const RunOptions& options) {
  need_mujoco();
  if (options.common.out.empty()) throw InputError("testbed run: --out is missing; allowed: a folder for the dataset");
  Dataset asked = asked_for(options);
  testbed::Changes changes;
  for (const std::string& effect : options.effects) testbed::apply_effect(effect, changes);
  testbed::TrialSpec spec;
  spec.trials = options.trials;
  spec.exact = options.exact;
  spec.seed = static_cast<std::uint64_t>(options.common.seed.value_or(1));
  prepare_folder(options.common.out);
  Dataset dataset = testbed::run_trials(asked, changes, spec);
  dataset.provenance =
      fmt::format("jaculus testbed (MuJoCo), {}, seed {}, effects: {}", options.experiment, spec.seed,
                  options.effects.empty() ? "none" : fmt::format("{}", fmt::join(options.effects, " ")));
  write_dataset(dataset, options.common.out);
  const std::string text = fmt::format("{} trials of {} on {} written to {}\n", dataset.trials.size(),
                                       dataset.experiment, dataset.robot, options.common.out);
  if (options.common.json) {
    nlohmann::ordered_json json = {{"experiment", dataset.experiment},
                                   {"robot", dataset.robot},
                                   {"trials", dataset.trials.size()},
                                   {"effects", options.effects},
                                   {"out", options.common.out}};
    print(json.dump(2) + "\n");
  } else if (!options.common.quiet) {
    print(text);
  }
  return kDone;
}

std::string effect_list() {
  std::string text = "Effects, with the parameter that is their strength:\n";
  for (const testbed::BenchEffect& effect : testbed::bench_effects()) {
    const testbed::BenchParameter& p = effect.parameters.front();
    text += fmt::format("  {:<26} {:<20} {:>8.4g} to {:<8.4g} {:<11} {}\n", effect.name, p.name, p.lower, p.upper,
                        p.unit, effect.caption);
  }
  return text;
}

void add_run(CLI::App& parent, Action& chosen) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = parent.add_subcommand("run", "Trials on the MuJoCo robot, written as a dataset.");
  command->footer(
      effect_list() +
      "Example:\n  jaculus testbed run plan.csv --effect tail_compliance:compliance=0.01 --trials 6 --seed 3 "
      "--out bent");
  command->add_option("experiment", options->experiment, "a plan (CSV), self_righting, tail_bench or pendulum")
      ->required();
  command->add_option("--robot", options->robot, "a folder of models/, or a path");
  command->add_option("--quantity", options->quantity, "what the leap's loop commands")
      ->check(one_of({"torque", "duty"}));
  command->add_option("--effect", options->effects, "name:parameter=value,...; may be given several times");
  command->add_option("--trials", options->trials, "how many")->check(whole_number(1, 1000));
  command->add_flag("--exact", options->exact, "no noise, scatter or rounding");
  add_common(*command, options->common, "folder for the dataset");
  command->callback([options, &chosen] { chosen = [options] { return run(*options); }; });
}

}  // namespace

void add_testbed(CLI::App& app, Action& chosen) {
  CLI::App* command =
      app.add_subcommand("testbed", "An independent robot in MuJoCo that stands in for hardware: run, seal, score.");
  command->require_subcommand(1);
  add_run(*command, chosen);
}

}  // namespace jaculus::cli
