#pragma once
// What the kinds of studies have in common behind studies/study.h. A new kind is a function here
// and a row in study.cpp.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "jaculus/core/json.h"
#include "jaculus/studies/study.h"

namespace jaculus::studies::detail {

/// A study, read and checked: a list of independent tasks, and how their results become rows.
struct PreparedStudy {
  std::string description;  ///< "60 points, gear 1 to 50 each"
  std::vector<std::string> columns;
  int tasks = 0;
  std::function<std::string(int)> task;  ///< any bytes; must not depend on anything but the file
  /// from all tasks' bytes, in order
  std::function<std::vector<StudyJson>(const std::vector<std::string>&)> rows;
  std::function<std::vector<std::string>(const std::vector<StudyJson>&)> notes;
  std::vector<std::string> axes = {};   ///< see StudyResult
  std::vector<StudyJson> samples = {};  ///< see StudyResult
  std::string fingerprint = {};         ///< of further files that the tasks depend on
  /// The row of a task that failed: its place in the grid. Only where rows are one a task; without
  /// it a study with failures has no rows.
  std::function<StudyJson(int)> failed_row = {};
  bool isolate = false;  ///< every task needs a process of its own
};

/// Keys that every study has.
std::vector<std::string> with_common_keys(std::vector<std::string> keys);

PreparedStudy prepare_reorientation(const yaml::Node& root);
PreparedStudy prepare_motion(const yaml::Node& root);
PreparedStudy prepare_tail_design(const yaml::Node& root);
PreparedStudy prepare_drag_bench(const yaml::Node& root);
PreparedStudy prepare_plan(const yaml::Node& root);

/// Reads `reference`, checked against the columns; evaluates it on the rows.
struct ReferenceQuery {
  std::string quantity;
  StudyJson paper;
  std::string column;
  std::string over_column;  ///< of the divisor
  StudyJson where;
  StudyJson over;  ///< the divisor's row; null: no divisor
  std::string at_largest;
  std::string note;
  double within = kNaN;  ///< of the paper's number; NaN: it is none
  yaml::Node node;
};
std::vector<ReferenceQuery> read_references(const yaml::Node& root,
                                            const std::vector<std::string>& columns);
/// A query that does not pick one row gives null and a note: the rows are not lost for it.
StudyReference evaluate(const ReferenceQuery& query, const std::vector<StudyJson>& rows,
                        std::vector<std::string>& notes);

/// Reads `plots`, checked against the columns.
std::vector<StudyPlot> read_plots(const yaml::Node& root, const std::vector<std::string>& columns);
/// The file that `node` names, relative to the study's own; InputError at `node` where there is
/// none.
std::filesystem::path named_file(const yaml::Node& node);
/// InputError at `where`, naming the nearest, unless `name` is a column.
void must_be_column(const std::string& name, const std::vector<std::string>& columns,
                    const yaml::Node& where);

}  // namespace jaculus::studies::detail
