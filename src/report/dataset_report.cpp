#include "jaculus/report/dataset_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "report/document/document.h"
#include "report/render/stick_figure.h"

namespace jaculus::report {
namespace {

constexpr std::size_t kMostPanels = 4;
constexpr std::size_t kMostTrials = 12;  // a chart with more lines can't be read

Section motion_section(const trajectory::Dataset& dataset, const model::PlanarModel& model) {
  Section section{"The motion"};
  Animation animation{"motion", "Stick figures at one scale", {}, ""};

  for (std::size_t i = 0; i < std::min(kMostPanels, dataset.trials.size()); ++i) {
    StickFigureOptions options;
    options.name = dataset.trials[i].name;
    options.colour = static_cast<int>(i);
    Animation::Panel panel{options.name, {}};
    if (dataset.plan && dataset.plan->column("time") >= 0) {
      StickFigureOptions ghost;
      ghost.name = "plan";
      ghost.style = ActorStyle::ghost;
      ghost.colour = 7;
      ghost.loads = false;
      panel.actors.push_back(stick_figure(model, motion_channels(*dataset.plan), ghost));
      options.phases = motion_phases(*dataset.plan);
    }
    panel.actors.push_back(stick_figure(model, motion_channels(dataset.trials[i]), options));
    std::erase_if(panel.actors, [](const Actor& a) { return a.time.size() < 2; });
    if (!panel.actors.empty()) animation.panels.push_back(std::move(panel));
  }

  animation.caption = dataset.plan ? "Solid: the trial. Ghost: the plan that was commanded." : "";
  if (!animation.panels.empty()) section.animations.push_back(std::move(animation));
  return section;
}

/// One channel of all trials.
Chart channel_chart(const trajectory::Dataset& dataset, const std::string& stream,
                    const std::string& channel) {
  Chart chart;
  chart.id = report_id(stream + "_" + channel);
  chart.title = fmt::format("{}: {}", stream, plain(channel));
  chart.x = {"time", "s"};
  chart.y = {plain(channel), ""};
  chart.over_time = true;
  for (std::size_t i = 0; i < std::min(kMostTrials, dataset.trials.size()); ++i) {
    const trajectory::Stream* s = dataset.trials[i].stream(stream);
    const int c = s == nullptr ? -1 : s->channel(channel);
    if (c < 0) continue;
    chart.y.unit = s->units[c];
    const Vector values = s->values.row(c).transpose();
    chart.series.push_back({dataset.trials[i].name,
                            {s->time.begin(), s->time.end()},
                            {values.begin(), values.end()},
                            SeriesStyle::line,
                            static_cast<int>(i)});
  }

  const int planned = dataset.plan ? dataset.plan->column(channel) : -1;
  const int time = dataset.plan ? dataset.plan->column("time") : -1;
  if (planned >= 0 && time >= 0) {
    const Vector t = dataset.plan->values.col(time), v = dataset.plan->values.col(planned);
    chart.series.push_back(
        {"plan", {t.begin(), t.end()}, {v.begin(), v.end()}, SeriesStyle::dashed, 7});
  }

  return chart;
}

Section stream_section(const trajectory::Dataset& dataset, const std::string& stream) {
  Section section{fmt::format("Channels of {}", stream)};
  std::vector<std::string> channels;
  for (const trajectory::Trial& trial : dataset.trials) {
    const trajectory::Stream* s = trial.stream(stream);
    if (s == nullptr) continue;
    for (const std::string& name : s->channels)
      if (std::find(channels.begin(), channels.end(), name) == channels.end())
        channels.push_back(name);
  }
  for (const std::string& channel : channels)
    section.charts.push_back(channel_chart(dataset, stream, channel));
  return section;
}

}  // namespace

Report dataset_report(const trajectory::Dataset& dataset, const model::PlanarModel& model,
                      const std::string& title) {
  Document document;
  document.kind = "dataset";
  document.title = title;
  document.caption = dataset.provenance;
  document.facts = {{"robot", dataset.robot},
                    {"experiment", name_of(dataset.experiment)},
                    {"trials", fmt::format("{}", dataset.trials.size())},
                    {"controller", name_of(dataset.controller.kind)}};
  if (dataset.trials.size() > kMostTrials)
    document.notices.push_back(
        fmt::format("The first {} of {} trials are drawn.", kMostTrials, dataset.trials.size()));
  document.sections.push_back(motion_section(dataset, model));

  std::vector<std::string> streams;
  for (const trajectory::Trial& trial : dataset.trials)
    for (const trajectory::Stream& s : trial.streams)
      if (std::find(streams.begin(), streams.end(), s.name) == streams.end())
        streams.push_back(s.name);
  for (const std::string& stream : streams)
    document.sections.push_back(stream_section(dataset, stream));

  return finished(std::move(document));
}

}  // namespace jaculus::report
