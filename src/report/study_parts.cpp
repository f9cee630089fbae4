#include "report/study_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace jaculus::report {
namespace {

constexpr int kCurvePoints = 101;

double number(const studies::StudyJson& row, const char* column) {
  return row.at(column).is_number() ? row.at(column).get<double>() : kNaN;
}

double number_or_zero(const studies::StudyJson& row, const char* column) {
  return row.at(column).is_number() ? row.at(column).get<double>() : 0.0;
}

/// b w^2 + c w + d from rest to `most`.
Series curve(const std::string& name, double b, double c, double d, double most) {
  Series s{name, {}, {}};
  for (int i = 0; i < kCurvePoints; ++i) {
    const double w = most * i / (kCurvePoints - 1);
    s.x.push_back(w);
    s.y.push_back(b * w * w + c * w + d);
  }
  return s;
}

/// A tail from its pin along x, shaft and scoop as wide as they are.
Drawing tail_drawing(const studies::StudyJson& row, std::size_t index) {
  constexpr double kTube = 0.012;  // as wide as a carbon tube [m]
  const double length = number(row, "tail_length_m"), shaft = number(row, "tail_shaft_m"),
               width = number(row, "tail_width_m");
  Drawing drawing{fmt::format("tail_{}", index), "tail, face on", {}, ""};

  // The scoop as an outline: a wide line would end in round caps beyond its ends.
  const double half = 0.5 * width;
  drawing.parts.push_back({"pin", {Vec2(0.0, -0.03), Vec2(0.0, 0.03)}, 0.02, kNaN, "pin"});
  drawing.parts.push_back({"shaft",
                           {Vec2(0.0, 0.0), Vec2(length, 0.0)},
                           kTube,
                           kNaN,
                           fmt::format("shaft to {:.3g} m", shaft)});
  drawing.parts.push_back({"scoop",
                           {Vec2(shaft, -half), Vec2(length, -half), Vec2(length, half),
                            Vec2(shaft, half), Vec2(shaft, -half)},
                           0.006,
                           0.7,
                           fmt::format("scoop, {:.3g} m wide", width)});
  const std::string binding = row.at("binding").get<std::string>();
  drawing.caption = fmt::format(
      "{:.1f} g, effectiveness {:.3f}: length {:.3g} m, shaft {:.3g} m, width {:.3g} m, gear "
      "{:.3g}. {}",
      1e3 * number(row, "tail_mass_kg"), number(row, "effectiveness"), length, shaft, width,
      number(row, "gear"), binding.empty() ? "No limit binds." : "Binding: " + binding + ".");

  return drawing;
}

}  // namespace

ChartAxis column_axis(const std::string& column) {
  struct Suffix {
    const char* written;
    const char* unit;
  };

  static constexpr std::array<Suffix, 22> kSuffixes{
      {{"_N_m_s2", "N m s²"}, {"_N_m_s", "N m s"}, {"_N_m_rad", "N m/rad"}, {"_kg_m2", "kg m²"},
       {"_rad_s2", "rad/s²"}, {"_rad_s", "rad/s"}, {"_kg_m3", "kg/m³"},     {"_m_s2", "m/s²"},
       {"_m_s", "m/s"},       {"_N_m", "N m"},     {"_N_s", "N s"},         {"_N_m_A", "N m/A"},
       {"_deg", "°"},         {"_rad", "rad"},     {"_kg", "kg"},           {"_ohm", "Ω"},
       {"_V", "V"},           {"_A", "A"},         {"_Hz", "Hz"},           {"_m", "m"},
       {"_s", "s"},           {"_N", "N"}}};
  ChartAxis axis{column, "-"};
  for (const Suffix& suffix : kSuffixes) {
    if (!column.ends_with(suffix.written)) continue;
    axis.name = column.substr(0, column.size() - std::string_view(suffix.written).size());
    axis.unit = suffix.unit;
    break;
  }

  std::replace(axis.name.begin(), axis.name.end(), '_', ' ');
  return axis;
}

Chart drag_bench_chart(const studies::StudyResult& study) {
  Chart chart;
  chart.id = report_id(study.name + "_fit");
  chart.title = "Fig. 5: drag torque against speed";
  chart.x = {"speed of the tail", "rad/s"};
  chart.y = {"torque", "N m"};
  Series points{"bench", {}, {}, SeriesStyle::points, 7};
  double most = 0.0;
  for (const studies::StudyJson& sample : study.samples) {
    points.x.push_back(number(sample, "speed_rad_s"));
    points.y.push_back(number(sample, "torque_N_m"));
    most = std::max(most, points.x.back());
  }

  chart.series.push_back(points);
  for (int i = 0; i < count_of(study.rows); ++i) {
    const studies::StudyJson& row = study.rows[i];
    const bool taken = row.at("taken") == "yes";
    Series s =
        curve(fmt::format("{}{}", row.at("model").get<std::string>(), taken ? " (taken)" : ""),
              number_or_zero(row, "quadratic_N_m_s2"), number_or_zero(row, "viscous_N_m_s"),
              number_or_zero(row, "coulomb_N_m"), most);
    s.style = taken ? SeriesStyle::line : SeriesStyle::dashed;
    s.colour = i;
    chart.series.push_back(s);
  }

  for (const studies::StudyReference& r : study.references) {
    if (r.column != "quadratic_N_m_s2" || !r.paper.is_number()) continue;
    const double b = r.paper.get<double>();
    Series s = curve(fmt::format("paper: {:.3g} speed²", b), b, 0.0, 0.0, most);
    s.style = SeriesStyle::dashed;
    s.colour = 6;
    chart.series.push_back(s);
    chart.marks.push_back(
        {fmt::format("paper: {:.3g} speed²", b), MarkKind::published, most, b * most * most});
  }

  return chart;
}

void add_tail_design(const studies::StudyResult& study, Section& section) {
  Chart front;
  front.id = report_id(study.name + "_front");
  front.title = "Pareto front of effectiveness against tail mass";
  front.caption = "Click a point to see its tail.";
  front.x = {"tail mass", "kg"};
  front.y = {"effectiveness", "-"};
  Series line{"front", {}, {}, SeriesStyle::line, 0};
  Choice choice{report_id(study.name + "_tail"), "The chosen tail, to scale", front.id, {}, {}, 0};
  for (const studies::StudyJson& row : study.rows) {
    line.x.push_back(number(row, "tail_mass_kg"));
    line.y.push_back(number(row, "effectiveness"));
    choice.labels.push_back(fmt::format("{:.1f} g, {:.3f}", 1e3 * line.x.back(), line.y.back()));
    choice.drawings.push_back(tail_drawing(row, choice.drawings.size()));
  }

  Series points = line;
  points.name = "tails";
  points.style = SeriesStyle::points;
  points.colour = 1;
  front.series = {line, points};

  for (const auto& [column, title] :
       {std::pair{"tail_length_m", "length"}, {"tail_width_m", "width"}, {"gear", "gear"}}) {
    Chart chart;
    chart.id = report_id(study.name + "_" + column);
    chart.title = fmt::format("{} along the front", title);
    chart.x = front.x;
    chart.y = {title, std::string(column) == "gear" ? "-" : "m"};
    Series s{title, line.x, {}, SeriesStyle::line, 0};
    for (const studies::StudyJson& row : study.rows) s.y.push_back(number(row, column));
    chart.series.push_back(s);
    section.charts.push_back(chart);
  }

  section.charts.insert(section.charts.begin(), front);
  choice.chosen = count_of(choice.drawings) - 1;
  if (!choice.drawings.empty()) section.choices.push_back(std::move(choice));
}

}  // namespace jaculus::report
