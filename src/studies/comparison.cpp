#include "jaculus/studies/comparison.h"

#include <fmt/format.h>

#include <cmath>

#include "jaculus/core/installation.h"
#include "jaculus/core/json.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::studies {
namespace {

using Json = nlohmann::ordered_json;
using solver::largest;
using solver::MotorFigures;
using solver::published;

Json gain_json(const Gain& g) {
  return {{"over", g.over.empty() ? Json(nullptr) : Json(g.over)},
          {"unlike_conditions", g.unlike},
          {"average_acceleration", json_number(g.base)},
          {"average_acceleration_com", json_number(g.com)},
          {"average_acceleration_change_m_s2", json_number(g.base_change)},
          {"average_acceleration_com_change_m_s2", json_number(g.com_change)},
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
                    {"average_acceleration_com", json_number(w.com)},
                    {"average_acceleration_change_m_s2", json_number(w.base_change)},
                    {"average_acceleration_com_change_m_s2", json_number(w.com_change)}});
  }
  return json;
}

}  // namespace

ComparisonRow comparison_row(const transcription::Problem& problem, const model::PlanarModel& model,
                             const solver::Summary& summary) {
  return {summary, tail_kind(problem, model), conditions(problem)};
}

std::vector<ComparedPlan> compared_plans(const std::vector<ComparisonRow>& rows) {
  std::vector<ComparedPlan> plans;
  for (const ComparisonRow& row : rows) {
    const solver::Summary& s = row.summary;
    plans.push_back({s.name, row.tail, row.conditions, s.converged(), s.average_acceleration,
                     s.average_acceleration_com, s.duration});
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
    Json problem = solver::to_json(rows[i].summary);
    problem["tail"] = to_string(rows[i].tail);
    problem["gain_over_tailless"] = gain_json(all[i].over_first);
    problem["gain_over_held"] = gain_json(all[i].over_inactive);
    json["problems"].push_back(problem);
    if (!rows[i].summary.reference.empty())
      json["reference"][rows[i].summary.name] = problem["reference"];
  }
  json["drag_worth"] = worth_json(drag_worth(plans));
  return json;
}

std::string comparison_csv(const std::vector<ComparisonRow>& rows) {
  const std::vector<PlanGains> all = gains(compared_plans(rows));
  std::string text =
      "problem,tail,status,average_acceleration [m/s^2],average_acceleration_com [m/s^2],duration "
      "[s],first_phase [s],"
      "liftoff_velocity [m/s],gain_over_tailless [-],gain_over_held [-],tail_momentum_share "
      "[-],peak_joint_torque [N "
      "m],"
      "peak_motor_torque [N m],peak_current [A],peak_voltage [V],published_average_acceleration "
      "[m/s^2],"
      "published_duration [s],measured_acceleration [m/s^2]\n";
  const auto cell = [](double value) {
    return std::isfinite(value) ? fmt::format(",{}", value) : std::string(",");
  };

  for (std::size_t i = 0; i < rows.size(); ++i) {
    const solver::Summary& s = rows[i].summary;
    text += fmt::format("{},{},{}", s.name, to_string(rows[i].tail), to_string(s.status));
    for (const double value :
         {s.average_acceleration, s.average_acceleration_com, s.duration,
          s.phases.empty() ? kNaN : s.phases[0].duration, s.liftoff_velocity,
          all[i].over_first.base, all[i].over_inactive.base, s.tail_momentum_share,
          largest(s.motors, &MotorFigures::joint_torque),
          largest(s.motors, &MotorFigures::motor_torque), largest(s.motors, &MotorFigures::current),
          largest(s.motors, &MotorFigures::voltage), published(s, "average_acceleration_m_s2"),
          published(s, "duration_s"), published(s, "measured_acceleration_m_s2")}) {
      text += cell(value);
    }
    text += "\n";
  }

  return text;
}

void write_comparison(const std::vector<ComparisonRow>& rows, const std::filesystem::path& folder) {
  trajectory::write_file(folder / "compare.csv", comparison_csv(rows));
  trajectory::write_file(folder / "compare.json", comparison_json(rows).dump(1) + "\n");
}

}  // namespace jaculus::studies
