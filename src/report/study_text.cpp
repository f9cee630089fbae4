// What `jaculus study` prints.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/report/study_report.h"
#include "report/document/text_table.h"

namespace jaculus::report {
namespace {

constexpr std::size_t kStudyRowsShown = 12;
constexpr std::size_t kStudyColumnsShown = 8;

std::string study_cell(const studies::StudyJson& value) {
  if (value.is_null()) return "-";
  if (value.is_number()) return fmt::format("{:.5g}", value.get<double>());
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::string deviation_text(const studies::StudyReference& r) {
  if (std::isnan(r.deviation)) return "";
  return fmt::format("{:+.1f} %{}", 100.0 * r.deviation, r.disagrees ? " (!)" : "");
}

std::string study_rows(const studies::StudyResult& result) {
  const std::size_t columns = std::min(result.columns.size(), kStudyColumnsShown);
  TextTable table({result.columns.begin(), result.columns.begin() + columns});
  const std::size_t rows = std::min(result.rows.size(), kStudyRowsShown);
  for (std::size_t i = 0; i < rows; ++i) {
    std::vector<std::string> cells;
    for (std::size_t j = 0; j < columns; ++j)
      cells.push_back(study_cell(result.rows[i].at(result.columns[j])));
    table.row(cells);
  }
  std::string text = table.text();
  if (rows < result.rows.size() || columns < result.columns.size()) {
    text += fmt::format("({} of {} rows and {} of {} columns; study.csv has them all)\n", rows,
                        result.rows.size(), columns, result.columns.size());
  }
  return text;
}

}  // namespace

std::string study_text(const studies::StudyResult& result) {
  std::string text = fmt::format("{}: {}\n\n{}", result.name, result.caption, study_rows(result));
  if (!result.references.empty()) {
    TextTable table({"quantity", "paper", "computed", "differs by", "note"});
    for (const studies::StudyReference& r : result.references)
      table.row(
          {r.quantity, study_cell(r.paper), study_cell(r.computed), deviation_text(r), r.note});
    text += "\n" + table.text();
  }
  for (const std::string& note : result.notes) text += "note: " + note + "\n";
  return text;
}

}  // namespace jaculus::report
