// jaculus testbed: datasets from an independent robot in MuJoCo.

#include "cli/testbed.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/reporting.h"
#include "jaculus/core/error.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/core/yaml.h"
#include "jaculus/evaluation/score.h"
#include "jaculus/report/score_report.h"
#include "jaculus/simulation/experiment.h"
#include "jaculus/testbed/blinded_cases.h"
#include "jaculus/testbed/effects.h"
#include "jaculus/testbed/robot_notes.h"
#include "jaculus/testbed/trials.h"

namespace jaculus::cli {

void need_mujoco() {
  if (testbed::available()) return;
  throw InputError(
      "testbed: this build was made without MuJoCo; install libmujoco-dev (Debian, Ubuntu) and "
      "build again");
}

namespace {

namespace fs = std::filesystem;

using trajectory::ExperimentKind;

struct RunOptions {
  Common common;
  std::string experiment;
  std::string robot;
  std::string quantity = name_of(trajectory::Quantity::torque);
  std::string input = testbed::swing_inputs().name(testbed::SwingInput::torque);
  std::vector<std::string> effects;
  int trials = 6;
  bool exact = false;
  std::optional<std::int64_t> clutter;  ///< seed
};

// Experiments that no dataset has a kind for.
constexpr const char* kSwing = "swing";
constexpr const char* kLegDrop = "leg_drop";
constexpr const char* kLegBench = "leg_bench";

fs::path robot_folder(const RunOptions& options, const std::string& usual) {
  return model::find_robot(options.robot.empty() ? usual : options.robot,
                           fs::current_path() / "robot");
}

/// A plan's file, or one of the experiments by name.
trajectory::Dataset asked_for(const RunOptions& options) {
  const std::string& name = options.experiment;
  const auto kind = trajectory::experiment_kinds().find(name);
  if (kind == ExperimentKind::self_righting)
    return testbed::self_righting(robot_folder(options, kRobotWithTail));
  if (kind == ExperimentKind::tail_bench)
    return testbed::tail_bench(robot_folder(options, kRobotWithTail));
  if (kind == ExperimentKind::pendulum) return testbed::pendulum(robot_folder(options, "pendulum"));
  if (name == kSwing)
    return testbed::swing(robot_folder(options, "double_pendulum"),
                          *testbed::swing_inputs().find(options.input));
  if (name == kLegDrop) return testbed::leg_drop(robot_folder(options, "quadruped25"));
  if (name == kLegBench) return testbed::leg_bench(robot_folder(options, "quadruped25"));

  if (fs::path(name).extension() == ".yaml") {
    trajectory::Dataset asked = simulation::read_experiment(name).setup;
    if (!asked.overrides.empty()) {
      throw InputError(fmt::format("{}: override: given; allowed on the testbed: --effect", name));
    }
    if (asked.controller.after_end == trajectory::AfterEnd::pose)
      throw InputError(fmt::format(
          "{}: controller: after_end: a pose given; allowed on the testbed: hold, relax, repeat",
          name));
    return asked;
  }

  if (!fs::is_regular_file(name)) {
    throw InputError(
        fmt::format("testbed run: no file '{}'; allowed: a plan (CSV) for a leap, an experiment "
                    "(YAML), self_righting, "
                    "tail_bench, pendulum, {}, {}, {}",
                    name, kSwing, kLegDrop, kLegBench));
  }

  const trajectory::Table plan = trajectory::read_csv(name);
  return testbed::leap(
      robot_folder(options, plan.column("tail") >= 0 ? kRobotWithTail : kRobotWithoutTail), name,
      *trajectory::quantity_names().find(options.quantity));
}

int run(const RunOptions& options) {
  need_mujoco();
  if (options.common.out.empty())
    throw InputError("testbed run: --out is missing; allowed: a folder for the dataset");

  trajectory::Dataset asked = asked_for(options);
  testbed::Changes changes;
  if (!options.effects.empty()) {
    const auto known = testbed::bench_effects(model::find_robot(asked.robot, asked.folder));
    for (const std::string& effect : options.effects) testbed::apply_effect(effect, known, changes);
  }
  testbed::TrialSpec spec;
  spec.trials = options.trials;
  spec.exact = options.exact;
  if (options.clutter) spec.clutter_seed = *options.clutter;
  spec.seed = options.common.seed.value_or(1);
  // What drove the robot is in its log, and nowhere else.
  spec.sensors.torque = asked.controller.kind == trajectory::ControllerKind::measured;
  prepare_folder(options.common.out);
  trajectory::Dataset dataset = testbed::run_trials(asked, changes, spec);
  dataset.provenance = fmt::format(
      "jaculus testbed (MuJoCo), {}, seed {}{}, effects: {}", options.experiment, spec.seed,
      options.clutter ? fmt::format(", clutter {}", *options.clutter) : "",
      options.effects.empty() ? "none" : fmt::format("{}", fmt::join(options.effects, " ")));
  trajectory::write_dataset(dataset, options.common.out);
  const std::vector<std::string> notes =
      testbed::notes_on_robot(model::find_robot(asked.robot, asked.folder));
  const std::string text =
      fmt::format("{} trials of {} on {} written to {}\n", dataset.trials.size(),
                  name_of(dataset.experiment), dataset.robot, options.common.out);

  if (options.common.json) {
    nlohmann::ordered_json json = {{"experiment", name_of(dataset.experiment)},
                                   {"robot", dataset.robot},
                                   {"trials", dataset.trials.size()},
                                   {"effects", options.effects},
                                   {"notes", notes},
                                   {"out", options.common.out}};
    print(json.dump(2) + "\n");
  } else if (!options.common.quiet) {
    for (const std::string& note : notes) print("  " + note + "\n");
    print(text);
  }

  return kDone;
}

/// Of a robot with all that effects act on.
std::string effect_list() {
  const fs::path robot = model::find_robot(kRobotWithTail, fs::current_path() / "robot");
  std::string text = fmt::format(
      "Effects, with the parameter that is their strength, for {} (ranges follow from "
      "the robot's motors, masses and lengths):\n",
      kRobotWithTail);
  for (const testbed::BenchEffect& effect : testbed::bench_effects(robot)) {
    const testbed::BenchParameter& p = effect.parameters.front();
    text += fmt::format("  {:<26} {:<20} {:>8.4g} to {:<8.4g} {:<11} {}\n", effect.name, p.name,
                        p.lower, p.upper, p.unit, effect.caption);
  }
  return text;
}

void add_run(CLI::App& parent, Action& chosen) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command =
      parent.add_subcommand("run", "Trials on the MuJoCo robot, written as a dataset.");
  command->footer([] {
    return effect_list() +
           "Example:\n  jaculus testbed run plan.csv --effect tail_compliance:compliance=0.01 "
           "--trials 6 --seed 3 --out bent";
  });
  command
      ->add_option("experiment", options->experiment,
                   "a plan (CSV), an experiment (YAML), self_righting, tail_bench, pendulum, swing "
                   "(smooth, of a robot on a fixed base), leg_drop or leg_bench (without a tail)")
      ->required();

  command->add_option("--robot", options->robot, "a folder of models/, or a path");
  command->add_option("--quantity", options->quantity, "what the leap's loop commands")
      ->check(one_of(trajectory::quantity_names()
                         .only({trajectory::Quantity::torque, trajectory::Quantity::duty})
                         .names()));
  command->add_option("--input", options->input, "what drives a swing")
      ->check(one_of(testbed::swing_inputs().names()));
  command->add_option("--effect", options->effects,
                      "name:parameter=value,...; may be given several times");
  command->add_option("--trials", options->trials, "how many")->check(whole_number(1, 1000));
  command->add_flag("--exact", options->exact, "no noise, scatter or rounding");
  command
      ->add_option("--clutter", options->clutter,
                   "the robot is off its files by a draw from its tolerances: the draw's seed")
      ->check(whole_number(0, 2147483647));
  add_common(*command, options->common, "folder for the dataset");
  command->callback([options, &chosen] { chosen = [options] { return run(*options); }; });
}

struct ScoreFlags {
  Common common;
  std::string folder, key, answers;
  bool resume = false, no_baselines = false;
  int limit = 0;  ///< 0: all
};

evaluation::CaseTruth truth_of(const testbed::CaseLabel& label) {
  evaluation::CaseTruth truth;
  truth.case_id = label.case_id;
  truth.kind = label.kind;
  truth.effects = label.effects;
  truth.parameters = label.parameters;
  truth.strength_in_noise_floors = label.strength_in_noise_floors;
  truth.beside = label.beside;
  truth.strengths = label.strengths;
  truth.legs_apart = label.legs_apart;
  truth.diverged = label.diverged;
  truth.equivalent = label.equivalent;
  truth.component = label.component;
  truth.events = label.events;
  truth.trials = label.trials;
  return truth;
}

int score(const ScoreFlags& flags) {
  const Common& common = flags.common;
  check_figures(common);
  if (common.out.empty())
    throw InputError("testbed score: --out is missing; allowed: a folder for answers and score");

  const fs::path key = flags.key.empty()
                           ? fs::path(fs::path(flags.folder).lexically_normal().string() + ".key")
                           : fs::path(flags.key);
  const std::vector<std::string> ids = testbed::blinded_ids(flags.folder);
  std::string provenance;

  // a wrong key shows before hours of diagnosis
  (void)testbed::open_labels(flags.folder, key, &provenance);
  evaluation::ScoreOptions options;
  options.binary = fs::read_symlink("/proc/self/exe");
  options.out = common.out;
  options.seed = common.seed.value_or(1);
  options.jobs = common.jobs;
  options.resume = flags.resume;
  options.baselines = !flags.no_baselines;
  options.answers = flags.answers;
  options.provenance = provenance;
  if (flags.limit > 0) options.limit = flags.limit;
  options.progress = progress_bar(common, "cases");
  options.notice = notices(common);
  options.executor = make_executor(common, jobs_folder(common.out));
  prepare_folder(common.out);
  const auto open = [&] {
    std::vector<evaluation::CaseTruth> truths;
    for (const testbed::CaseLabel& label : testbed::open_labels(flags.folder, key))
      truths.push_back(truth_of(label));
    return truths;
  };

  evaluation::Score result = evaluation::score_cases(flags.folder, ids, open, options);
  clear_progress(common);
  if (result.truths.empty()) {
    fmt::print(stderr, "jaculus: interrupted; what is finished is kept, --resume goes on\n");
    return kNotSolved;
  }

  print(common.json    ? evaluation::score_json(result)
        : common.quiet ? ""
                       : evaluation::score_text(result));
  write_reporting(report::score_report(result), common);
  return kDone;
}

void add_score(CLI::App& parent, Action& chosen) {
  auto options = std::make_shared<ScoreFlags>();
  CLI::App* command = parent.add_subcommand(
      "score", "Diagnoses blinded cases, then opens their labels and compares.");
  command->footer("Example:\n  jaculus testbed score blinded --out score");
  command->add_option("folder", options->folder, "a folder of `testbed seal`")->required();
  command->add_option("--key", options->key, "file of key and salt; FOLDER.key unless given");
  command->add_flag("--resume", options->resume,
                    "go on with what an interrupted run has finished in --out");
  command
      ->add_option("--answers", options->answers,
                   "score the answers that an earlier run kept (its OUT/answers), diagnose nothing")
      ->check(CLI::ExistingDirectory);
  command->add_flag("--no-baselines", options->no_baselines, "leave the baselines out");
  command
      ->add_option("--limit", options->limit,
                   "only the first so many cases, in the order of their random names; what is "
                   "printed says of how many, and --resume goes on to more")
      ->check(whole_number(1, 100000));
  add_common(*command, options->common,
             "folder for answers, score.json, score.txt and report.html");
  add_figures(*command, options->common);
  add_executor(*command, options->common);
  command->callback([options, &chosen] { chosen = [options] { return score(*options); }; });
}

}  // namespace

void add_testbed(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand(
      "testbed", "An independent robot in MuJoCo that stands in for hardware: run, seal, score.");
  command->require_subcommand(1);
  add_run(*command, chosen);
  add_seal(*command, chosen);
  add_score(*command, chosen);
}

}  // namespace jaculus::cli
