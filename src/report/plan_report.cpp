#include "jaculus/report/plan_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "report/document/text_table.h"
#include "report/plan_parts.h"

namespace jaculus::report {
namespace {

ReportTable figures_table(const solver::Summary& s) {
  ReportTable table{"The plan in figures", {"quantity", "value"}, {}, ""};
  const auto row = [&table](const std::string& name, const std::string& value) {
    table.rows.push_back({name, value});
  };

  row("status", to_string(s.status) + (s.message.empty() ? "" : ": " + s.message));
  row("objective", fmt::format("{:.6g}", s.objective));
  row("forward velocity at the end, base [m/s]", fixed(s.liftoff_velocity, 4));
  row("forward velocity at the end, centre of mass [m/s]", fixed(s.liftoff_velocity_com, 4));
  row("v/T, base [m/s²]", fixed(s.average_acceleration, 3));
  row("v/T, centre of mass [m/s²]", fixed(s.average_acceleration_com, 3));
  row("duration [s]", fixed(s.duration, 5));
  for (const solver::PhaseFigures& p : s.phases)
    row(fmt::format("duration of {} [s]{}", p.name, p.at_bound ? " (at its bound)" : ""),
        fixed(p.duration, 5));
  if (!std::isnan(s.tail_momentum_share))
    row("momentum from drag", share_text(s.tail_momentum_share));
  row("iterations", fmt::format("{}", s.iterations));
  row("variables, constraints", fmt::format("{}, {}", s.size.variables, s.size.constraints));

  return table;
}

}  // namespace

PlanRecord plan_record(const transcription::Problem& problem, const model::PlanarModel& model,
                       const solver::Summary& summary, const solver::PlanTables& tables) {
  return {summary, model, problem.friction.value_or(model.friction), tables};
}

Report solve_report(const PlanRecord& plan) {
  const solver::Summary& s = plan.summary;
  Document document;
  document.kind = "solve";
  document.title = s.name;
  document.caption = s.caption;
  document.facts = {{"status", to_string(s.status)}, {"duration", fixed(s.duration, 4) + " s"}};
  if (!std::isnan(s.average_acceleration))
    document.facts.emplace_back("v/T of the base", fixed(s.average_acceleration, 3) + " m/s²");
  if (!std::isnan(s.tail_momentum_share))
    document.facts.emplace_back("momentum from drag", share_text(s.tail_momentum_share));
  document.facts.emplace_back("verification", s.verification.passed ? "passed" : "not passed");
  add_notices(s, document);
  document.sections.push_back(leap_section({plan}));
  document.sections.push_back({"Result", s.warnings, {}, {figures_table(s)}});
  add_common_sections({plan}, document);
  return finished(std::move(document));
}

}  // namespace jaculus::report
