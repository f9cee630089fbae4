#include "jaculus/report/plan_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "jaculus/report/text_table.h"
#include "report/plan_parts.h"

namespace jaculus {
namespace {

std::string share(double value) { return std::isnan(value) ? "–" : fmt::format("{:.1f} %", 100.0 * value); }

ReportTable figures_table(const Summary& s) {
  ReportTable table{"The plan in figures", {"quantity", "value"}, {}, ""};
  const auto row = [&table](const std::string& name, const std::string& value) { table.rows.push_back({name, value}); };
  row("status", s.status + (s.message.empty() ? "" : ": " + s.message));
  row("objective", fmt::format("{:.6g}", s.objective));
  row("forward velocity at the end, base [m/s]", fixed(s.liftoff_velocity, 4));
  row("forward velocity at the end, centre of mass [m/s]", fixed(s.liftoff_velocity_com, 4));
  row("v/T, base [m/s²]", fixed(s.average_acceleration, 3));
  row("v/T, centre of mass [m/s²]", fixed(s.average_acceleration_com, 3));
  row("duration [s]", fixed(s.duration, 5));
  for (const PhaseFigures& p : s.phases)
    row(fmt::format("duration of {} [s]{}", p.name, p.at_bound ? " (at its bound)" : ""), fixed(p.duration, 5));
  if (!std::isnan(s.tail_momentum_share)) row("momentum from drag", share(s.tail_momentum_share));
  row("iterations", fmt::format("{}", s.iterations));
  row("variables, constraints", fmt::format("{}, {}", s.size.variables, s.size.constraints));
  return table;
}

void add_notices(const Summary& s, Report& report) {
  if (!s.converged)
    report.notices.push_back(
        fmt::format("{} did not converge ({}): what is shown is where the search ended, no plan.", s.name, s.status));
  if (s.converged && !s.verification.passed)
    report.notices.push_back(fmt::format("{} is optimal but did not pass its verification.", s.name));
}

/// Sections that a single plan and several have in common, after what is particular.
void add_sections(const std::vector<PlanRecord>& plans, Report& report) {
  report.sections.push_back(motion_section(plans));
  report.sections.push_back(motor_section(plans));
  report.sections.push_back(force_section(plans));
  const ReportTable published = published_table(plans);
  if (!published.rows.empty()) report.sections.push_back({"The authors' figures", {}, {}, {published}});
  report.sections.push_back(verification_section(plans));
  report.sections.push_back(history_section(plans));
  std::erase_if(report.sections, [](const Section& s) {
    return s.charts.empty() && s.tables.empty() && s.animations.empty() && s.text.empty();
  });
}

std::string gain(const Gain& g) {
  return g.over.empty() ? "–" : fmt::format("{}{}", percent(g.base), g.unlike ? " *" : "");
}

ReportTable comparison_table(const std::vector<ComparisonRow>& rows) {
  ReportTable table{
      "Side by side",
      {"plan", "tail", "v/T base [m/s²]", "v/T centre of mass [m/s²]", "duration [s]", "phases [s]", "over tailless",
       "over held", "momentum from drag", "status"},
      {},
      "v/T: forward velocity at the end over the duration. * the two were posed under different conditions."};
  const std::vector<PlanGains> all = gains(compared_plans(rows));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Summary& s = rows[i].summary;
    std::vector<std::string> phases;
    for (const PhaseFigures& p : s.phases)
      phases.push_back(fixed(p.duration, 4) + (p.at_bound ? " (at its bound)" : ""));
    table.rows.push_back({s.name, to_string(rows[i].kind), fixed(s.average_acceleration, 3),
                          fixed(s.average_acceleration_com, 3), fixed(s.duration, 4),
                          fmt::format("{}", fmt::join(phases, " + ")), gain(all[i].over_first),
                          gain(all[i].over_inactive), share(s.tail_momentum_share), s.status});
  }
  return table;
}

/// What drag adds to inertia, in sentences.
std::vector<std::string> drag_sentences(const std::vector<ComparisonRow>& rows) {
  std::vector<std::string> sentences;
  for (const DragWorth& w : drag_worth(compared_plans(rows))) {
    sentences.push_back(fmt::format(
        "Over {}, the gain of {} (drag and inertia) is {} above that of {} (inertia alone){}; by the centre of mass: "
        "{}.",
        w.over, w.drag, percent(w.base), w.inertial, w.unlike ? ", under different conditions" : "", percent(w.com)));
  }
  return sentences;
}

Bars acceleration_bars(const std::vector<ComparisonRow>& rows) {
  Bars bars{"average_acceleration", "Average forward acceleration v/T of the base", "m/s²", {}, ""};
  for (const ComparisonRow& row : rows) {
    const auto measured = row.summary.reference.find("measured_acceleration_m_s2");
    bars.items.push_back({row.summary.name, row.summary.average_acceleration, kNaN, kNaN,
                          measured == row.summary.reference.end()
                              ? ""
                              : fmt::format("the authors measured {:.3g} m/s²", measured->second)});
  }
  return bars;
}

}  // namespace

Report solve_report(const PlanRecord& plan) {
  const Summary& s = plan.summary;
  Report report;
  report.kind = "solve";
  report.title = s.name;
  report.caption = s.caption;
  report.facts = {{"status", s.status}, {"duration", fixed(s.duration, 4) + " s"}};
  if (!std::isnan(s.average_acceleration))
    report.facts.emplace_back("v/T of the base", fixed(s.average_acceleration, 3) + " m/s²");
  if (!std::isnan(s.tail_momentum_share)) report.facts.emplace_back("momentum from drag", share(s.tail_momentum_share));
  report.facts.emplace_back("verification", s.verification.passed ? "passed" : "not passed");
  add_notices(s, report);
  report.sections.push_back(leap_section({plan}));
  report.sections.push_back({"Result", s.warnings, {}, {figures_table(s)}});
  add_sections({plan}, report);
  return report;
}

Report compare_report(const std::vector<PlanRecord>& plans, const std::vector<ComparisonRow>& rows) {
  Report report;
  report.kind = "compare";
  report.title = fmt::format("{} plans compared", plans.size());
  report.caption = plans.empty() ? "" : plans.back().summary.caption;
  for (const PlanRecord& plan : plans) {
    report.facts.emplace_back(plan.summary.name, fixed(plan.summary.average_acceleration, 3) + " m/s²");
    add_notices(plan.summary, report);
  }
  report.sections.push_back(leap_section(plans));
  Section result{"Result", drag_sentences(rows), {}, {comparison_table(rows)}, {acceleration_bars(rows)}};
  report.sections.push_back(std::move(result));
  add_sections(plans, report);
  return report;
}

Table iteration_table(const std::vector<IterationInfo>& history) {
  Table table;
  table.columns = {{"iteration", ""},          {"objective", ""}, {"infeasibility", ""},
                   {"dual_infeasibility", ""}, {"barrier", ""},   {"restoration", ""}};
  table.values.resize(static_cast<Eigen::Index>(history.size()), 6);
  for (std::size_t i = 0; i < history.size(); ++i) {
    const IterationInfo& h = history[i];
    table.values.row(static_cast<Eigen::Index>(i)) << h.iteration, h.objective, h.infeasibility, h.dual_infeasibility,
        h.barrier, h.restoration ? 1.0 : 0.0;
  }
  return table;
}

}  // namespace jaculus
