#include "jaculus/report/diagnosis_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/forward/problem.h"
#include "jaculus/diagnosis/summary.h"
#include "report/diagnosis_parts.h"
#include "report/diagnosis_picture.h"
#include "report/diagnosis_tables.h"

namespace jaculus::report {
namespace {

constexpr double kWorthASentence = 0.005;  // share of the gap's energy
constexpr std::size_t kMostBars = 10;      // effects that weren't worth a fit have rows too

Bars ranking(const diagnosis::Diagnosis& d) {
  Bars bars{
      "ranking",
      "Which effect, by probability",
      "-",
      {},
      "Log evidence is relative to no effect at all; the error is that on held-out data. What "
      "the verdict says has the share of such verdicts that were right in full; of the rest "
      "only the order means something."};
  for (const diagnosis::Ranked& r : d.ranking) {
    if (bars.items.size() == kMostBars) break;
    bars.items.push_back({plain(r.effect), r.probability, kNaN, kNaN,
                          fmt::format("log evidence {}, error {} noise floors",
                                      shown(r.log_evidence), shown(r.held_out_error))});
  }
  return bars;
}

Section which_section(const diagnosis::Diagnosis& d) {
  Section section{"Which effect"};
  for (const diagnosis::FoundEffect& e : d.effects) {
    std::string like;
    for (const std::string& other : e.indistinguishable)
      like += (like.empty() ? "" : ", ") + plain(other);
    section.text.push_back(
        fmt::format("{}: {}{}", plain(e.name), e.caption,
                    like.empty() ? "" : " These data can't tell it from: " + like + "."));
  }
  if (!d.effects.empty()) section.tables.push_back(parameter_table(d));
  if (ReportTable table = share_table(d); !table.rows.empty()) section.tables.push_back(table);
  if (ReportTable table = event_table(d); !table.rows.empty()) section.tables.push_back(table);
  if (!d.ranking.empty()) section.bars.push_back(ranking(d));
  return section;
}

Bars component_bars(const std::vector<diagnosis::ComponentShare>& shares, const std::string& id,
                    const std::string& title) {
  Bars bars{id, title, "-", {}, "Intervals: 95 %."};
  for (const diagnosis::ComponentShare& s : shares) {
    if (!s.present) continue;
    std::string like;
    for (const effects::Component other : s.indistinguishable)
      like += (like.empty() ? "can't be told from " : ", ") + plain(effects::component_name(other));
    bars.items.push_back(
        {plain(effects::component_name(s.component)), s.share, s.ci95.lower, s.ci95.upper,
         s.visible ? like : "would not show in these data" + (like.empty() ? "" : "; " + like)});
  }
  return bars;
}

Bars channel_bars(const diagnosis::Localisation& where) {
  Bars bars{"gap_by_channel", "Gap by channel", "noise floors", {}, ""};
  for (const diagnosis::ChannelGap& g : where.channels) {
    bars.items.push_back(
        {fmt::format("{} {}", g.stream, plain(g.name)), g.multiple, kNaN, kNaN,
         fmt::format("{} {} rms, noise {}", shown(g.gap, 3), g.unit, shown(g.noise_floor, 3))});
  }
  return bars;
}

/// How well restarted windows are predicted, as steps over time.
Chart window_chart(const diagnosis::Localisation& where) {
  Chart chart;
  chart.id = "restarted_windows";
  chart.title = "Error of the model restarted from the measured state";
  chart.caption =
      "Where the lines part from the noise, the model lacks something at that very time.";
  chart.x = {"time", "s"};
  chart.y = {"error", "noise floors"};
  chart.over_time = true;
  Series error{"restarted", {}, {}, SeriesStyle::line, 0},
      noise{"noise", {}, {}, SeriesStyle::dashed, 7},
      free{"from the start of the trial", {}, {}, SeriesStyle::line, 1};
  for (const diagnosis::RestartedWindow& w : where.windows) {
    for (const double t : {w.start, w.end}) {
      for (Series* s : {&error, &noise, &free}) s->x.push_back(t);
      error.y.push_back(w.done ? w.error : kNaN);
      noise.y.push_back(w.done ? w.noise : kNaN);
      free.y.push_back(w.free_run);
    }
  }

  chart.series = {error, noise, free};
  if (where.departure.found)
    chart.marks.push_back({fmt::format("leaves the model at {:.3f} s", where.departure.time),
                           MarkKind::note, where.departure.time});

  return chart;
}

std::vector<Chart> force_charts(const diagnosis::ForceResidual& force) {
  std::vector<Chart> charts;
  for (int i = 0; i < count_of(force.coordinates); ++i) {
    Chart chart;
    chart.id = report_id("force_" + force.coordinates[i]);
    chart.title = fmt::format("Residual force: {}", plain(force.coordinates[i]));
    chart.x = {"time", "s"};
    chart.y = {"force", force.units[i]};
    chart.over_time = true;
    Series s{"residual force", {force.time.begin(), force.time.end()}, {}, SeriesStyle::line, 0};
    for (Eigen::Index k = 0; k < force.time.size(); ++k) {
      s.y.push_back(force.mean(i, k));
      s.low.push_back(force.mean(i, k) - 2.0 * force.deviation(i, k));
      s.high.push_back(force.mean(i, k) + 2.0 * force.deviation(i, k));
    }
    chart.series.push_back(std::move(s));
    charts.push_back(std::move(chart));
  }

  return charts;
}

Section where_section(const diagnosis::Diagnosis& d) {
  Section section{"Where the gap lies"};
  const diagnosis::Localisation& where = *d.where;
  section.text.push_back(
      fmt::format("Overall gap: {} noise floors.{}", shown(where.strength, 3),
                  where.unexplained < kWorthASentence
                      ? ""
                      : fmt::format(" The fitted effects leave {:.0f} % of its energy.",
                                    100.0 * where.unexplained)));
  if (where.departure.found) {
    section.text.push_back(
        fmt::format("The robot leaves the model at {:.4f} s ({:.4f} to {:.4f} s).",
                    where.departure.time, where.departure.ci95.lower, where.departure.ci95.upper));
  }

  const auto moves = [](const model::PlanarModel& m) {
    return m.base_free[0] || m.base_free[1] || m.base_free[2];
  };
  // An arm's parts have no components of their own that could be coloured.
  if (!d.problem->observations.datasets.empty() &&
      moves(d.problem->observations.datasets.front().model))
    section.drawings.push_back(
        body_picture(d.problem->observations.datasets.front().model, where.components));
  std::erase_if(section.drawings, [](const Drawing& p) { return p.parts.empty(); });
  section.bars.push_back(component_bars(where.components, "gap_by_component", "Gap by component"));
  Bars phases{"gap_by_phase", "Gap by phase", "-", {}, "Intervals: 95 %."};
  for (const diagnosis::PhaseShare& p : where.phases)
    phases.items.push_back({plain(p.name), p.share, p.ci95.lower, p.ci95.upper,
                            fmt::format("{:.3f} to {:.3f} s", p.start, p.end)});
  if (!phases.items.empty()) section.bars.push_back(phases);
  section.bars.push_back(channel_bars(where));
  if (!where.windows.empty()) section.charts.push_back(window_chart(where));
  for (Chart& chart : force_charts(where.force)) section.charts.push_back(std::move(chart));

  return section;
}

Section shrink_section(const diagnosis::Diagnosis& d) {
  const diagnosis::HeldOut& gap = d.gap;
  Section section{"How far the gap shrinks on data that the fit never saw"};
  section.text.push_back(fmt::format(
      "Judged over {} ({} folds). One noise floor is as good as it gets.", gap.over, gap.folds));
  section.tables.push_back(physical_table(d));
  Bars bars{"held_out_gap",
            "Gap on held-out data",
            "noise floors",
            {{"before", gap.before, kNaN, kNaN, ""}, {"after", gap.after, kNaN, kNaN, ""}},
            ""};
  section.bars.push_back(bars);
  ReportTable table{"By channel, in noise floors", {"channel", "before", "after"}, {}, ""};
  for (const auto& [name, c] : gap.channels)
    table.rows.push_back({name, shown(c.before, 3), shown(c.after, 3)});
  section.tables.push_back(table);
  return section;
}

/// What is left, and what it follows; without text where nothing is told.
Section remainder_section(const diagnosis::Diagnosis& d) {
  return {"What is left", diagnosis::remainder_sentences(d)};
}

Section limits_section(const diagnosis::Diagnosis& d) {
  Section section{"What this diagnosis can't say"};
  for (const std::string& note : d.notes) section.text.push_back(note);
  if (d.where)
    for (const std::string& note : d.where->notes) section.text.push_back(note);
  for (const diagnosis::OneOff& o : d.disturbances) {
    section.text.push_back(
        fmt::format("{} was disturbed from {:.3f} s on (most in {}); what follows is left out.",
                    o.trial, o.onset, o.channel));
  }
  if (section.text.empty())
    section.text.emplace_back("Nothing was left out or assumed beyond the catalogue of effects.");
  return section;
}

void add_facts(const diagnosis::Diagnosis& d, Document& document) {
  document.facts.emplace_back("verdict", to_text(d.verdict));
  for (const diagnosis::FoundEffect& e : d.effects)
    document.facts.emplace_back(plain(e.name), fmt::format("p = {:.2f}", e.probability));
  if (!d.gap.valid) return;
  document.facts.emplace_back("gap before, after",
                              fmt::format("{:.2f}, {:.2f}", d.gap.before, d.gap.after));
  if (d.gap.shrink) {
    document.facts.emplace_back("shrink",
                                fmt::format("{:.0f} % ({:.0f} to {:.0f} %)", 100.0 * *d.gap.shrink,
                                            100.0 * d.gap.ci95.lower, 100.0 * d.gap.ci95.upper));
  }
}

}  // namespace

Report diagnosis_report(const diagnosis::Diagnosis& d, const std::string& title) {
  Document document;
  document.kind = "diagnose";
  document.title = title;
  const diagnosis::Summary summary = diagnosis::summary_of(d);
  document.summary = {
      {"Where", summary.where}, {"Which", summary.which}, {"How far", summary.how_far}};
  document.picture = telling_picture(d);
  add_facts(d, document);
  document.notices = d.reasons;
  if (d.problem != nullptr) {
    const PredictedRows rows = predicted(d);
    if (d.where) document.sections.push_back(where_section(d));
    document.sections.push_back(which_section(d));
    if (d.gap.valid) document.sections.push_back(shrink_section(d));
    if (Section left = remainder_section(d); !left.text.empty())
      document.sections.push_back(std::move(left));
    Section motion{"Hardware and model in motion"};
    Animation animation = overlay(d, rows);
    if (!animation.panels.empty()) motion.animations.push_back(std::move(animation));
    if (!motion.animations.empty()) document.sections.push_back(std::move(motion));
    Section channels{"Hardware and model over time"};
    for (std::size_t c = 0; c < d.problem->observations.datasets.size(); ++c)
      for (Chart& chart : channel_charts(d, rows, c)) channels.charts.push_back(std::move(chart));
    document.sections.push_back(std::move(channels));
  }

  document.sections.push_back(limits_section(d));
  if (d.next) {
    Section next{"Next experiment"};
    next.text.push_back(fmt::format("{}: expected log Bayes factor between the rivals {}.",
                                    d.next->experiment, shown(d.next->log_bayes_factor, 3)));
    document.sections.push_back(std::move(next));
  }

  return finished(std::move(document));
}

}  // namespace jaculus::report
