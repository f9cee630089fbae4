#include "jaculus/report/study_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "jaculus/core/units.h"
#include "report/study_parts.h"

namespace jaculus::report {
namespace {

constexpr std::size_t kMostRows = 600;   // of the table of all rows
constexpr std::size_t kMostCharts = 12;  // where the file asks for none in particular
constexpr std::size_t kMostLines = 12;   // of a chart; more can't be told apart
constexpr std::size_t kMostNotes = 100;  // of points that failed, say

std::string cell(const studies::StudyJson& value) {
  if (value.is_null()) return "–";
  if (value.is_number()) return fmt::format("{:.5g}", value.get<double>());
  return value.is_string() ? value.get<std::string>() : value.dump();
}

bool numeric(const studies::StudyResult& study, const std::string& column) {
  return std::any_of(study.rows.begin(), study.rows.end(),
                     [&](const studies::StudyJson& r) { return r.at(column).is_number(); });
}

/// Distinct values of a column in the order in which they come.
std::vector<studies::StudyJson> values_of(const studies::StudyResult& study,
                                          const std::string& column) {
  std::vector<studies::StudyJson> values;
  std::set<studies::StudyJson> known;
  for (const studies::StudyJson& row : study.rows)
    if (known.insert(row.at(column)).second) values.push_back(row.at(column));
  return values;
}

/// At most `most` of the values, the first and the last among them, evenly between.
std::vector<studies::StudyJson> some_of(const std::vector<studies::StudyJson>& values,
                                        std::size_t most) {
  if (values.size() <= most) return values;
  std::vector<studies::StudyJson> some;
  for (std::size_t k = 0; k < most; ++k)
    some.push_back(values[k * (values.size() - 1) / (most - 1)]);
  return some;
}

double number(const studies::StudyJson& value) {
  return value.is_number() ? value.get<double>() : kNaN;
}

std::string value_name(const std::string& column, const studies::StudyJson& value) {
  if (!value.is_number()) return cell(value);
  const ChartAxis axis = column_axis(column);
  return fmt::format("{} {:.5g}{}", axis.name, value.get<double>(), after_number(axis.unit));
}

/// The lines of a plot: one for each column of y and group, a value of `by`.
std::vector<Series> plot_series(const studies::StudyResult& study, const studies::StudyPlot& plot,
                                const std::vector<studies::StudyJson>& groups) {
  std::vector<Series> all;
  for (std::size_t k = 0; k < plot.y.size(); ++k) {
    for (std::size_t g = 0; g < groups.size(); ++g) {
      Series s;
      const std::string column = column_axis(plot.y[k]).name;
      const std::string group = plot.by.empty() ? "" : value_name(plot.by, groups[g]);
      s.name = plot.by.empty()      ? column
               : plot.y.size() == 1 ? group
                                    : fmt::format("{}, {}", column, group);
      s.style = k == 0 ? SeriesStyle::line : SeriesStyle::dashed;
      s.colour = static_cast<int>(plot.by.empty() ? k : g);
      for (const studies::StudyJson& row : study.rows) {
        if (!plot.by.empty() && row.at(plot.by) != groups[g]) continue;
        s.x.push_back(number(row.at(plot.x)));
        s.y.push_back(number(row.at(plot.y[k])));
      }
      all.push_back(std::move(s));
    }
  }

  return all;
}

Chart plot_chart(const studies::StudyResult& study, const studies::StudyPlot& plot) {
  Chart chart;
  chart.id = report_id(fmt::format("{}_{}", study.name, plot.y[0]));
  chart.title = plot.title;
  chart.x = column_axis(plot.x);
  chart.y = column_axis(plot.y[0]);
  for (const std::string& other : plot.y)  // columns of several names share their unit at most
    if (other != plot.y[0] && !other.starts_with(plot.y[0])) chart.y.name = "value";
  const std::vector<studies::StudyJson> groups =
      plot.by.empty() ? std::vector<studies::StudyJson>{nullptr} : values_of(study, plot.by);
  const std::vector<studies::StudyJson> shown = some_of(groups, kMostLines);
  chart.series = plot_series(study, plot, shown);
  if (shown.size() < groups.size())
    chart.caption = fmt::format("{} of {} values of {} are drawn; study.csv has them all.",
                                shown.size(), groups.size(), column_axis(plot.by).name);
  for (const studies::StudyMark& mark : plot.marks)
    chart.marks.push_back({mark.label, MarkKind::published, mark.x, mark.y, mark.x_to});
  return chart;
}

/// What is drawn where the file does not say: every output against the longest axis of the grid.
std::vector<studies::StudyPlot> default_plots(const studies::StudyResult& study) {
  std::vector<studies::StudyPlot> plots;
  if (study.axes.empty() || study.rows.empty()) return plots;
  std::string x = study.axes[0];
  for (const std::string& axis : study.axes)
    if (numeric(study, axis) && values_of(study, axis).size() > values_of(study, x).size())
      x = axis;
  if (!numeric(study, x) || values_of(study, x).size() < 3) return plots;

  std::string by;
  for (const std::string& axis : study.axes)
    if (axis != x && values_of(study, axis).size() > 1) by = axis;
  for (const std::string& column : study.columns) {
    if (std::find(study.axes.begin(), study.axes.end(), column) != study.axes.end() ||
        !numeric(study, column))
      continue;
    if (plots.size() < kMostCharts)
      plots.push_back({column_axis(column).name, x, {column}, by, {}});
  }

  return plots;
}

/// Outputs of named cases side by side.
std::vector<Bars> case_bars(const studies::StudyResult& study) {
  std::vector<Bars> all;
  const bool cases =
      std::find(study.columns.begin(), study.columns.end(), "case") != study.columns.end();
  if (!cases || study.axes.size() > 1 || study.kind != "reorientation") return all;
  for (const std::string& column : study.columns) {
    if (!numeric(study, column) || all.size() == kMostCharts) continue;
    const ChartAxis axis = column_axis(column);
    Bars bars{
        report_id(study.name + "_" + column), axis.name, axis.unit == "-" ? "" : axis.unit, {}, ""};
    for (const studies::StudyJson& row : study.rows)
      bars.items.push_back({cell(row.at("case")), number(row.at(column)), kNaN, kNaN, ""});
    all.push_back(std::move(bars));
  }
  return all;
}

ReportTable reference_table(const studies::StudyResult& study) {
  ReportTable table{"The paper's figures beside the computed ones",
                    {"quantity", "paper", "computed", "differs by", "note"},
                    {},
                    ""};
  for (const studies::StudyReference& r : study.references) {
    const std::string by =
        std::isnan(r.deviation) ? "" : fmt::format("{:+.1f} %", 100.0 * r.deviation);
    table.rows.push_back({r.quantity, cell(r.paper), cell(r.computed),
                          r.disagrees ? by + " (beyond its digits)" : by, r.note});
  }
  return table;
}

Section rows_section(const studies::StudyResult& study) {
  ReportTable table{"", {}, {}, ""};
  for (const std::string& column : study.columns) {
    const ChartAxis axis = column_axis(column);
    table.columns.push_back(axis.unit == "-" ? axis.name
                                             : fmt::format("{} [{}]", axis.name, axis.unit));
  }

  for (const studies::StudyJson& row : study.rows) {
    if (table.rows.size() == kMostRows) break;
    std::vector<std::string> cells;
    for (const std::string& column : study.columns) cells.push_back(cell(row.at(column)));
    table.rows.push_back(cells);
  }

  if (study.rows.size() > kMostRows)
    table.note = fmt::format("The first {} of {} rows; study.csv has them all.", kMostRows,
                             study.rows.size());
  Section section{fmt::format("All rows of {}", study.name)};
  section.tables.push_back(table);
  section.folded = true;
  return section;
}

Section study_section(const studies::StudyResult& study) {
  Section section{study.name, {study.caption}};
  if (!study.references.empty()) section.tables.push_back(reference_table(study));
  const std::vector<studies::StudyPlot> plots =
      study.plots.empty() ? default_plots(study) : study.plots;
  for (const studies::StudyPlot& plot : plots) {
    Chart chart = plot_chart(study, plot);
    const auto taken = [&](const Chart& other) { return other.id == chart.id; };
    for (int k = 2; std::any_of(section.charts.begin(), section.charts.end(), taken); ++k)
      chart.id = report_id(fmt::format("{}_{}_{}", study.name, plot.y[0], k));
    section.charts.push_back(std::move(chart));
  }
  if (plots.empty()) section.bars = case_bars(study);
  if (study.kind == "drag_bench") section.charts.push_back(drag_bench_chart(study));
  if (study.kind == "tail_design") add_tail_design(study, section);
  return section;
}

}  // namespace

Report study_report(const std::vector<studies::StudyResult>& studies) {
  Document document;
  document.kind = "study";
  document.title =
      studies.size() == 1 ? studies[0].name : fmt::format("{} studies", studies.size());
  document.caption = studies.size() == 1 ? studies[0].caption : "";
  for (const studies::StudyResult& study : studies) {
    if (!study.complete)
      document.notices.push_back(
          fmt::format("{} is not complete: points are missing.", study.name));
    const std::size_t notes = std::min(study.notes.size(), kMostNotes);
    for (std::size_t i = 0; i < notes; ++i)
      document.notices.push_back(fmt::format("{}: {}", study.name, study.notes[i]));
    if (notes < study.notes.size())
      document.notices.push_back(fmt::format("{}: and {} more notes, which study.json has",
                                             study.name, study.notes.size() - notes));
    document.facts.emplace_back(study.name, fmt::format("{} rows", study.rows.size()));
    Section section = study_section(study);
    if (studies.size() == 1) section.title = "Result", section.text.clear();
    document.sections.push_back(std::move(section));
  }
  for (const studies::StudyResult& study : studies)
    document.sections.push_back(rows_section(study));
  return finished(std::move(document));
}

}  // namespace jaculus::report
