// evaluate: what is known of real datasets beside what a diagnosis says.

#include <fmt/format.h>

#include "cli/command.h"
#include "jaculus/core/error.h"
#include "jaculus/evaluation/real.h"

namespace jaculus::cli {
namespace {

struct EvaluateOptions {
  std::vector<std::string> folders;
  Common common;
};

int run_evaluate(const EvaluateOptions& options) {
  const Common& common = options.common;
  if (common.out.empty())
    throw InputError(
        "evaluate real: --out is missing; allowed: a folder for answers and real.json");

  evaluation::RealOptions real;
  real.binary = std::filesystem::read_symlink("/proc/self/exe");
  real.out = common.out;
  if (!common.quiet && !common.json)
    real.notice = [](const std::string& name) { fmt::print(stderr, "diagnosing {}\n", name); };

  prepare_folder(common.out);

  const auto scores =
      evaluation::score_real_datasets({options.folders.begin(), options.folders.end()}, real);
  print(common.json    ? evaluation::real_json(scores)
        : common.quiet ? ""
                       : evaluation::real_text(scores));
  return kDone;
}

}  // namespace

void add_evaluate(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<EvaluateOptions>();
  CLI::App* group =
      app.add_subcommand("evaluate", "What is known of datasets beside what a diagnosis says.");
  group->require_subcommand(1);
  CLI::App* command = group->add_subcommand(
      "real", "Diagnoses datasets with a NAME.truth.yaml beside them and tabulates both.");
  command->footer("Example:\n  jaculus evaluate real data/emps data/pendulum/ak80 --out real");
  command->add_option("folders", options->folders, "datasets")->required()->type_name("DIR...");
  add_common(*command, options->common, "folder for answers, real.json and real.txt");
  command->callback([options, &chosen] { chosen = [options] { return run_evaluate(*options); }; });
}

}  // namespace jaculus::cli
