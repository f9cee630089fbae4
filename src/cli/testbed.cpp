// jaculus testbed: datasets from an independent robot in MuJoCo.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "cli/reporting.h"
#include "jaculus/core/error.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/core/yaml.h"
#include "jaculus/evaluation/score.h"
#include "jaculus/report/score_report.h"
#include "jaculus/simulation/experiment.h"
#include "jaculus/testbed/effects.h"
#include "jaculus/testbed/sealed_cases.h"
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
  if (fs::path(name).extension() == ".yaml") {
    Dataset asked = read_experiment(name).setup;
    if (!asked.overrides.empty()) {
      throw InputError(fmt::format("{}: override: given; allowed on the testbed: --effect", name));
    }
    if (asked.controller.after_end == "pose")
      throw InputError(
          fmt::format("{}: controller: after_end: a pose given; allowed on the testbed: hold, relax, repeat", name));
    return asked;
  }
  if (!fs::is_regular_file(name)) {
    throw InputError(
        fmt::format("testbed run: no file '{}'; allowed: a plan (CSV) for a leap, an experiment (YAML), self_righting, "
                    "tail_bench, pendulum",
                    name));
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
  command
      ->add_option("experiment", options->experiment,
                   "a plan (CSV), an experiment (YAML), self_righting, tail_bench or pendulum")
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

struct SealOptions {
  Common common;
  int singles = 0, none = 0, pairs = 0, outside = 0;
  std::string commit, key;
  std::vector<std::string> plans;
};

int seal(const SealOptions& options) {
  need_mujoco();
  const Common& common = options.common;
  if (common.out.empty()) throw InputError("testbed seal: --out is missing; allowed: a new folder for the cases");
  if (!options.commit.empty() && common.seed) throw InputError("testbed seal: --seed and --commit given; allowed: one");
  if (options.singles + options.none + options.pairs + options.outside == 0) {
    throw InputError("testbed seal: no case asked for; allowed: --singles, --none, --pairs, --outside");
  }
  testbed::SealSpec spec;
  spec.singles = options.singles;
  spec.none = options.none;
  spec.pairs = options.pairs;
  spec.outside = options.outside;
  spec.seed = options.commit.empty() ? static_cast<std::uint64_t>(common.seed.value_or(1))
                                     : testbed::seed_of_commit(options.commit);
  spec.provenance = options.commit.empty() ? fmt::format("seed {}", spec.seed) : "commit " + options.commit;
  spec.plans.assign(options.plans.begin(), options.plans.end());
  spec.out = common.out;
  spec.key =
      options.key.empty() ? fs::path(fs::path(common.out).lexically_normal().string() + ".key") : fs::path(options.key);
  spec.jobs = common.jobs;
  spec.progress = progress_bar(common, "cases");
  const std::vector<std::string> ids = testbed::seal_cases(spec);
  clear_progress(common);
  if (common.json) {
    const nlohmann::ordered_json json = {{"cases", ids}, {"out", common.out}, {"key", spec.key.string()}};
    print(json.dump(2) + "\n");
  } else if (!common.quiet) {
    print(fmt::format("{} cases sealed in {}; key and salt in {}\n", ids.size(), common.out, spec.key.string()));
  }
  return kDone;
}

void add_seal(CLI::App& parent, Action& chosen) {
  auto options = std::make_shared<SealOptions>();
  CLI::App* command = parent.add_subcommand("seal", "Cases whose effect only the sealer knows.");
  command->footer(
      "Example:\n  jaculus testbed seal --singles 120 --none 60 --pairs 30 --outside 30 --plan a.csv --plan b.csv "
      "--commit $(git rev-parse HEAD) --out sealed");
  command->add_option("--singles", options->singles, "cases with one effect")->check(whole_number(0, 100000));
  command->add_option("--none", options->none, "cases without")->check(whole_number(0, 100000));
  command->add_option("--pairs", options->pairs, "cases with two")->check(whole_number(0, 100000));
  command->add_option("--outside", options->outside, "cases with a disturbance that no catalogue has")
      ->check(whole_number(0, 100000));
  command->add_option("--plan", options->plans, "a plan (CSV) to leap by; may be given several times");
  command->add_option("--commit", options->commit, "hash of the commit to be judged: the seed derives from it");
  command->add_option("--key", options->key, "file for key and salt; OUT.key unless given");
  add_common(*command, options->common, "a new folder for the cases");
  command->callback([options, &chosen] { chosen = [options] { return seal(*options); }; });
}

struct ScoreFlags {
  Common common;
  std::string folder, key;
  bool resume = false, no_baselines = false;
};

SealedTruth truth_of(const testbed::CaseLabel& label) {
  SealedTruth truth;
  truth.case_id = label.case_id;
  truth.kind = label.kind;
  truth.effects = label.effects;
  truth.parameters = label.parameters;
  truth.strength_in_noise_floors = label.strength_in_noise_floors;
  truth.parted = label.parted;
  truth.equivalent = label.equivalent;
  truth.component = label.component;
  return truth;
}

int score(const ScoreFlags& flags) {
  const Common& common = flags.common;
  check_figures(common);
  if (common.out.empty()) throw InputError("testbed score: --out is missing; allowed: a folder for answers and score");
  const fs::path key =
      flags.key.empty() ? fs::path(fs::path(flags.folder).lexically_normal().string() + ".key") : fs::path(flags.key);
  const std::vector<std::string> ids = testbed::sealed_ids(flags.folder);
  std::string provenance;
  (void)testbed::open_labels(flags.folder, key, &provenance);  // a wrong key shows before hours of diagnosis
  ScoreOptions options;
  options.binary = fs::read_symlink("/proc/self/exe");
  options.out = common.out;
  options.seed = static_cast<std::uint64_t>(common.seed.value_or(1));
  options.jobs = common.jobs;
  options.resume = flags.resume;
  options.baselines = !flags.no_baselines;
  options.progress = progress_bar(common, "cases");
  if (!common.quiet) options.notice = [](const std::string& text) { fmt::print(stderr, "jaculus: {}\n", text); };
  prepare_folder(common.out);
  const auto open = [&] {
    std::vector<SealedTruth> truths;
    for (const testbed::CaseLabel& label : testbed::open_labels(flags.folder, key)) truths.push_back(truth_of(label));
    return truths;
  };
  Score result = score_cases(flags.folder, ids, open, options);
  clear_progress(common);
  if (result.truths.empty()) {
    fmt::print(stderr, "jaculus: interrupted; what is finished is kept, --resume goes on\n");
    return kNotSolved;
  }
  result.provenance = provenance;
  print(common.json ? score_json(result) : common.quiet ? "" : score_text(result));
  write_reporting(score_report(result), common);
  return kDone;
}

void add_score(CLI::App& parent, Action& chosen) {
  auto options = std::make_shared<ScoreFlags>();
  CLI::App* command = parent.add_subcommand("score", "Diagnoses sealed cases, then opens their labels and compares.");
  command->footer("Example:\n  jaculus testbed score sealed --out score");
  command->add_option("folder", options->folder, "a folder of `testbed seal`")->required();
  command->add_option("--key", options->key, "file of key and salt; FOLDER.key unless given");
  command->add_flag("--resume", options->resume, "go on with what an interrupted run has finished in --out");
  command->add_flag("--no-baselines", options->no_baselines, "leave the baselines out");
  add_common(*command, options->common, "folder for answers, score.json, score.txt and report.html");
  add_figures(*command, options->common);
  command->callback([options, &chosen] { chosen = [options] { return score(*options); }; });
}

}  // namespace

void add_testbed(CLI::App& app, Action& chosen) {
  CLI::App* command =
      app.add_subcommand("testbed", "An independent robot in MuJoCo that stands in for hardware: run, seal, score.");
  command->require_subcommand(1);
  add_run(*command, chosen);
  add_seal(*command, chosen);
  add_score(*command, chosen);
}

}  // namespace jaculus::cli
