#include "jaculus/report/score_report.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "report/document/document.h"

namespace jaculus::report {
namespace {

std::string shown(const evaluation::ScoreEstimate& e) {
  return std::isnan(e.value) ? "–"
                             : fmt::format("{:.3f} ({:.3f} to {:.3f}), {} cases", e.value,
                                           e.ci95.lower, e.ci95.upper, e.count);
}

Bars::Item item(const std::string& label, const evaluation::ScoreEstimate& e) {
  return {label, e.value, e.ci95.lower, e.ci95.upper, fmt::format("{} cases", e.count)};
}

HeatMap confusion(const evaluation::Metrics& metrics) {
  HeatMap map{report_id("confusion_" + metrics.predictor),
              fmt::format("What {} states of which truth, cases", metrics.predictor),
              "truth",
              "stated",
              {},
              {},
              {},
              ""};
  std::set<std::string> stated;
  for (const auto& [truth, row] : metrics.confusion)
    for (const auto& [name, count] : row) stated.insert(name);
  map.columns.assign(stated.begin(), stated.end());

  for (const auto& [truth, row] : metrics.confusion) {
    map.rows.push_back(truth);
    map.values.emplace_back();
    for (const std::string& column : map.columns) {
      const auto found = row.find(column);
      map.values.back().push_back(found == row.end() ? 0.0 : found->second);
    }
  }

  return map;
}

Chart calibration(const evaluation::Score& score) {
  Chart chart;
  chart.id = "calibration";
  chart.title = "Calibration: how often a statement of a probability is right";
  chart.caption = "On the diagonal, probabilities mean what they say.";
  chart.x = {"stated probability", "-", false, {0.0, 1.0}};
  chart.y = {"share that is right", "-", false, {0.0, 1.0}};
  chart.series.push_back({"ideal", {0.0, 1.0}, {0.0, 1.0}, SeriesStyle::dashed, 7});

  for (std::size_t i = 0; i < score.metrics.size(); ++i) {
    Series s{score.metrics[i].predictor, {}, {}, SeriesStyle::line, static_cast<int>(i)};
    for (const evaluation::ReliabilityBin& bin : score.metrics[i].reliability) {
      if (bin.right.count == 0) continue;
      s.x.push_back(bin.stated);
      s.y.push_back(bin.right.value);
      s.low.push_back(bin.right.ci95.lower);
      s.high.push_back(bin.right.ci95.upper);
    }
    if (i > 0) s.low.clear(), s.high.clear();  // one band can be read, five can't
    Series points{s.name + ", bins", s.x, s.y, SeriesStyle::points, s.colour};
    chart.series.push_back(s);
    if (i == 0) chart.series.push_back(points);
  }

  return chart;
}

/// One point a case: credit against the strength of its gap.
Chart strength(const evaluation::Score& score) {
  Chart chart;
  chart.id = "credit_and_strength";
  chart.title = "Credit of each case against the strength of its gap";
  chart.x = {"gap", "noise floors"};
  chart.y = {"credit", "-"};
  const evaluation::Metrics& metrics = score.metrics.front();
  for (const char* kind : {"single", "several", "pair", "none", "outside", "mixed", "event"}) {
    Series s{kind, {}, {}, SeriesStyle::points, count_of(chart.series)};
    for (std::size_t i = 0; i < score.truths.size() && i < metrics.scores.size(); ++i) {
      if (score.truths[i].kind != kind) continue;
      s.x.push_back(score.truths[i].strength_in_noise_floors);
      s.y.push_back(metrics.scores[i].credit);
    }
    if (!s.x.empty()) chart.series.push_back(s);
  }
  return chart;
}

ReportTable estimates_table(const evaluation::Score& score) {
  ReportTable table{"In figures", {"figure"}, {}, "Intervals: 95 %."};
  std::set<std::string> names;
  for (const evaluation::Metrics& metrics : score.metrics) {
    table.columns.push_back(metrics.predictor);
    for (const auto& [name, estimate] : metrics.by) names.insert(name);
  }

  for (const std::string& name : names) {
    std::vector<std::string> row{name};
    for (const evaluation::Metrics& metrics : score.metrics) {
      const auto found = metrics.by.find(name);
      row.push_back(found == metrics.by.end() ? "–" : shown(found->second));
    }
    table.rows.push_back(row);
  }

  return table;
}

ReportTable case_table(const evaluation::Score& score) {
  ReportTable table{
      "",
      {"case", "kind", "truth", "gap [noise floors]", "stated", "confidence", "credit"},
      {},
      ""};
  const evaluation::Metrics& metrics = score.metrics.front();
  for (std::size_t i = 0; i < score.truths.size() && i < metrics.scores.size(); ++i) {
    const evaluation::CaseTruth& truth = score.truths[i];
    std::string effects;
    for (const std::string& e : truth.effects) effects += (effects.empty() ? "" : " + ") + e;
    table.rows.push_back({truth.case_id, truth.kind, effects.empty() ? "–" : effects,
                          fmt::format("{:.2f}", truth.strength_in_noise_floors),
                          metrics.scores[i].stated,
                          fmt::format("{:.2f}", metrics.scores[i].confidence),
                          fmt::format("{:.2f}", metrics.scores[i].credit)});
  }
  return table;
}

ReportTable comparison_table(const evaluation::Score& score) {
  ReportTable table{"The diagnosis against baselines, paired",
                    {"baseline", "gain of log score", "gain of accuracy"},
                    {},
                    ""};
  for (const evaluation::Comparison& c : score.comparisons)
    table.rows.push_back({c.predictor, shown(c.log_score_gain), shown(c.accuracy_gain)});
  return table;
}

}  // namespace

Report score_report(const evaluation::Score& score) {
  Document document;
  document.kind = "score";
  const bool part = score.sealed > count_of(score.truths);
  document.title = fmt::format("{}{} blinded cases scored", score.truths.size(),
                               part ? fmt::format(" of {}", score.sealed) : "");
  document.caption = score.provenance;
  if (score.metrics.empty()) {
    document.notices.emplace_back("Nothing was scored.");
    return finished(std::move(document));
  }

  const evaluation::Metrics& metrics = score.metrics.front();
  document.facts = {{"cases", fmt::format("{}", score.truths.size())},
                    {"calibration error", fmt::format("{:.3f}", metrics.calibration_error)}};
  Section figures{"Result", {}, {}, {estimates_table(score)}};
  if (!score.comparisons.empty()) figures.tables.push_back(comparison_table(score));
  document.sections.push_back(std::move(figures));
  Section accuracy{"Accuracy"};
  Bars by_strength{
      "credit_by_strength", "Credit by strength of the gap", "-", {}, "Intervals: 95 %."};

  for (const auto& [name, e] : metrics.credit_by_strength)
    by_strength.items.push_back(item(name, e));
  Bars by_effect{"credit_by_effect", "Credit by effect", "-", {}, "Intervals: 95 %."};
  for (const auto& [name, e] : metrics.credit_by_effect) by_effect.items.push_back(item(name, e));
  accuracy.bars = {by_strength, by_effect};
  accuracy.charts = {calibration(score), strength(score)};
  document.sections.push_back(std::move(accuracy));
  Section mixed{"Confusion"};
  for (const evaluation::Metrics& s : score.metrics) mixed.heat_maps.push_back(confusion(s));
  document.sections.push_back(std::move(mixed));
  Section cases{"All cases", {}, {}, {case_table(score)}};
  cases.folded = true;
  document.sections.push_back(std::move(cases));

  return finished(std::move(document));
}

}  // namespace jaculus::report
