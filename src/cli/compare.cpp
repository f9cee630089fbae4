// jaculus compare: several problems, solved and tabulated against each other.

#include <fmt/format.h>

#include <cstdio>
#include <fstream>
#include <memory>
#include <set>

#include "cli/plan.h"
#include "jaculus/core/error.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Options {
  Common common;
  std::vector<std::string> problems;
  bool resume = false;
};

std::vector<Loaded> load_all(const Options& options) {
  std::vector<Loaded> all;
  std::set<std::string> names;
  for (const std::string& file : options.problems) {
    all.push_back(load(file, options.common));
    const Problem& problem = all.back().problem;
    if (!names.insert(problem.name).second) {
      throw problem.node.at("name").error(
          fmt::format("'{}' names another of these problems already; allowed: unique names, since they name folders",
                      problem.name));
    }
  }
  return all;
}

/// An earlier run's summary of the same problem with the same seed, where it converged.
std::optional<Summary> finished(const fs::path& folder, const Problem& problem) {
  const fs::path file = folder / "summary.json";
  std::ifstream stream(file);
  if (!stream) return std::nullopt;
  const Json json = Json::parse(stream, nullptr, false);
  if (json.is_discarded()) return std::nullopt;  // not ours or damaged: solved again and replaced
  try {
    Summary summary = summary_from_json(json, file.string());
    if (summary.converged && summary.problem == describe_problem(problem)) return summary;
  } catch (const InputError&) {
    return std::nullopt;
  }
  return std::nullopt;
}

int run(const Options& options, const ProblemSolver& solver) {
  const Common& common = options.common;
  if (options.resume && common.out.empty()) {
    throw InputError("--resume: given without --out; allowed: with the --out of the run to go on with");
  }
  const std::vector<Loaded> all = load_all(options);
  if (!common.out.empty()) prepare_folder(common.out);
  std::vector<ComparisonRow> rows;
  bool converged = true;
  for (const Loaded& loaded : all) {
    const fs::path folder = fs::path(common.out) / loaded.problem.name;
    std::optional<Summary> summary;
    if (options.resume) summary = finished(folder, loaded.problem);
    if (!summary) {
      const SolvedProblem solved = solver(loaded, common, progress_line(common, loaded.problem.name));
      clear_progress(common);
      if (interrupt_requested()) {
        fmt::print(stderr, "jaculus: interrupted; {} of {} problems are solved{}\n", rows.size(), all.size(),
                   common.out.empty() ? "" : ", --resume goes on");
        return kNotSolved;
      }
      if (!common.out.empty()) {
        prepare_folder(folder);
        write_solved(folder, solved);
      }
      summary = solved.summary;
    }
    converged = converged && summary->converged;
    rows.push_back(comparison_row(loaded, *summary));
  }
  const std::string json = comparison_json(rows).dump(1) + "\n";
  if (!common.out.empty()) {
    write_file(fs::path(common.out) / "compare.csv", comparison_csv(rows));
    write_file(fs::path(common.out) / "compare.json", json);
  }
  if (common.json) {
    print(json);
  } else if (!common.quiet) {
    print(comparison_text(rows, colours()));
    if (!common.out.empty()) print(fmt::format("written to {}\n", common.out));
  }
  return converged ? kDone : kNotSolved;
}

}  // namespace

void add_compare(CLI::App& app, Action& chosen, const ProblemSolver& solver) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("compare", "Solves several problems and tabulates them against the first.");
  command->footer(
      "Writes compare.json, compare.csv and a folder for each problem into --out; exit code 1 where one did not "
      "converge.\n"
      "Example:\n  jaculus compare problems/leap_tailless.yaml problems/leap_inactive.yaml problems/leap_inertial.yaml "
      "\\\n"
      "                  problems/leap_tail.yaml --out leaps");
  command->add_option("problems", options->problems, "problem files, the one without tail first")->required();
  add_common(*command, options->common, "folder for the results; nothing is written unless given");
  command->add_flag("--resume", options->resume, "keep what an interrupted run has finished in --out");
  command->callback([options, solver, &chosen] { chosen = [options, solver] { return run(*options, solver); }; });
}

}  // namespace jaculus::cli
