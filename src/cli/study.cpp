// jaculus study: grids of computed figures beside a source's.

#include "jaculus/studies/study.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <set>

#include "cli/reporting.h"
#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/report/study_report.h"

namespace jaculus::cli {
namespace {

struct StudyOptions {
  Common common;
  std::vector<std::string> files;
  bool resume = false;
};

/// Where a study goes: --out itself, or where there are several a folder of its own in it.
std::string folder_of(const StudyOptions& options, const std::string& file) {
  const std::string& out = options.common.out;
  if (out.empty() || options.files.size() == 1) return out;
  return (std::filesystem::path(out) / std::filesystem::path(file).stem()).string();
}

studies::StudyOptions study_options(const StudyOptions& options, const std::string& file) {
  const std::string name = std::filesystem::path(file).stem().string();
  studies::StudyOptions study;
  study.jobs = options.common.jobs;
  study.resume = options.resume;
  if (!options.common.quiet) {
    study.notice = [](const std::string& message) { fmt::print(stderr, "jaculus: {}\n", message); };
  }
  study.executor = make_executor(options.common, jobs_folder(folder_of(options, file)));
  study.stage = "study_" + name;
  study.progress = progress_bar(options.common, options.files.size() > 1 ? name : "");
  return study;
}

void check(const StudyOptions& options) {
  if (options.resume && options.common.out.empty()) {
    throw InputError(
        "--resume: given without --out; allowed: with the --out of the run to go on with");
  }

  if (options.common.seed)
    throw InputError("--seed: given; allowed: nothing, since a study has nothing random in it");
  check_figures(options.common);
  std::set<std::string> stems;
  for (const std::string& file : options.files) {
    static_cast<void>(studies::check_study(file));
    const std::string stem = std::filesystem::path(file).stem().string();
    if (!stems.insert(stem).second) {
      throw InputError(
          fmt::format("{}: another study of this name is given already; allowed: unique file "
                      "names, since they name folders",
                      file));
    }
  }
}

void show(const std::vector<studies::StudyResult>& results, const Common& common) {
  if (common.json) {
    if (results.size() == 1) return print(studies::study_json(results[0]));
    studies::StudyJson list = studies::StudyJson::array();
    for (const studies::StudyResult& result : results)
      list.push_back(studies::StudyJson::parse(studies::study_json(result)));
    return print(list.dump(1) + "\n");
  }
  if (common.quiet) return;
  for (std::size_t i = 0; i < results.size(); ++i)
    print((i > 0 ? "\n" : "") + report::study_text(results[i]));
}

int run_study(StudyOptions options) {
  for (std::string& file : options.files) file = find_problem_file(file).string();
  const Common& common = options.common;
  check(options);
  if (!common.out.empty()) prepare_folder(common.out);
  std::vector<studies::StudyResult> results;
  bool complete = true;
  for (const std::string& file : options.files) {
    const std::string folder = folder_of(options, file);
    if (!folder.empty()) prepare_folder(folder);
    const studies::StudyOptions study = study_options(options, file);
    const bool of_another = !worker_stage().empty() && worker_stage() != study.stage;
    if (study.executor && of_another) continue;
    results.push_back(studies::run_study(file, folder, study));
    clear_progress(common);
    complete = complete && results.back().complete;
    if (interrupt_requested()) break;
  }

  show(results, common);
  if (interrupt_requested()) {
    fmt::print(stderr, "jaculus: interrupted{}\n",
               common.out.empty() ? "" : "; what is finished is kept, --resume goes on");
    return kNotSolved;
  }

  if (complete && !common.out.empty() && !common.quiet && !common.json)
    print(fmt::format("written to {}\n", common.out));
  if (complete) write_reporting(report::study_report(results), common);
  return complete ? kDone : kNotSolved;
}

}  // namespace

void add_study(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<StudyOptions>();
  CLI::App* command = app.add_subcommand(
      "study", "Reorientation, tail design and drag bench over grids of parameters.");
  command->footer(
      "Writes study.csv, study.json and report.html into --out; exit code 1 where points are "
      "missing.\n"
      "Example: figures 3 to 6 of the paper\n  jaculus study problems/fig3_effectiveness.yaml "
      "problems/fig4_shaft.yaml "
      "problems/drag_bench.yaml \\\n                problems/fig6_drop.yaml --out figures "
      "--figures png,svg");

  command
      ->add_option("study", options->files, "study files; several get a folder each and one report")
      ->required();
  add_common(*command, options->common, "folder for the results; nothing is written unless given");
  add_figures(*command, options->common);
  add_executor(*command, options->common);
  command->add_flag("--resume", options->resume,
                    "go on with what an interrupted run has finished in --out");
  command->callback([options, &chosen] { chosen = [options] { return run_study(*options); }; });
}

}  // namespace jaculus::cli
