#include "jaculus/report/compare_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/json.h"
#include "jaculus/report/text_table.h"
#include "jaculus/report/version.h"

namespace jaculus {
namespace {

using Json = nlohmann::ordered_json;

double reference(const Summary& s, const char* key) {
  const auto found = s.reference.find(key);
  return found == s.reference.end() ? kNaN : found->second;
}

/// Largest of a figure over all motors.
double peak(const Summary& s, double MotorFigures::*field) {
  double largest = kNaN;
  for (const MotorFigures& m : s.motors) largest = std::fmax(largest, m.*field);
  return largest;
}

Json gain_json(const Gain& g) {
  return {{"over", g.over.empty() ? Json(nullptr) : Json(g.over)},
          {"unlike_conditions", g.unlike},
          {"average_acceleration", json_number(g.base)},
          {"average_acceleration_com", json_number(g.com)},
          {"time_saved", json_number(g.time)}};
}

Json worth_json(const std::vector<DragWorth>& all) {
  Json json = Json::array();
  for (const DragWorth& w : all) {
    json.push_back({{"drag", w.drag},
                    {"inertial", w.inertial},
                    {"over", w.over},
                    {"unlike_conditions", w.unlike},
                    {"average_acceleration", json_number(w.base)},
                    {"average_acceleration_com", json_number(w.com)}});
  }
  return json;
}

std::string gain_cell(const Gain& g, double value) {
  return g.over.empty() ? std::string("-") : fmt::format("{}{}", percent(value), g.unlike ? " *" : "");
}

std::string main_table(const std::vector<ComparisonRow>& rows, const std::vector<PlanGains>& all) {
  TextTable table({"problem", "tail", "v/T base", "v/T com", "T [s]", "phases [s]", "over tailless", "over held",
                   "drag's share", "status"});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Summary& s = rows[i].summary;
    std::vector<std::string> phases;
    for (const PhaseFigures& p : s.phases) phases.push_back(fixed(p.duration, 4) + (p.at_bound ? "!" : ""));
    table.row({s.name, to_string(rows[i].kind), fixed(s.average_acceleration, 3), fixed(s.average_acceleration_com, 3),
               fixed(s.duration, 4), fmt::format("{}", fmt::join(phases, " + ")),
               gain_cell(all[i].over_first, all[i].over_first.base),
               gain_cell(all[i].over_inactive, all[i].over_inactive.base),
               std::isnan(s.tail_momentum_share) ? "-" : fmt::format("{:.1f} %", 100.0 * s.tail_momentum_share),
               s.status + (s.converged && !s.verification.passed ? ", check failed" : "")});
  }
  return table.text();
}

std::string peak_table(const std::vector<ComparisonRow>& rows) {
  TextTable table({"peaks of one motor", "joint torque [N m]", "motor torque [N m]", "current [A]", "voltage [V]"});
  for (const ComparisonRow& row : rows) {
    const Summary& s = row.summary;
    table.row({s.name, fixed(peak(s, &MotorFigures::joint_torque), 2), fixed(peak(s, &MotorFigures::motor_torque), 2),
               fixed(peak(s, &MotorFigures::current), 1), fixed(peak(s, &MotorFigures::voltage), 2)});
  }
  return table.text();
}

/// Published figures of one leap that don't go together.
std::string contradiction(const Summary& s) {
  const double speed = reference(s, "measured_acceleration_m_s2") * reference(s, "measured_duration_s");
  const double bound = reference(s, "liftoff_velocity_m_s");
  if (!(speed < bound)) return {};
  return fmt::format(
      "{}: published as {} m/s² over {} s on the robot, which is {} m/s at the end and below the plan's own {} m/s; so "
      "its acceleration, its duration or where they were taken differ\n",
      s.name, fixed(reference(s, "measured_acceleration_m_s2"), 1), fixed(reference(s, "measured_duration_s"), 3),
      fixed(speed, 3), fixed(bound, 1));
}

std::string reference_table(const std::vector<ComparisonRow>& rows) {
  TextTable table({"published", "v/T base, planned", "here", "v/T com, planned", "here", "T, planned [s]", "here",
                   "v/T, measured"});
  bool any = false;
  std::string notes;
  for (const ComparisonRow& row : rows) {
    const Summary& s = row.summary;
    if (s.reference.empty()) continue;
    any = true;
    notes += contradiction(s);
    table.row({s.name, fixed(reference(s, "average_acceleration_m_s2"), 3), fixed(s.average_acceleration, 3),
               fixed(reference(s, "average_acceleration_com_m_s2"), 2), fixed(s.average_acceleration_com, 2),
               fixed(reference(s, "duration_s"), 4), fixed(s.duration, 4),
               fixed(reference(s, "measured_acceleration_m_s2"), 1)});
  }
  return any ? fmt::format("\n{}{}", table.text(), notes) : std::string();
}

}  // namespace

std::vector<ComparedPlan> compared_plans(const std::vector<ComparisonRow>& rows) {
  std::vector<ComparedPlan> plans;
  for (const ComparisonRow& row : rows) {
    const Summary& s = row.summary;
    plans.push_back({s.name, row.kind, row.conditions, s.converged, s.average_acceleration, s.average_acceleration_com,
                     s.duration});
  }
  return plans;
}

Json comparison_json(const std::vector<ComparisonRow>& rows) {
  const std::vector<ComparedPlan> plans = compared_plans(rows);
  const std::vector<PlanGains> all = gains(plans);
  Json json = {{"format", "jaculus-compare/1"}, {"version", version()}};
  json["problems"] = Json::array();
  json["reference"] = Json::object();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Json problem = to_json(rows[i].summary);
    problem["tail"] = to_string(rows[i].kind);
    problem["gain_over_tailless"] = gain_json(all[i].over_first);
    problem["gain_over_held"] = gain_json(all[i].over_inactive);
    json["problems"].push_back(problem);
    if (!rows[i].summary.reference.empty()) json["reference"][rows[i].summary.name] = problem["reference"];
  }
  json["drag_worth"] = worth_json(drag_worth(plans));
  return json;
}

std::string comparison_csv(const std::vector<ComparisonRow>& rows) {
  const std::vector<PlanGains> all = gains(compared_plans(rows));
  std::string text =
      "problem,tail,status,average_acceleration [m/s^2],average_acceleration_com [m/s^2],duration [s],first_phase [s],"
      "liftoff_velocity [m/s],gain_over_tailless [-],gain_over_held [-],tail_momentum_share [-],peak_joint_torque [N "
      "m],"
      "peak_motor_torque [N m],peak_current [A],peak_voltage [V],published_average_acceleration [m/s^2],"
      "published_duration [s],measured_acceleration [m/s^2]\n";
  const auto cell = [](double value) { return std::isfinite(value) ? fmt::format(",{}", value) : std::string(","); };
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Summary& s = rows[i].summary;
    text += fmt::format("{},{},{}", s.name, to_string(rows[i].kind), s.status);
    for (const double value :
         {s.average_acceleration, s.average_acceleration_com, s.duration,
          s.phases.empty() ? kNaN : s.phases[0].duration, s.liftoff_velocity, all[i].over_first.base,
          all[i].over_inactive.base, s.tail_momentum_share, peak(s, &MotorFigures::joint_torque),
          peak(s, &MotorFigures::motor_torque), peak(s, &MotorFigures::current), peak(s, &MotorFigures::voltage),
          reference(s, "average_acceleration_m_s2"), reference(s, "duration_s"),
          reference(s, "measured_acceleration_m_s2")}) {
      text += cell(value);
    }
    text += "\n";
  }
  return text;
}

std::string comparison_text(const std::vector<ComparisonRow>& rows, bool colour) {
  const std::vector<ComparedPlan> plans = compared_plans(rows);
  const std::vector<PlanGains> all = gains(plans);
  std::string text = main_table(rows, all);
  text += "v/T in m/s^2: forward velocity at the end over the duration, of the base and of the centre of mass\n";
  const auto unlike = [](const PlanGains& g) { return g.over_first.unlike || g.over_inactive.unlike; };
  if (std::any_of(all.begin(), all.end(), unlike)) text += "* the two were posed under different conditions\n";
  const auto at_bound = [](const ComparisonRow& row) {
    return std::any_of(row.summary.phases.begin(), row.summary.phases.end(), [](const auto& p) { return p.at_bound; });
  };
  if (std::any_of(rows.begin(), rows.end(), at_bound)) text += "! this duration stands at its bound\n";
  text += fmt::format("\n{}{}", peak_table(rows), reference_table(rows));
  for (const DragWorth& w : drag_worth(plans)) {
    text += fmt::format("\nover {}: the gain of {} (drag and inertia) is {} over that of {} (inertia alone){}; com: {}",
                        w.over, w.drag, percent(w.base), w.inertial, w.unlike ? " *" : "", percent(w.com));
  }
  if (!text.ends_with('\n')) text += "\n";
  for (const ComparisonRow& row : rows) {
    for (const std::string& failure : row.summary.verification.failures) {
      text += fmt::format("{} {}: {}\n", coloured("check", Colour::red, colour), row.summary.name, failure);
    }
  }
  return text;
}

}  // namespace jaculus
