#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "jaculus/report/compare_report.h"
#include "report/document/text_table.h"

namespace jaculus::report {
namespace {

std::string gain_cell(const studies::Gain& g) {
  return g.over.empty() ? std::string("-")
                        : fmt::format("{}{}", percent_or_change(g.base, g.base_change, "m/s^2"),
                                      g.unlike ? " *" : "");
}

std::string main_table(const std::vector<studies::ComparisonRow>& rows,
                       const std::vector<studies::PlanGains>& all) {
  TextTable table({"problem", "tail", "v/T base", "v/T com", "T [s]", "phases [s]", "over tailless",
                   "over held", "drag's share", "status"});

  for (std::size_t i = 0; i < rows.size(); ++i) {
    const solver::Summary& s = rows[i].summary;
    std::vector<std::string> phases;
    for (const solver::PhaseFigures& p : s.phases)
      phases.push_back(fixed(p.duration, 4) + (p.at_bound ? "!" : ""));
    table.row(
        {s.name, to_string(rows[i].tail), fixed(s.average_acceleration, 3),
         fixed(s.average_acceleration_com, 3), fixed(s.duration, 4),
         fmt::format("{}", fmt::join(phases, " + ")), gain_cell(all[i].over_first),
         gain_cell(all[i].over_inactive),
         std::isnan(s.tail_momentum_share) ? "-"
                                           : fmt::format("{:.1f} %", 100.0 * s.tail_momentum_share),
         to_string(s.status) + (s.converged() && !s.verification.passed ? ", check failed" : "")});
  }

  return table.text();
}

std::string peak_table(const std::vector<studies::ComparisonRow>& rows) {
  TextTable table({"peaks of one motor", "joint torque [N m]", "motor torque [N m]", "current [A]",
                   "voltage [V]"});
  for (const studies::ComparisonRow& row : rows) {
    const solver::Summary& s = row.summary;
    table.row({s.name, fixed(largest(s.motors, &solver::MotorFigures::joint_torque), 2),
               fixed(largest(s.motors, &solver::MotorFigures::motor_torque), 2),
               fixed(largest(s.motors, &solver::MotorFigures::current), 1),
               fixed(largest(s.motors, &solver::MotorFigures::voltage), 2)});
  }
  return table.text();
}

/// Published figures of one leap that don't go together.
std::string contradiction(const solver::Summary& s) {
  const double speed =
      published(s, "measured_acceleration_m_s2") * published(s, "measured_duration_s");
  const double bound = published(s, "liftoff_velocity_m_s");
  if (!(speed < bound)) return {};
  return fmt::format(
      "{}: published as {} m/s² over {} s on the robot, which is {} m/s at the end and below the "
      "plan's own {} m/s; so "
      "its acceleration, its duration or where they were taken differ\n",
      s.name, fixed(published(s, "measured_acceleration_m_s2"), 1),
      fixed(published(s, "measured_duration_s"), 3), fixed(speed, 3), fixed(bound, 1));
}

std::string reference_table(const std::vector<studies::ComparisonRow>& rows) {
  TextTable table({"published", "v/T base, planned", "here", "v/T com, planned", "here",
                   "T, planned [s]", "here", "v/T, measured"});
  bool any = false;
  std::string notes;
  for (const studies::ComparisonRow& row : rows) {
    const solver::Summary& s = row.summary;
    if (s.reference.empty()) continue;
    any = true;
    notes += contradiction(s);
    table.row({s.name, fixed(published(s, "average_acceleration_m_s2"), 3),
               fixed(s.average_acceleration, 3),
               fixed(published(s, "average_acceleration_com_m_s2"), 2),
               fixed(s.average_acceleration_com, 2), fixed(published(s, "duration_s"), 4),
               fixed(s.duration, 4), fixed(published(s, "measured_acceleration_m_s2"), 1)});
  }
  return any ? fmt::format("\n{}{}", table.text(), notes) : std::string();
}

}  // namespace

std::string comparison_text(const std::vector<studies::ComparisonRow>& rows, bool colour) {
  const std::vector<studies::ComparedPlan> plans = studies::compared_plans(rows);
  const std::vector<studies::PlanGains> all = studies::gains(plans);
  std::string text = main_table(rows, all);
  text +=
      "v/T in m/s^2: forward velocity at the end over the duration, of the base and of the centre "
      "of mass\n";
  const auto unlike = [](const studies::PlanGains& g) {
    return g.over_first.unlike || g.over_inactive.unlike;
  };

  if (std::any_of(all.begin(), all.end(), unlike))
    text += "* the two were posed under different conditions\n";
  const auto at_bound = [](const studies::ComparisonRow& row) {
    return std::any_of(row.summary.phases.begin(), row.summary.phases.end(),
                       [](const auto& p) { return p.at_bound; });
  };

  if (std::any_of(rows.begin(), rows.end(), at_bound))
    text += "! this duration stands at its bound\n";
  text += fmt::format("\n{}{}", peak_table(rows), reference_table(rows));
  for (const studies::DragWorth& w : studies::drag_worth(plans)) {
    text += fmt::format(
        "\nover {}: the gain of {} (drag and inertia) is {} over that of {} (inertia alone){}; "
        "com: {}",
        w.over, w.drag, percent_or_change(w.base, w.base_change, "m/s^2"), w.inertial,
        w.unlike ? " *" : "", percent_or_change(w.com, w.com_change, "m/s^2"));
  }

  if (!text.ends_with('\n')) text += "\n";
  for (const studies::ComparisonRow& row : rows) {
    for (const std::string& failure : row.summary.verification.failures) {
      text += fmt::format("{} {}: {}\n", coloured("check", Colour::red, colour), row.summary.name,
                          failure);
    }
  }
  return text;
}

}  // namespace jaculus::report
