// jaculus testbed seal: blinded cases.

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "cli/reporting.h"
#include "cli/testbed.h"
#include "jaculus/core/error.h"
#include "jaculus/testbed/blinded_cases.h"

namespace jaculus::cli {
namespace {

namespace fs = std::filesystem;

struct SealOptions {
  Common common;
  int singles = 0, none = 0, pairs = 0, outside = 0, mixed = 0;
  int several = 0, events = 0, groups = 0;
  bool clutter = false, resume = false;
  std::vector<std::string> withheld;
  std::string commit, key;
  std::vector<std::string> plans;
  std::vector<std::string> robots = {kRobotWithTail, kRobotWithoutTail};
};

void check_seal(const SealOptions& options) {
  if (options.common.out.empty())
    throw InputError("testbed seal: --out is missing; allowed: a new folder for the cases");
  if (!options.commit.empty() && options.common.seed)
    throw InputError("testbed seal: --seed and --commit given; allowed: one");
  for (const int count : {options.singles, options.none, options.pairs, options.outside,
                          options.mixed, options.several, options.events, options.groups})
    if (count > 0) return;
  throw InputError(
      "testbed seal: no case asked for; allowed: --singles, --none, --several, --pairs, --outside, "
      "--mixed, --events, --groups");
}

testbed::BlindingSpec blinding_spec(const SealOptions& options) {
  const Common& common = options.common;
  testbed::BlindingSpec spec;

  spec.singles = options.singles;
  spec.none = options.none;
  spec.pairs = options.pairs;
  spec.outside = options.outside;
  spec.mixed = options.mixed;
  spec.several = options.several;
  spec.events = options.events;
  spec.groups = options.groups;

  spec.clutter = options.clutter;
  spec.resume = options.resume;
  spec.withheld = options.withheld;

  spec.seed = options.commit.empty() ? static_cast<std::uint64_t>(common.seed.value_or(1))
                                     : testbed::seed_of_commit(options.commit);
  spec.provenance =
      options.commit.empty() ? fmt::format("seed {}", spec.seed) : "commit " + options.commit;

  spec.plans.assign(options.plans.begin(), options.plans.end());
  for (const std::string& robot : options.robots)
    spec.robots.push_back(model::find_robot(robot, fs::current_path() / "robot"));

  spec.out = common.out;
  spec.key = options.key.empty()
                 ? fs::path(fs::path(common.out).lexically_normal().string() + ".key")
                 : fs::path(options.key);
  spec.jobs = common.jobs;
  spec.progress = progress_bar(common, "cases");
  spec.notice = notices(common);
  spec.executor = make_executor(common, spec.key.string() + ".jobs");
  return spec;
}

int seal(const SealOptions& options) {
  need_mujoco();
  check_seal(options);
  const Common& common = options.common;
  const testbed::BlindingSpec spec = blinding_spec(options);
  const std::vector<std::string> ids = testbed::blind_cases(spec);
  clear_progress(common);

  if (common.json) {
    const nlohmann::ordered_json json = {
        {"cases", ids}, {"out", common.out}, {"key", spec.key.string()}};
    print(json.dump(2) + "\n");
  } else if (!common.quiet) {
    print(fmt::format("{} blinded cases in {}; key and salt in {}\n", ids.size(), common.out,
                      spec.key.string()));
  }

  return kDone;
}

void add_counts(CLI::App& command, SealOptions& options) {
  const auto add = [&](const std::string& name, int& count, const std::string& meaning) {
    command.add_option(name, count, meaning)->check(whole_number(0, 100000));
  };
  add("--singles", options.singles, "cases with one effect");
  add("--none", options.none, "cases without");
  add("--several", options.several, "cases with two or three, on different parts");
  add("--pairs", options.pairs, "cases with two");
  add("--outside", options.outside, "cases with a disturbance that no catalogue has");
  add("--mixed", options.mixed, "cases with one effect and such a disturbance beside");
  add("--events", options.events, "cases with a push once a trial, at a joint or on the body");
  add("--groups", options.groups, "cases with one effect in two or three datasets of one robot");
}

}  // namespace

void add_seal(CLI::App& parent, Action& chosen) {
  auto options = std::make_shared<SealOptions>();
  CLI::App* command =
      parent.add_subcommand("seal", "Blinded cases: datasets whose labels are encrypted.");
  command->footer(
      "Example:\n  jaculus testbed seal --singles 120 --none 60 --several 30 --outside 30 --plan "
      "a.csv --plan b.csv "
      "--commit $(git rev-parse HEAD) --out blinded");
  add_counts(*command, *options);
  command->add_flag("--clutter", options->clutter,
                    "robots off their files by their tolerances, noise of every kind");
  command->add_option("--withhold", options->withheld,
                      "disturbances and pushes that are not drawn");
  command->add_option("--plan", options->plans,
                      "a plan (CSV) to leap by; may be given several times");
  command->add_option("--robot", options->robots,
                      "a folder of models/, or a path; may be given several times; each plays the "
                      "plans for its motors, a drop and a bench with its tail or legs, and swings "
                      "where its base is fixed");
  command->add_option("--commit", options->commit,
                      "hash of the commit to be judged: the seed derives from it");
  command->add_option("--key", options->key, "file for key and salt; OUT.key unless given");
  command->add_flag("--resume", options->resume,
                    "go on with what an interrupted run has finished (KEY.journal)");
  add_common(*command, options->common, "a new folder for the cases");
  add_executor(*command, options->common);
  command->callback([options, &chosen] { chosen = [options] { return seal(*options); }; });
}

}  // namespace jaculus::cli
