#pragma once
// Studies from files: a grid of computed figures, beside what a source says of them.
//
//   format: jaculus-study/1
//   name: fig3_effectiveness            unique, names nothing else
//   kind: reorientation                 reorientation | motion | tail_design | drag_bench | plan
//   caption: one line
//   ...                                 by kind, see reorientation_study.h, tail_design.h,
//                                       drag_fit.h
//   reference:                          optional: the source's figures
//     - {quantity: "...", paper: 0.558, column: effectiveness, where: {case: as built},
//        over: {...}, note: "..."}
//
//   plots:                              optional: what a report draws; without it, outputs against
//                                       the grid
//     - {title: "...", x: normalised_inertia, y: [effectiveness], by: tail_length_m,
//        marks: [{label: "...", x: 0.37}]}
//
// A plot has one line for each column of `y` and each value of `by`; a mark is a figure of the
// source: a point (x and y), a line (x or y alone) or a strip (x and x_to).
//
// A reference's `where` picks the one row whose columns have these values; with `at_largest:
// column` the one of them with the largest value there. `over` picks another row and `over_column`
// another column: the figure is then the ratio. A number of the source that the computed one misses
// by more than `within` (in the column's unit; without it half a unit of the last digit as written:
// 0.0005 for 0.302) is named in the notes as a disagreement.
//
// A point that failed has its row of the grid, empty beyond that, and its reason in the notes.
//
// A run writes study.csv and study.json into its folder. Every finished grid point is kept in
// study.journal at once, so a killed run goes on where it was; the same bytes come out whatever the
// number of workers and the interruptions.

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "jaculus/core/tasks.h"
#include "jaculus/core/yaml.h"

namespace jaculus::studies {

using StudyJson = nlohmann::ordered_json;

/// A source's figure beside the computed one.
struct StudyReference {
  std::string quantity;
  StudyJson paper;          ///< number or text
  StudyJson computed;       ///< number, text or null
  std::string note;         ///< says where they differ, and why
  std::string column = {};  ///< that the figure stands in
  /// (computed - paper)/|paper|, where both are numbers and the paper's is not 0
  double deviation = kNaN;
  bool disagrees = false;  ///< beyond `within`
};

/// A figure of the source in a plot; NaN: not given.
struct StudyMark {
  std::string label;
  double x = kNaN, y = kNaN, x_to = kNaN;
};

/// What a report draws of a study: columns against a column.
struct StudyPlot {
  std::string title;
  std::string x;
  std::vector<std::string> y;
  std::string by;  ///< one line for each of its values; empty: one line
  std::vector<StudyMark> marks;
};

struct StudyResult {
  std::string name;
  std::string kind;
  std::string caption;
  /// false: interrupted, and then there are no rows; or points failed, and then their rows have
  /// the grid's columns and null, or the study's kind has no rows without them
  bool complete = false;
  std::vector<std::string> columns;  ///< of study.csv, with units
  std::vector<StudyJson> rows;       ///< one object a grid point: number, text or null by column
  std::vector<StudyReference> references;
  /// what a user should know: searches on their bound, points that failed
  std::vector<std::string> notes;
  /// columns that the grid gives, the first one varying slowest
  std::vector<std::string> axes = {};
  std::vector<StudyPlot> plots = {};    ///< as the file asks for
  std::vector<StudyJson> samples = {};  ///< what a fit was made of: one object a point
};

struct StudyOptions {
  int jobs = 0;  ///< workers; 0: one a core
  /// insist on going on with the folder's journal; otherwise that is done where it fits
  bool resume = false;
  std::function<void(const TaskProgress&)> progress = {};
  std::function<void(const std::string&)> notice = {};
  std::shared_ptr<const Executor> executor = {};  ///< as of TaskOptions
  std::string stage = "study";                    ///< as of TaskOptions
};

/// Reads and checks a study without running it: a sentence on what it is and its size. InputError
/// on any fault.
std::string check_study(const std::filesystem::path& file);
std::string check_study(const yaml::Node& node);

/// Runs a study. Writes into `folder`, which must exist, unless it is empty. InputError on bad
/// input, before any work is done.
StudyResult run_study(const std::filesystem::path& file, const std::filesystem::path& folder,
                      const StudyOptions& options = {});
StudyResult run_study(const yaml::Node& node, const std::filesystem::path& folder,
                      const StudyOptions& options = {});

/// The files' contents.
std::string study_csv(const StudyResult& result);
std::string study_json(const StudyResult& result);

}  // namespace jaculus::studies
