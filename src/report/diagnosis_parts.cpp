#include "report/diagnosis_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/report/stick_figure.h"

namespace jaculus {
namespace {

constexpr int kGrey = 7;
constexpr double kBand = 2.0;  // standard deviations of one trial

/// Samples of one channel of one trial; windows of a trial are joined with a gap between.
struct TrialSamples {
  int trial = 0;
  std::vector<double> time, measured, nominal, best;
};

void append(const Vector& from, int first, int count, std::vector<double>& to) {
  for (int i = 0; i < count; ++i) to.push_back(from.size() == 0 ? kNaN : from[first + i]);
}

std::vector<TrialSamples> samples_of(const Condition& condition, const PredictedRows& rows, std::size_t c,
                                     int channel) {
  std::vector<TrialSamples> all;
  const Vector measured = measured_rows(condition);
  for (const RowSpan& span : row_spans(condition)) {
    if (span.channel != channel) continue;
    const Run& run = condition.runs[static_cast<std::size_t>(span.run)];
    if (all.empty() || all.back().trial != run.trial) all.push_back({run.trial, {}, {}, {}, {}});
    TrialSamples& s = all.back();
    const Vector& time = run.time[static_cast<std::size_t>(channel)];
    if (!s.time.empty()) {
      s.time.push_back(0.5 * (s.time.back() + time[0]));
      for (auto* values : {&s.measured, &s.nominal, &s.best}) values->push_back(kNaN);
    }
    s.time.insert(s.time.end(), time.begin(), time.end());
    append(measured, span.first, span.count, s.measured);
    append(rows.nominal[c], span.first, span.count, s.nominal);
    append(rows.best[c], span.first, span.count, s.best);
  }
  return all;
}

Chart channel_chart(const Diagnosis& diagnosis, const PredictedRows& rows, std::size_t c, int index) {
  const Condition& condition = diagnosis.problem->observations.conditions[c];
  const Channel& channel = condition.channels[static_cast<std::size_t>(index)];
  const std::string prefix =
      diagnosis.problem->observations.conditions.size() > 1 ? fmt::format("condition {}, ", c + 1) : "";
  Chart chart;
  chart.id = report_id(fmt::format("{}_{}_{}", c + 1, channel.stream, channel.name));
  chart.title = fmt::format("{}{}: {}", prefix, channel.stream, channel.name);
  chart.x = {"time", "s"};
  chart.y = {channel.name, channel.unit};
  chart.over_time = c == 0;
  const std::vector<TrialSamples> all = samples_of(condition, rows, c, index);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const TrialSamples& s = all[i];
    const std::string name = condition.dataset.trials[static_cast<std::size_t>(s.trial)].name;
    chart.series.push_back({name, s.time, s.measured, SeriesStyle::line, kGrey});
  }
  if (all.empty()) return chart;
  const TrialSamples& first = all.front();
  const std::string trial = condition.dataset.trials[static_cast<std::size_t>(first.trial)].name;
  Series nominal{fmt::format("model as believed, {}", trial), first.time, first.nominal, SeriesStyle::dashed, 1};
  Series best{fmt::format("model with what was found, {}", trial), first.time, first.best, SeriesStyle::line, 0};
  if (!diagnosis.chosen.empty() && std::isfinite(channel.noise_floor)) {
    for (const double v : best.y) {
      best.low.push_back(v - kBand * channel.noise_floor);
      best.high.push_back(v + kBand * channel.noise_floor);
    }
  } else if (std::isfinite(channel.noise_floor)) {
    for (const double v : nominal.y) {
      nominal.low.push_back(v - kBand * channel.noise_floor);
      nominal.high.push_back(v + kBand * channel.noise_floor);
    }
  }
  chart.caption = std::isfinite(channel.noise_floor)
                      ? fmt::format("Band: two standard deviations of one trial, {:.3g} {} each.", channel.noise_floor,
                                    channel.unit)
                      : "";
  chart.series.push_back(std::move(nominal));
  if (!diagnosis.chosen.empty()) chart.series.push_back(std::move(best));
  return chart;
}

/// Channels of one run's predictions as motion.
MotionChannels predicted_motion(const Condition& condition, const Vector& rows, int trial) {
  MotionChannels channels;
  for (const RowSpan& span : row_spans(condition)) {
    const Run& run = condition.runs[static_cast<std::size_t>(span.run)];
    if (run.trial != trial) continue;
    const auto k = static_cast<std::size_t>(span.channel);
    MotionChannel& channel = channels[condition.channels[k].name];
    if (!channel.time.empty() && !condition.measured_input) continue;  // a second stream of the same name
    for (int i = 0; i < span.count; ++i) {
      channel.time.push_back(run.time[k][i]);
      channel.value.push_back(rows[span.first + i]);
    }
  }
  return channels;
}

/// What was measured over the time that the predictions are about.
MotionChannels measured_motion(const Trial& trial, const MotionChannels& predicted) {
  double from = kInfinity, to = -kInfinity;
  for (const auto& [name, channel] : predicted) {
    if (channel.time.empty()) continue;
    from = std::min(from, channel.time.front());
    to = std::max(to, channel.time.back());
  }
  MotionChannels channels = motion_channels(trial);
  for (auto& [name, channel] : channels) {
    MotionChannel kept;
    for (std::size_t i = 0; i < channel.time.size(); ++i) {
      if (channel.time[i] < from || channel.time[i] > to) continue;
      kept.time.push_back(channel.time[i]);
      kept.value.push_back(channel.value[i]);
    }
    channel = std::move(kept);
  }
  return channels;
}

/// Bodies that a component stands for.
bool part_of(const PlanarModel& model, int body, Component component) {
  const std::string kind = body_kind(model, body);
  const auto front = [&] {
    int root = body;  // the limb's body next to the base
    while (model.bodies[static_cast<std::size_t>(root)].parent > 0)
      root = model.bodies[static_cast<std::size_t>(root)].parent;
    return model.bodies[static_cast<std::size_t>(root)].origin.x() > 0.0;
  };
  switch (component) {
    case Component::tail_transmission:
      return kind == "tail";
    case Component::front_legs:
      return kind == "leg" && front();
    case Component::rear_legs:
      return kind == "leg" && !front();
    case Component::body:
      return kind == "base";
    default:
      return false;
  }
}

Drawing::Part part(const ComponentShare& share, std::vector<Vec2> line, double width) {
  std::string name = component_name(share.component);
  std::replace(name.begin(), name.end(), '_', ' ');
  const std::string text =
      fmt::format("{}: {:.0f} % ({:.0f} to {:.0f} %){}", name, 100.0 * share.share, 100.0 * share.ci95.lower,
                  100.0 * share.ci95.upper, share.visible ? "" : ", would not show in these data");
  return {name, std::move(line), width, share.share, text};
}

/// Posture for a picture: what the first trial shows first, or the middle of the ranges.
Vector picture_posture(const PlanarModel& model) {
  Vector q = Vector::Zero(model.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Bounds& range = model.coordinates[static_cast<std::size_t>(i)].range;
    if (std::isfinite(range.lower) && std::isfinite(range.upper)) q[i] = 0.5 * (range.lower + range.upper);
  }
  return q;
}

}  // namespace

PredictedRows predicted(const Diagnosis& diagnosis) {
  PredictedRows rows;
  const DiagnosisProblem& problem = *diagnosis.problem;
  const auto predict = [&problem](const Vector& p) {
    const std::vector<Vector> nothing(problem.observations.conditions.size());
    if (p.size() == 0) return nothing;
    const PredictionSet set = predict_all(problem, p);
    return set.valid ? rows_of(problem, set) : nothing;
  };
  rows.nominal = predict(diagnosis.p_none);
  rows.best = predict(diagnosis.p);
  return rows;
}

std::vector<Chart> channel_charts(const Diagnosis& diagnosis, const PredictedRows& rows, std::size_t condition) {
  std::vector<Chart> charts;
  const auto count = static_cast<int>(diagnosis.problem->observations.conditions[condition].channels.size());
  for (int k = 0; k < count; ++k) charts.push_back(channel_chart(diagnosis, rows, condition, k));
  return charts;
}

Animation overlay(const Diagnosis& diagnosis, const PredictedRows& rows) {
  Animation animation{"overlay", "Measured (solid) over predicted (ghost)", {}, ""};
  const std::vector<Condition>& conditions = diagnosis.problem->observations.conditions;
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    const Condition& condition = conditions[c];
    if (condition.runs.empty()) continue;
    const int trial = condition.runs.front().trial;
    const Trial& measured = condition.dataset.trials[static_cast<std::size_t>(trial)];
    Animation::Panel panel{fmt::format("{}, {}", condition.dataset.folder.filename().string(), measured.name), {}};
    for (const auto& [values, name, colour] :
         {std::tuple{&rows.nominal[c], "model as believed", 1}, {&rows.best[c], "model with what was found", 0}}) {
      if (values->size() == 0 || (colour == 0 && diagnosis.chosen.empty())) continue;
      StickFigureOptions ghost{name, ActorStyle::ghost, colour};
      ghost.loads = false;
      panel.actors.push_back(stick_figure(condition.model, predicted_motion(condition, *values, trial), ghost));
    }
    StickFigureOptions solid{measured.name, ActorStyle::solid, kGrey};
    if (condition.dataset.plan) solid.phases = motion_phases(*condition.dataset.plan);
    panel.actors.push_back(
        stick_figure(condition.model,
                     measured_motion(measured, predicted_motion(condition, measured_rows(condition), trial)), solid));
    std::erase_if(panel.actors, [](const Actor& a) { return a.time.size() < 2; });
    if (!panel.actors.empty()) animation.panels.push_back(std::move(panel));
  }
  animation.caption =
      "Over the time that is diagnosed. Bodies whose joints were not measured are not drawn; a trial's own offsets are "
      "not "
      "taken out.";
  return animation;
}

Drawing body_picture(const PlanarModel& model, const std::vector<ComponentShare>& shares) {
  Drawing drawing{"where", "Where the gap lies, share of its energy", {}, ""};
  const std::vector<std::vector<Vec2>> lines = stick_lines(model, picture_posture(model));
  if (lines.empty()) return drawing;
  double low = kInfinity, left = kInfinity, right = -kInfinity;
  for (const auto& line : lines) {
    for (const Vec2& p : line) {
      low = std::min(low, p.y());
      left = std::min(left, p.x());
      right = std::max(right, p.x());
    }
  }
  for (const ComponentShare& share : shares) {
    const bool tail = share.component == Component::tail_aerodynamics;
    for (int b = 0; b < static_cast<int>(lines.size()); ++b) {
      const auto& line = lines[static_cast<std::size_t>(b)];
      if (part_of(model, b, share.component)) drawing.parts.push_back(part(share, line, b == 0 ? 0.04 : 0.015));
      for (const PlanarDrag& drag : model.drags) {
        if (!tail || drag.body != b || line.size() < 2 || drag.end <= 0.0) continue;
        const Vec2 root = line.front(), tip = line.back();
        drawing.parts.push_back(part(share, {root + drag.start / drag.end * (tip - root), tip}, 0.05));
      }
      for (const PlanarMotor& motor : model.motors) {
        if (share.component != Component::actuation || motor.body != b) continue;
        drawing.parts.push_back(part(share, {line.front(), line.front() + Vec2(1e-4, 0.0)}, 0.035));
      }
    }
    if (share.component == Component::contact && !model.feet.empty())
      drawing.parts.push_back(part(share, {Vec2(left, low - 0.02), Vec2(right, low - 0.02)}, 0.012));
    if (share.component == Component::sensing)
      drawing.parts.push_back(part(share, {Vec2(left, low + 0.5), Vec2(left + 0.06, low + 0.5)}, 0.04));
  }
  // One line of text a component, however many lines it has.
  std::vector<std::string> told;
  for (Drawing::Part& p : drawing.parts) {
    if (std::find(told.begin(), told.end(), p.name) != told.end()) p.text.clear();
    told.push_back(p.name);
  }
  drawing.caption = "Motors are dots, the floor is the line under the feet, sensors are the bar to the left.";
  return drawing;
}

}  // namespace jaculus
