// jaculus study: grids of computed figures beside a source's.

#include "jaculus/studies/study.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <set>

#include "cli/reporting.h"
#include "jaculus/core/error.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/report/study_report.h"
#include "report/document/text_table.h"

namespace jaculus::cli {
namespace {

constexpr std::size_t kMostRowsShown = 12;
constexpr std::size_t kMostColumnsShown = 8;

struct StudyOptions {
  Common common;
  std::vector<std::string> files;
  bool resume = false;
};

std::string shown(const studies::StudyJson& value) {
  if (value.is_null()) return "-";
  if (value.is_number()) return fmt::format("{:.5g}", value.get<double>());
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::string differs(const studies::StudyReference& r) {
  if (std::isnan(r.deviation)) return "";
  return fmt::format("{:+.1f} %{}", 100.0 * r.deviation, r.disagrees ? " (!)" : "");
}

std::string rows_text(const studies::StudyResult& result) {
  const std::size_t columns = std::min(result.columns.size(), kMostColumnsShown);
  report::TextTable table({result.columns.begin(), result.columns.begin() + columns});
  const std::size_t rows = std::min(result.rows.size(), kMostRowsShown);
  for (std::size_t i = 0; i < rows; ++i) {
    std::vector<std::string> cells;
    for (std::size_t j = 0; j < columns; ++j)
      cells.push_back(shown(result.rows[i].at(result.columns[j])));
    table.row(cells);
  }
  std::string text = table.text();
  if (rows < result.rows.size() || columns < result.columns.size()) {
    text += fmt::format("({} of {} rows and {} of {} columns; study.csv has them all)\n", rows,
                        result.rows.size(), columns, result.columns.size());
  }
  return text;
}

std::string text_of(const studies::StudyResult& result) {
  std::string text = fmt::format("{}: {}\n\n{}", result.name, result.caption, rows_text(result));
  if (!result.references.empty()) {
    report::TextTable table({"quantity", "paper", "computed", "differs by", "note"});
    for (const studies::StudyReference& r : result.references)
      table.row({r.quantity, shown(r.paper), shown(r.computed), differs(r), r.note});
    text += "\n" + table.text();
  }
  for (const std::string& note : result.notes) text += "note: " + note + "\n";
  return text;
}

studies::StudyOptions study_options(const StudyOptions& options, const std::string& name) {
  studies::StudyOptions study;
  study.jobs = options.common.jobs;
  study.resume = options.resume;
  if (!options.common.quiet) {
    study.notice = [](const std::string& message) { fmt::print(stderr, "jaculus: {}\n", message); };
  }
  study.progress = progress_bar(options.common, options.files.size() > 1 ? name : "");
  return study;
}

/// Where a study goes: --out itself, or where there are several a folder of its own in it.
std::string folder_of(const StudyOptions& options, const std::string& file) {
  const std::string& out = options.common.out;
  if (out.empty() || options.files.size() == 1) return out;
  return (std::filesystem::path(out) / std::filesystem::path(file).stem()).string();
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
  for (std::size_t i = 0; i < results.size(); ++i) print((i > 0 ? "\n" : "") + text_of(results[i]));
}

int run_study(const StudyOptions& options) {
  const Common& common = options.common;
  check(options);
  if (!common.out.empty()) prepare_folder(common.out);
  std::vector<studies::StudyResult> results;
  bool complete = true;
  for (const std::string& file : options.files) {
    const std::string folder = folder_of(options, file);
    if (!folder.empty()) prepare_folder(folder);
    results.push_back(studies::run_study(
        file, folder, study_options(options, std::filesystem::path(file).stem().string())));
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
  command->add_flag("--resume", options->resume,
                    "go on with what an interrupted run has finished in --out");
  command->callback([options, &chosen] { chosen = [options] { return run_study(*options); }; });
}

}  // namespace jaculus::cli
