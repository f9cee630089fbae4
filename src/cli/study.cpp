// jaculus study: grids of computed figures beside a source's.

#include "jaculus/studies/study.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "cli/command.h"
#include "jaculus/core/error.h"
#include "jaculus/core/interrupt.h"
#include "jaculus/report/text_table.h"

namespace jaculus::cli {
namespace {

constexpr std::size_t kMostRowsShown = 12;
constexpr std::size_t kMostColumnsShown = 8;

struct Options {
  Common common;
  std::string file;
  bool resume = false;
};

std::string shown(const StudyJson& value) {
  if (value.is_null()) return "-";
  if (value.is_number()) return fmt::format("{:.5g}", value.get<double>());
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::string rows_text(const StudyResult& result) {
  const std::size_t columns = std::min(result.columns.size(), kMostColumnsShown);
  TextTable table({result.columns.begin(), result.columns.begin() + static_cast<std::ptrdiff_t>(columns)});
  const std::size_t rows = std::min(result.rows.size(), kMostRowsShown);
  for (std::size_t i = 0; i < rows; ++i) {
    std::vector<std::string> cells;
    for (std::size_t j = 0; j < columns; ++j) cells.push_back(shown(result.rows[i].at(result.columns[j])));
    table.row(cells);
  }
  std::string text = table.text();
  if (rows < result.rows.size() || columns < result.columns.size()) {
    text += fmt::format("({} of {} rows and {} of {} columns; study.csv has them all)\n", rows, result.rows.size(),
                        columns, result.columns.size());
  }
  return text;
}

std::string text_of(const StudyResult& result) {
  std::string text = fmt::format("{}: {}\n\n{}", result.name, result.caption, rows_text(result));
  if (!result.references.empty()) {
    TextTable table({"quantity", "paper", "computed", "note"});
    for (const StudyReference& r : result.references)
      table.row({r.quantity, shown(r.paper), shown(r.computed), r.note});
    text += "\n" + table.text();
  }
  for (const std::string& note : result.notes) text += "note: " + note + "\n";
  return text;
}

StudyOptions study_options(const Options& options) {
  StudyOptions study;
  study.jobs = options.common.jobs;
  study.resume = options.resume;
  if (!options.common.quiet) {
    study.notice = [](const std::string& message) { fmt::print(stderr, "jaculus: {}\n", message); };
  }
  if (shows_progress(options.common)) {
    study.progress = [](const TaskProgress& p) {
      const int filled = p.total > 0 ? 30 * p.done / p.total : 30;
      fmt::print(stderr, "\r[{:-<30}] {}/{}  {:.0f} s, {:.0f} s to go ",
                 std::string(static_cast<std::size_t>(filled), '#'), p.done, p.total, p.elapsed_s, p.remaining_s);
    };
  }
  return study;
}

int run(const Options& options) {
  const Common& common = options.common;
  if (options.resume && common.out.empty()) {
    throw InputError("--resume: given without --out; allowed: with the --out of the run to go on with");
  }
  if (common.seed) throw InputError("--seed: given; allowed: nothing, since a study has nothing random in it");
  if (!common.out.empty()) prepare_folder(common.out);
  const StudyResult result = run_study(options.file, common.out, study_options(options));
  if (shows_progress(common)) fmt::print(stderr, "\r\033[K");
  if (common.json) {
    print(study_json(result));
  } else if (!common.quiet) {
    print(text_of(result));
    if (result.complete && !common.out.empty()) print(fmt::format("written to {}\n", common.out));
  }
  if (interrupt_requested()) {
    fmt::print(stderr, "jaculus: interrupted{}\n",
               common.out.empty() ? "" : "; what is finished is kept, --resume goes on");
  }
  return result.complete ? kDone : kNotSolved;
}

}  // namespace

void add_study(CLI::App& app, Action& chosen) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("study", "Reorientation, tail design and drag bench over grids of parameters.");
  command->footer(
      "Writes study.csv and study.json into --out; exit code 1 where points are missing.\n"
      "Example:\n  jaculus study problems/fig3_effectiveness.yaml --out fig3");
  command->add_option("study", options->file, "a study file")->required();
  add_common(*command, options->common, "folder for the results; nothing is written unless given");
  command->add_flag("--resume", options->resume, "go on with what an interrupted run has finished in --out");
  command->callback([options, &chosen] { chosen = [options] { return run(*options); }; });
}

}  // namespace jaculus::cli
