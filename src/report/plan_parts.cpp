#include "report/plan_parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "report/document/text_table.h"
#include "report/render/stick_figure.h"

namespace jaculus::report {
namespace {

std::vector<double> column(const trajectory::Table& table, int index) {
  const Vector values = table.values.col(index);
  return {values.begin(), values.end()};
}

const solver::MotorFigures* motor(const solver::Summary& summary, const std::string& name) {
  for (const solver::MotorFigures& m : summary.motors)
    if (m.joint == name) return &m;
  return nullptr;
}

/// The limit of a motor where every plan that has the motor has the same; NaN otherwise.
double common_limit(const std::vector<PlanRecord>& plans, const ChannelChart& what) {
  double limit = kNaN;
  for (const PlanRecord& plan : plans) {
    const solver::MotorFigures* m = motor(plan.summary, what.motor);
    if (m == nullptr) continue;
    const double own = m->*what.limit;
    if (!std::isnan(limit) && own != limit) return kNaN;
    limit = own;
  }
  return limit;
}

std::string number(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : "–";
}

std::string figure(const solver::RowFigure& f) {
  if (f.row.empty()) return "–";
  return fmt::format("{:.2g} {} ({})", f.value, f.unit, f.row);
}

double largest(const std::map<std::string, double>& values) {
  double most = kNaN;
  for (const auto& [name, value] : values) most = std::fmax(most, std::abs(value));
  return most;
}

/// Every motor of any plan, in order.
std::vector<std::string> motor_names(const std::vector<PlanRecord>& plans) {
  std::vector<std::string> names;
  for (const PlanRecord& plan : plans)
    for (const solver::MotorFigures& m : plan.summary.motors)
      if (std::find(names.begin(), names.end(), m.joint) == names.end()) names.push_back(m.joint);
  return names;
}

void add(Section& section, Chart chart) {
  if (!chart.series.empty()) section.charts.push_back(std::move(chart));
}

}  // namespace

Chart channel_chart(const std::vector<PlanRecord>& plans, const ChannelChart& what) {
  Chart chart;
  chart.id = report_id(what.channel);
  chart.title = what.title;
  chart.x = {"time", "s"};
  chart.y = {plain(what.channel), ""};
  chart.over_time = true;
  for (int i = 0; i < count_of(plans); ++i) {
    const trajectory::Table& table = plans[i].tables.plan;
    const int c = table.column(what.channel);
    if (c < 0) continue;
    chart.y.unit = table.columns[c].unit;
    const bool steps = what.held && plans[i].summary.input_hold == transcription::InputHold::held;
    chart.series.push_back({plans[i].summary.name, column(table, table.column("time")),
                            column(table, c), steps ? SeriesStyle::steps : SeriesStyle::line, i});
  }

  if (what.limit == nullptr) return chart;
  const double limit = common_limit(plans, what);
  if (!std::isfinite(limit)) return chart;
  chart.marks.push_back(
      {fmt::format("limit {:g} {}", limit, chart.y.unit), MarkKind::limit, kNaN, limit});
  chart.marks.push_back({"", MarkKind::limit, kNaN, -limit});

  return chart;
}

Section leap_section(const std::vector<PlanRecord>& plans) {
  Section section{"The motion"};
  Animation animation{"motion", "Stick figures at one scale", {}, ""};
  for (int i = 0; i < count_of(plans); ++i) {
    const PlanRecord& plan = plans[i];
    if (plan.tables.plan.columns.empty()) continue;
    StickFigureOptions options;
    options.name = plan.summary.name;
    options.colour = i;
    options.phases = motion_phases(plan.tables.plan);
    if (!plan.model.feet.empty()) options.friction = plan.friction;
    animation.panels.push_back(
        {plan.summary.name,
         {stick_figure(plan.model, motion_channels(plan.tables.plan), options)}});
  }

  animation.caption =
      "The floor takes the colour of the phase. Foot forces are left and right summed, the cone is "
      "that of the "
      "friction which the plan "
      "may use; drag is drawn along the scoop.";
  if (!animation.panels.empty()) section.animations.push_back(std::move(animation));

  return section;
}

Section motion_section(const std::vector<PlanRecord>& plans) {
  Section section{"Velocity and acceleration"};
  for (const ChannelChart& what : {ChannelChart{"x_velocity", "Forward velocity of the base"},
                                   {"x_acceleration", "Forward acceleration of the base"},
                                   {"z_velocity", "Upward velocity of the base"},
                                   {"z", "Height of the base"},
                                   {"pitch", "Pitch (positive: nose down)"},
                                   {"tail", "Tail angle (0: up, positive: forward)"}})
    add(section, channel_chart(plans, what));
  if (!section.charts.empty()) return section;

  for (const PlanRecord& plan : plans) {  // a robot without such a base: its own coordinates
    for (const model::Coordinate& c : plan.model.coordinates) {
      add(section, channel_chart(plans, {c.name, plain(c.name)}));
      add(section, channel_chart(plans, {c.name + "_velocity", plain(c.name) + ", velocity"}));
      add(section,
          channel_chart(plans, {c.name + "_acceleration", plain(c.name) + ", acceleration"}));
    }
    break;
  }

  return section;
}

Section motor_section(const std::vector<PlanRecord>& plans) {
  Section section{"Motors against their limits",
                  {"Figures are those of one motor, before its gear; left and right are alike."}};
  for (const std::string& name : motor_names(plans)) {
    add(section, channel_chart(plans, {name + "_motor_torque", plain(name) + ": motor torque",
                                       &solver::MotorFigures::torque_limit, name, true}));
    add(section, channel_chart(plans, {name + "_voltage", plain(name) + ": voltage",
                                       &solver::MotorFigures::voltage_limit, name}));
    add(section, channel_chart(plans, {name + "_current", plain(name) + ": current",
                                       &solver::MotorFigures::current_limit, name, true}));
    if (channel_chart(plans, {name + "_motor_torque", ""}).series.empty())
      add(section, channel_chart(plans, {name + "_torque", plain(name) + ": torque"}));
  }
  return section;
}

Section force_section(const std::vector<PlanRecord>& plans) {
  Section section{"Foot forces"};
  for (const PlanRecord& plan : plans) {
    for (const model::PlanarPoint& foot : plan.model.feet) {
      for (const auto& [suffix, words] :
           {std::pair{"_force_z", "normal force"}, {"_force_x", "friction force"}}) {
        Chart chart = channel_chart(
            plans, {foot.name + suffix, fmt::format("{}: {}", plain(foot.name), words)});
        const auto same = [&chart](const Chart& other) { return other.id == chart.id; };
        if (std::none_of(section.charts.begin(), section.charts.end(), same))
          add(section, std::move(chart));
      }
    }
  }
  return section;
}

Section verification_section(const std::vector<PlanRecord>& plans) {
  Section section{"Verification"};
  ReportTable table{"Held inputs integrated anew, limits between nodes, balances",
                    {"plan", "verified", "largest error of a position", "worst row",
                     "worst between nodes", "momentum balance", "energy balance"},
                    {},
                    ""};
  ReportTable limits{
      "Limits that hold the plans back", {"plan", "limit", "phase", "from [s]", "to [s]"}, {}, ""};
  ReportTable gains{"What a unit more of a limit would gain",
                    {"plan", "limit", "gain", "unit"},
                    {},
                    "First order: valid for small changes."};

  for (const PlanRecord& plan : plans) {
    const solver::Summary& s = plan.summary;
    const solver::VerificationFigures& v = s.verification;
    table.rows.push_back({s.name, v.passed ? "passed" : "NOT PASSED",
                          number(largest(v.reintegration_error)), figure(v.worst_violation),
                          figure(v.off_node_violation), number(v.momentum_balance),
                          number(v.energy_balance)});
    for (const std::string& failure : v.failures)
      section.text.push_back(fmt::format("{}: {}", s.name, failure));
    for (const solver::PlanLimit& a : s.active_limits)
      limits.rows.push_back({s.name, a.name, a.phase, fixed(a.from, 4), fixed(a.to, 4)});
    for (const solver::LimitGain& g : s.gains)
      gains.rows.push_back({s.name, g.limit, number(g.gain), g.unit});
  }

  section.tables.push_back(table);
  if (!limits.rows.empty()) section.tables.push_back(limits);
  if (!gains.rows.empty()) section.tables.push_back(gains);
  return section;
}

Section history_section(const std::vector<PlanRecord>& plans) {
  Section section{"How the solver went"};
  for (const auto& [name, title] : {std::pair{"objective", "Objective"},
                                    {"infeasibility", "Largest violation of a row"},
                                    {"dual_infeasibility", "Dual infeasibility, scaled"}}) {
    Chart chart;
    chart.id = report_id(std::string("solver_") + name);
    chart.title = title;
    chart.x = {"iteration", "-"};
    chart.y = {plain(name), "-"};
    chart.y.logarithmic = std::string(name) != "objective";
    for (int i = 0; i < count_of(plans); ++i) {
      const trajectory::Table& h = plans[i].tables.history;
      if (h.columns.empty()) continue;
      std::vector<double> values = column(h, h.column(name));
      if (chart.y.logarithmic)
        for (double& v : values) v = v > 0.0 ? v : kNaN;
      chart.series.push_back(
          {plans[i].summary.name, column(h, h.column("iteration")), values, SeriesStyle::line, i});
    }
    add(section, std::move(chart));
  }

  return section;
}

ReportTable published_table(const std::vector<PlanRecord>& plans) {
  ReportTable table{
      "The authors' figures", {"plan", "quantity", "published", "here", "difference"}, {}, ""};

  for (const PlanRecord& plan : plans) {
    const solver::Summary& s = plan.summary;
    const std::map<std::string, std::pair<std::string, double>> here{
        {"average_acceleration_m_s2", {"v/T of the base, planned [m/s²]", s.average_acceleration}},
        {"average_acceleration_com_m_s2",
         {"v/T of the centre of mass, planned [m/s²]", s.average_acceleration_com}},
        {"measured_acceleration_m_s2",
         {"v/T of the base, measured on the robot [m/s²]", s.average_acceleration}},
        {"duration_s", {"duration, planned [s]", s.duration}},
        {"tail_momentum_share", {"momentum from drag [-]", s.tail_momentum_share}}};
    for (const auto& [key, value] : s.reference) {
      const auto found = here.find(key);
      const bool known = found != here.end() && std::isfinite(found->second.second);
      table.rows.push_back({s.name, found == here.end() ? plain(key) : found->second.first,
                            number(value), known ? number(found->second.second) : "–",
                            known ? percent(found->second.second / value - 1.0) : "–"});
    }
  }

  return table;
}

void add_common_sections(const std::vector<PlanRecord>& plans, Document& document) {
  document.sections.push_back(motion_section(plans));
  document.sections.push_back(motor_section(plans));
  document.sections.push_back(force_section(plans));
  const ReportTable published = published_table(plans);
  if (!published.rows.empty())
    document.sections.push_back({"The authors' figures", {}, {}, {published}});
  document.sections.push_back(verification_section(plans));
  document.sections.push_back(history_section(plans));
  std::erase_if(document.sections, [](const Section& s) {
    return s.charts.empty() && s.tables.empty() && s.animations.empty() && s.text.empty();
  });
}

void add_notices(const solver::Summary& s, Document& document) {
  if (!s.converged())
    document.notices.push_back(
        fmt::format("{} did not converge ({}): what is shown is where the search ended, no plan.",
                    s.name, to_string(s.status)));
  if (s.converged() && !s.verification.passed)
    document.notices.push_back(
        fmt::format("{} is optimal but did not pass its verification.", s.name));
}

std::string share_text(double value) {
  return std::isnan(value) ? "–" : fmt::format("{:.1f} %", 100.0 * value);
}

}  // namespace jaculus::report
