// What `jaculus solve` prints.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/report/plan_report.h"
#include "report/document/text_table.h"
#include "solver/row_words.h"

namespace jaculus::report {
namespace {

using solver::LimitGain;
using solver::MotorFigures;
using solver::PhaseFigures;
using solver::PlanLimit;
using solver::RowFigure;
using solver::Summary;
using solver::VerificationFigures;

std::string beside(const Summary& s, const char* key, int digits) {
  const auto found = s.reference.find(key);
  return found == s.reference.end()
             ? ""
             : fmt::format("   (published: {})", fixed(found->second, digits));
}

std::string head(const Summary& s, bool colour) {
  std::string text = coloured(s.name, Colour::bold, colour);
  if (!s.caption.empty()) text += ": " + s.caption;
  text += fmt::format(
      "\n  status        {}, {} iterations",
      coloured(to_string(s.status), s.converged() ? Colour::green : Colour::red, colour),
      s.iterations);
  if (!s.message.empty()) text += fmt::format(" ({})", s.message);
  text += fmt::format(
      "\n  size          {} variables, {} rows, {} Jacobian and {} Hessian entries\n",
      s.size.variables, s.size.constraints, s.size.jacobian_nonzeros, s.size.hessian_nonzeros);
  return text;
}

std::string figures(const Summary& s) {
  std::string text = fmt::format("  objective     {:.6g}\n", s.objective);
  text += fmt::format("  v/T base      {} m/s^2{}\n", fixed(s.average_acceleration, 3),
                      beside(s, "average_acceleration_m_s2", 3));
  text += fmt::format("  v/T com       {} m/s^2{}\n", fixed(s.average_acceleration_com, 3),
                      beside(s, "average_acceleration_com_m_s2", 3));
  text += fmt::format("  v at the end  {} m/s, com {} m/s\n", fixed(s.liftoff_velocity, 3),
                      fixed(s.liftoff_velocity_com, 3));
  text += fmt::format("  duration      {} s{}\n", fixed(s.duration, 5), beside(s, "duration_s", 5));
  for (const PhaseFigures& p : s.phases) {
    text += fmt::format("    {:<18} {} s{}\n", p.name, fixed(p.duration, 5),
                        p.at_bound ? ", at its bound" : "");
  }
  if (!std::isnan(s.tail_momentum_share)) {
    text += fmt::format("  drag's share of momentum {:.1f} %\n", 100.0 * s.tail_momentum_share);
  }
  return text;
}

std::string motors(const Summary& s) {
  if (s.motors.empty()) return "";
  const bool slides =
      std::any_of(s.motors.begin(), s.motors.end(), [](const auto& m) { return m.slides; });
  const std::string unit = slides ? "N m or N" : "N m";
  TextTable table({"  motor", fmt::format("at the joint [{}]", unit),
                   fmt::format("at the motor [{}]", unit), "current [A]", "voltage [V]"});
  const auto of = [](double peak, double limit) {
    return std::isfinite(limit) ? fmt::format("{} of {:g}", fixed(peak, 2), limit) : fixed(peak, 2);
  };

  for (const MotorFigures& m : s.motors) {
    table.row({fmt::format("  {}{}", m.joint, m.count > 1 ? fmt::format(" (x{})", m.count) : ""),
               fixed(m.joint_torque, 2), of(m.motor_torque, m.torque_limit),
               of(m.current, m.current_limit), of(m.voltage, m.voltage_limit)});
  }

  return "\npeaks at nodes and middles of intervals, of what a plan may use, one motor (what is "
         "passed between: see "
         "below)\n" +
         table.text();
}

std::string limits(const Summary& s) {
  std::string text;
  if (!s.active_limits.empty()) {
    TextTable table({"  limit", "phase", "from [s]", "to [s]", "nodes"});
    for (const PlanLimit& a : s.active_limits) {
      table.row(
          {"  " + a.name, a.phase, fixed(a.from, 4), fixed(a.to, 4), fmt::format("{}", a.nodes)});
    }
    text += "\nactive limits\n" + table.text();
  }
  if (!s.gains.empty()) {
    text += "\nwhat a little more of a limit would gain\n";
    for (const LimitGain& g : s.gains)
      text += fmt::format("  {:<20} {:+.4g} {}\n", g.limit, g.gain, g.unit);
  }
  return text;
}

std::string violation(const RowFigure& v) {
  return v.row.empty() ? std::string("none")
                       : fmt::format("{:.2g} {} ({})", v.value, v.unit, v.row);
}

std::string verification(const Summary& s, bool colour) {
  const VerificationFigures& v = s.verification;
  std::string text =
      fmt::format("\nverification: {}\n", v.passed ? coloured("passed", Colour::green, colour)
                                                   : coloured("NOT PASSED", Colour::red, colour));
  if (!v.reintegration_error.empty()) {
    text += "  re-integration, largest error:";
    for (const auto& [name, error] : v.reintegration_error)
      text += fmt::format(" {} {:.1e}", name, error);
    text += "\n";
  }

  text += fmt::format("  worst row {}; between nodes {}\n", violation(v.worst_violation),
                      violation(v.off_node_violation));
  const auto balance = [](double value) {
    return std::isnan(value) ? "does not apply" : fmt::format("{:.1e}", value);
  };

  text += fmt::format("  balances: momentum {}, energy {}\n", balance(v.momentum_balance),
                      balance(v.energy_balance));
  for (const std::string& failure : v.failures)
    text += "  " + coloured("fails", Colour::red, colour) + ": " + failure + "\n";
  return text;
}

constexpr std::size_t kMostGroups = 6;

/// Rows of one kind in one phase.
struct RowGroup {
  std::string kind, phase;
  RowFigure worst;
  int rows = 0;
};

/// The rows, worst first, by kind and phase: the groups by their worst rows, in that order.
std::vector<RowGroup> grouped(const std::vector<RowFigure>& rows) {
  std::vector<RowGroup> groups;
  for (const RowFigure& row : rows) {
    const solver::RowWords words = solver::row_words(row.row);
    const auto same = [&](const RowGroup& g) {
      return g.kind == words.kind && g.phase == words.phase;
    };
    auto found = std::find_if(groups.begin(), groups.end(), same);
    if (found == groups.end()) {
      groups.push_back({words.kind, words.phase, row});
      found = std::prev(groups.end());
    }
    ++found->rows;
  }
  return groups;
}

std::string group_lines(const std::vector<RowFigure>& rows) {
  const std::vector<RowGroup> groups = grouped(rows);
  std::string text;
  for (std::size_t i = 0; i < std::min(groups.size(), kMostGroups); ++i) {
    const RowGroup& g = groups[i];
    const solver::RowWords worst = solver::row_words(g.worst.row);
    const std::string where = fmt::format(
        "{}{}{}", worst.of, worst.of.empty() || worst.place.empty() ? "" : ", ", worst.place);
    text += fmt::format("  {}{}: {}{:.3g} {}", g.kind, g.phase.empty() ? "" : " in " + g.phase,
                        g.rows > 1 ? "up to " : "", std::abs(g.worst.value), g.worst.unit);
    if (g.rows > 1) text += fmt::format(" in {} rows", g.rows);
    if (!where.empty()) text += fmt::format(" ({}{})", g.rows > 1 ? "most: " : "", where);
    text += "\n";
  }
  if (groups.size() > kMostGroups)
    text += fmt::format("  and {} more (summary.json)\n", groups.size() - kMostGroups);
  return text;
}

/// Why there is no plan: the cause first, then what does not hold.
std::string failure(const Summary& s) {
  std::string text;
  if (!s.binds.empty()) text += "\nno plan holds all limits: " + s.binds + "\n";
  if (!s.conflict.empty()) {
    text +=
        "\nwhat can't hold together: these rows must give way for all others to hold, by kind and "
        "phase\n" +
        group_lines(s.conflict);
    if (!s.conflict_against.empty()) text += "  they strain against\n";
    for (const std::string& limit : s.conflict_against) text += "    " + limit + "\n";
  }
  if (!s.violated_rows.empty())
    text += "\nrows that do not hold at the last iterate, by kind and phase, worst first\n" +
            group_lines(s.violated_rows);
  return text;
}

}  // namespace

std::string summary_text(const solver::Summary& s, bool colour) {
  std::string text = head(s, colour);
  if (!s.converged())
    text += failure(s) + "\n  not a solution: the figures below are those of the last iterate\n";
  text += figures(s) + motors(s) + limits(s) + verification(s, colour);
  for (const std::string& warning : s.warnings)
    text += coloured("mind", Colour::yellow, colour) + ": " + warning + "\n";
  return text;
}

}  // namespace jaculus::report
