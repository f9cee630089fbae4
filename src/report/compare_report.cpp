#include "jaculus/report/compare_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "report/document/text_table.h"
#include "report/plan_parts.h"

namespace jaculus::report {
namespace {

std::string gain(const studies::Gain& g) {
  return g.over.empty() ? "–"
                        : fmt::format("{}{}", percent_or_change(g.base, g.base_change, "m/s²"),
                                      g.unlike ? " *" : "");
}

ReportTable comparison_table(const std::vector<studies::ComparisonRow>& rows) {
  ReportTable table{"Side by side",
                    {"plan", "tail", "v/T base [m/s²]", "v/T centre of mass [m/s²]", "duration [s]",
                     "phases [s]", "over tailless", "over held", "momentum from drag", "status"},
                    {},
                    "v/T: forward velocity at the end over the duration. * the two were posed "
                    "under different conditions."};

  const std::vector<studies::PlanGains> all = studies::gains(studies::compared_plans(rows));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const solver::Summary& s = rows[i].summary;
    std::vector<std::string> phases;
    for (const solver::PhaseFigures& p : s.phases)
      phases.push_back(fixed(p.duration, 4) + (p.at_bound ? " (at its bound)" : ""));
    table.rows.push_back({s.name, to_string(rows[i].tail), fixed(s.average_acceleration, 3),
                          fixed(s.average_acceleration_com, 3), fixed(s.duration, 4),
                          fmt::format("{}", fmt::join(phases, " + ")), gain(all[i].over_first),
                          gain(all[i].over_inactive), share_text(s.tail_momentum_share),
                          to_string(s.status)});
  }

  return table;
}

/// What drag adds to inertia, in sentences.
std::vector<std::string> drag_sentences(const std::vector<studies::ComparisonRow>& rows) {
  std::vector<std::string> sentences;
  for (const studies::DragWorth& w : studies::drag_worth(studies::compared_plans(rows))) {
    sentences.push_back(
        fmt::format("Over {}, the gain of {} (drag and inertia) is {} above that of {} (inertia "
                    "alone){}; by the centre of mass: "
                    "{}.",
                    w.over, w.drag, percent_or_change(w.base, w.base_change, "m/s²"), w.inertial,
                    w.unlike ? ", under different conditions" : "",
                    percent_or_change(w.com, w.com_change, "m/s²")));
  }
  return sentences;
}

Bars acceleration_bars(const std::vector<studies::ComparisonRow>& rows) {
  Bars bars{"average_acceleration", "Average forward acceleration v/T of the base", "m/s²", {}, ""};
  for (const studies::ComparisonRow& row : rows) {
    const auto measured = row.summary.reference.find("measured_acceleration_m_s2");
    bars.items.push_back({row.summary.name, row.summary.average_acceleration, kNaN, kNaN,
                          measured == row.summary.reference.end()
                              ? ""
                              : fmt::format("the authors measured {:.3g} m/s²", measured->second)});
  }
  return bars;
}

}  // namespace

Report compare_report(const std::vector<PlanRecord>& plans,
                      const std::vector<studies::ComparisonRow>& rows) {
  Document document;
  document.kind = "compare";
  document.title = fmt::format("{} plans compared", plans.size());
  document.caption = plans.empty() ? "" : plans.back().summary.caption;
  for (const PlanRecord& plan : plans) {
    document.facts.emplace_back(plan.summary.name,
                                fixed(plan.summary.average_acceleration, 3) + " m/s²");
    add_notices(plan.summary, document);
  }
  document.sections.push_back(leap_section(plans));
  Section result{
      "Result", drag_sentences(rows), {}, {comparison_table(rows)}, {acceleration_bars(rows)}};
  document.sections.push_back(std::move(result));
  add_common_sections(plans, document);
  return finished(std::move(document));
}

}  // namespace jaculus::report
