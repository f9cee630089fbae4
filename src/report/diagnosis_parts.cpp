#include "report/diagnosis_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/noise/noise_model.h"
#include "report/render/stick_figure.h"

namespace jaculus::report {
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

std::vector<TrialSamples> samples_of(const diagnosis::ObservedDataset& observed,
                                     const PredictedRows& rows, std::size_t c, int channel) {
  std::vector<TrialSamples> all;
  for (const diagnosis::RowSpan& span : diagnosis::row_spans(observed)) {
    if (span.channel != channel) continue;
    const diagnosis::Segment& segment = observed.segments[span.segment];
    if (all.empty() || all.back().trial != segment.trial)
      all.push_back({segment.trial, {}, {}, {}, {}});
    TrialSamples& s = all.back();
    const Vector& time = segment.time[channel];
    if (!s.time.empty()) {
      s.time.push_back(0.5 * (s.time.back() + time[0]));
      for (auto* values : {&s.measured, &s.nominal, &s.best}) values->push_back(kNaN);
    }
    s.time.insert(s.time.end(), time.begin(), time.end());
    append(rows.measured[c], span.first, span.count, s.measured);
    append(rows.nominal[c], span.first, span.count, s.nominal);
    append(rows.best[c], span.first, span.count, s.best);
  }

  return all;
}

Chart channel_chart(const diagnosis::Diagnosis& diagnosis, const PredictedRows& rows, std::size_t c,
                    int index) {
  const diagnosis::ObservedDataset& observed = diagnosis.problem->observations.datasets[c];
  const diagnosis::Channel& channel = observed.channels[index];
  const std::string prefix =
      diagnosis.problem->observations.datasets.size() > 1 ? fmt::format("dataset {}, ", c + 1) : "";
  Chart chart;
  chart.id = report_id(fmt::format("{}_{}_{}", c + 1, channel.stream, channel.name));
  chart.title = fmt::format("{}{}: {}", prefix, channel.stream, channel.name);
  chart.x = {"time", "s"};
  chart.y = {channel.name, channel.unit};
  chart.over_time = c == 0;
  const std::vector<TrialSamples> all = samples_of(observed, rows, c, index);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const TrialSamples& s = all[i];
    const std::string name = observed.dataset.trials[s.trial].name;
    chart.series.push_back({name, s.time, s.measured, SeriesStyle::line, kGrey});
  }
  if (all.empty()) return chart;
  const TrialSamples& first = all.front();
  const std::string trial = observed.dataset.trials[first.trial].name;
  Series nominal{fmt::format("model as believed, {}", trial), first.time, first.nominal,
                 SeriesStyle::dashed, 1};
  Series best{fmt::format("model with what was found, {}", trial), first.time, first.best,
              SeriesStyle::line, 0};

  const bool found = !diagnosis.model.candidates.empty();
  const double floor = rows.noise_floor[c][index];
  if (std::isfinite(floor)) {
    Series& banded = found ? best : nominal;
    for (const double v : banded.y) {
      banded.low.push_back(v - kBand * floor);
      banded.high.push_back(v + kBand * floor);
    }
    chart.caption = fmt::format("Band: two standard deviations of one trial, {:.3g} {} each.",
                                floor, channel.unit);
  }
  chart.series.push_back(std::move(nominal));
  if (found) chart.series.push_back(std::move(best));
  return chart;
}

/// Channels of one trial's predictions as motion.
MotionChannels predicted_motion(const diagnosis::ObservedDataset& observed, const Vector& rows,
                                int trial) {
  MotionChannels channels;
  for (const diagnosis::RowSpan& span : diagnosis::row_spans(observed)) {
    const diagnosis::Segment& segment = observed.segments[span.segment];
    if (segment.trial != trial) continue;
    const std::size_t k = span.channel;
    MotionChannel& channel = channels[observed.channels[k].name];
    // a second stream of the same name
    if (!channel.time.empty() && !observed.measured_input) continue;
    for (int i = 0; i < span.count; ++i) {
      channel.time.push_back(segment.time[k][i]);
      channel.value.push_back(rows[span.first + i]);
    }
  }
  return channels;
}

/// What was measured over the time that the predictions are about.
MotionChannels measured_motion(const trajectory::Trial& trial, const MotionChannels& predicted) {
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
bool part_of(const model::PlanarModel& model, int body, effects::Component component) {
  const BodyKind kind = body_kind(model, body);
  const auto front = [&] {
    int root = body;  // the limb's body next to the base
    while (model.bodies[root].parent > 0) root = model.bodies[root].parent;
    return model.bodies[root].origin.x() > 0.0;
  };

  switch (component) {
    case effects::Component::tail_transmission:
      return kind == BodyKind::tail;
    case effects::Component::front_legs:
      return kind == BodyKind::leg && front();
    case effects::Component::rear_legs:
      return kind == BodyKind::leg && !front();
    case effects::Component::body:
      return kind == BodyKind::base;
    default:
      return false;
  }
}

Drawing::Part part(const diagnosis::ComponentShare& share, std::vector<Vec2> line, double width) {
  std::string name = effects::component_name(share.component);
  std::replace(name.begin(), name.end(), '_', ' ');
  const std::string text = fmt::format(
      "{}: {:.0f} % ({:.0f} to {:.0f} %){}", name, 100.0 * share.share, 100.0 * share.ci95.lower,
      100.0 * share.ci95.upper, share.visible ? "" : ", would not show in these data");
  return {name, std::move(line), width, share.share, text};
}

/// Posture for a picture: what the first trial shows first, or the middle of the ranges.
Vector picture_posture(const model::PlanarModel& model) {
  Vector q = Vector::Zero(model.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Bounds& range = model.coordinates[i].range;
    if (std::isfinite(range.lower) && std::isfinite(range.upper))
      q[i] = 0.5 * (range.lower + range.upper);
  }
  return q;
}

}  // namespace

PredictedRows predicted(const diagnosis::Diagnosis& diagnosis) {
  const diagnosis::Problem& problem = *diagnosis.problem;
  const std::vector<diagnosis::ObservedDataset>& datasets = problem.observations.datasets;
  PredictedRows rows;
  std::vector<diagnosis::Alignment> alignments;
  for (int d = 0; d < count_of(datasets); ++d) {
    alignments.push_back(diagnosis.noise ? diagnosis.noise->alignments[d]
                                         : diagnosis::unaligned(datasets[d]));
    rows.measured.push_back(diagnosis::measured_rows(datasets[d], alignments[d]));
    rows.noise_floor.emplace_back();
    for (int c = 0; c < count_of(datasets[d].channels); ++c)
      rows.noise_floor[d].push_back(
          diagnosis.noise ? diagnosis.noise->datasets[d].channels[c].noise_floor : kNaN);
  }

  const auto predict = [&](const Vector& p) {
    const std::vector<Vector> nothing(datasets.size());
    if (p.size() == 0) return nothing;
    const diagnosis::PredictionSet set = diagnosis::predict_all(problem, p);
    return set.valid ? diagnosis::rows_of(problem, alignments, set) : nothing;
  };
  rows.nominal = predict(diagnosis.stated.p);
  rows.best = predict(diagnosis.model.p);
  return rows;
}

std::vector<Chart> channel_charts(const diagnosis::Diagnosis& diagnosis, const PredictedRows& rows,
                                  std::size_t dataset) {
  std::vector<Chart> charts;
  const auto count = count_of(diagnosis.problem->observations.datasets[dataset].channels);
  for (int k = 0; k < count; ++k) charts.push_back(channel_chart(diagnosis, rows, dataset, k));
  return charts;
}

Animation overlay(const diagnosis::Diagnosis& diagnosis, const PredictedRows& rows) {
  Animation animation{"overlay", "Measured (solid) over predicted (ghost)", {}, ""};
  const std::vector<diagnosis::ObservedDataset>& datasets =
      diagnosis.problem->observations.datasets;

  for (std::size_t c = 0; c < datasets.size(); ++c) {
    const diagnosis::ObservedDataset& observed = datasets[c];
    if (observed.segments.empty()) continue;
    const int trial = observed.segments.front().trial;
    const trajectory::Trial& measured = observed.dataset.trials[trial];
    Animation::Panel panel{
        fmt::format("{}, {}", observed.dataset.folder.filename().string(), measured.name), {}};
    for (const auto& [values, name, colour] : {std::tuple{&rows.nominal[c], "model as believed", 1},
                                               {&rows.best[c], "model with what was found", 0}}) {
      if (values->size() == 0 || (colour == 0 && diagnosis.model.candidates.empty())) continue;
      StickFigureOptions ghost{name, ActorStyle::ghost, colour};
      ghost.loads = false;
      panel.actors.push_back(
          stick_figure(observed.model, predicted_motion(observed, *values, trial), ghost));
    }
    StickFigureOptions solid{measured.name, ActorStyle::solid, kGrey};
    if (observed.dataset.plan) solid.phases = motion_phases(*observed.dataset.plan);
    panel.actors.push_back(stick_figure(
        observed.model,
        measured_motion(measured, predicted_motion(observed, rows.measured[c], trial)), solid));
    std::erase_if(panel.actors, [](const Actor& a) { return a.time.size() < 2; });
    if (!panel.actors.empty()) animation.panels.push_back(std::move(panel));
  }

  animation.caption =
      "Over the time that is diagnosed. Bodies whose joints were not measured are not drawn; a "
      "trial's own offsets are "
      "not "
      "taken out.";

  return animation;
}

Drawing body_picture(const model::PlanarModel& model,
                     const std::vector<diagnosis::ComponentShare>& shares) {
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

  for (const diagnosis::ComponentShare& share : shares) {
    if (!share.present) continue;
    const bool tail = share.component == effects::Component::tail_aerodynamics;
    for (int b = 0; b < count_of(lines); ++b) {
      const auto& line = lines[b];
      if (part_of(model, b, share.component))
        drawing.parts.push_back(part(share, line, b == 0 ? 0.04 : 0.015));
      for (const model::PlanarDrag& drag : model.drags) {
        if (!tail || drag.body != b || line.size() < 2 || drag.end <= 0.0) continue;
        const Vec2 root = line.front(), tip = line.back();
        drawing.parts.push_back(
            part(share, {root + drag.start / drag.end * (tip - root), tip}, 0.05));
      }
      for (const model::PlanarMotor& motor : model.motors) {
        if (share.component != effects::Component::actuation || motor.body != b) continue;
        drawing.parts.push_back(part(share, {line.front(), line.front() + Vec2(1e-4, 0.0)}, 0.035));
      }
    }
    if (share.component == effects::Component::contact && !model.feet.empty())
      drawing.parts.push_back(
          part(share, {Vec2(left, low - 0.02), Vec2(right, low - 0.02)}, 0.012));
    if (share.component == effects::Component::sensing)
      drawing.parts.push_back(
          part(share, {Vec2(left, low + 0.5), Vec2(left + 0.06, low + 0.5)}, 0.04));
  }

  // One line of text a component, however many lines it has.
  std::vector<std::string> told;
  for (Drawing::Part& p : drawing.parts) {
    if (std::find(told.begin(), told.end(), p.name) != told.end()) p.text.clear();
    told.push_back(p.name);
  }

  drawing.caption =
      "Motors are dots, the floor is the line under the feet, sensors are the bar to the left.";
  return drawing;
}

}  // namespace jaculus::report
