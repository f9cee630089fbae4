#include "diagnosis/localise/localise.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/localise/components.h"
#include "diagnosis/localise/departure.h"
#include "diagnosis/localise/force.h"
#include "diagnosis/localise/rows.h"
#include "diagnosis/localise/windows.h"

namespace jaculus::diagnosis {
namespace {

using effects::Component;

/// The entry of a channel, by stream and name.
ChannelGap& entry_of(const Channel& channel, std::vector<ChannelGap>& gaps) {
  for (ChannelGap& gap : gaps)
    if (gap.stream == channel.stream && gap.name == channel.name) return gap;
  gaps.push_back({channel.stream, channel.name, channel.unit});
  return gaps.back();
}

/// Gap by channel over all datasets; datasets with other noise floors count by their own.
std::vector<ChannelGap> channel_gaps(const std::vector<ResidualRows>& datasets) {
  std::vector<ChannelGap> gaps;  // sums of squares until the end
  for (const ResidualRows& rows : datasets) {
    for (const RowSpan& span : rows.spans) {
      const ChannelNoise& noise = rows.channels[span.channel];
      const double energy = rows.judged.segment(span.first, span.count).squaredNorm();
      const double floor = noise.noise_floor * noise.noise_floor;
      ChannelGap& gap = entry_of(rows.observed.channels[span.channel], gaps);
      gap.gap += energy;
      gap.noise_floor += floor * span.count;
      gap.multiple += floor > 0.0 ? energy / floor : 0.0;
      gap.samples += span.count;
      gap.effective += span.count / noise.inflation();
    }
  }

  for (ChannelGap& gap : gaps)
    for (double* sum : {&gap.gap, &gap.noise_floor, &gap.multiple})
      *sum = std::sqrt(*sum / gap.samples);
  return gaps;
}

/// Mean residual of a channel over the segments of a dataset, in bins of its spacing on the
/// command's clock.
DepartureChannel mean_residual(const ResidualRows& rows, int c) {
  struct Bin {
    double residual = 0.0, time = 0.0, variance = 0.0;
    int count = 0;
  };
  const Channel& channel = rows.observed.channels[c];
  const ChannelNoise& noise = rows.channels[c];
  std::map<long, Bin> bins;
  for (const RowSpan& span : rows.spans) {
    if (span.channel != c) continue;
    const Vector& stamps = rows.observed.segments[span.segment].time[c];
    const double origin = rows.alignment.origin(rows.observed, span.segment, c);
    for (int k = 0; k < span.count; ++k) {
      Bin& bin = bins[std::lround((stamps[k] - origin) / channel.spacing)];
      bin.residual += rows.judged[span.first + k];
      bin.time += stamps[k] - origin;
      bin.variance += std::pow(rows.judged_deviation[span.first + k], 2);
      ++bin.count;
    }
  }

  const Eigen::Index count = count_of(bins);
  const bool rate =
      trajectory::parse_channel(channel.name).quantity == trajectory::Quantity::velocity;
  DepartureChannel mean{channel.name,  rate || channel.zero_order_hold,
                        Vector(count), Vector(count),
                        Vector(count), noise.inflation()};
  Eigen::Index i = 0;
  for (const auto& [key, bin] : bins) {
    const double scatter = noise.noise_floor * noise.noise_floor;
    mean.time[i] = bin.time / bin.count;
    mean.mean[i] = bin.residual / bin.count;
    mean.error[i] = std::sqrt((scatter + bin.variance / bin.count) / bin.count);
    ++i;
  }
  return mean;
}

/// The earliest departure among the datasets that a plan or script drove.
Departure departure_of(const std::vector<ResidualRows>& datasets, const Settings& settings,
                       std::vector<std::string>& notes) {
  Departure first;
  for (const ResidualRows& rows : datasets) {
    if (rows.observed.measured_input) {
      notes.emplace_back(
          "a logged input drove the joint, so the model restarts all along: no first departure");
      continue;
    }
    std::vector<DepartureChannel> channels;
    for (int c = 0; c < count_of(rows.channels); ++c)
      if (rows.channels[c].noise_floor > 0.0) channels.push_back(mean_residual(rows, c));
    Departure d = first_departure(channels, settings, rows.observed.window_end);
    if (!first.found || (d.found && d.time < first.time)) first = std::move(d);
  }
  return first;
}

/// Windows, phases and residual force of the first dataset that a plan or script drove.
void add_windows(const Problem& problem, const std::vector<ResidualRows>& datasets,
                 const PlantForward& forward, const Vector& p, Localisation& where) {
  for (const ResidualRows& rows : datasets) {
    if (rows.observed.measured_input) continue;
    std::vector<DepartureChannel> means;
    for (int c = 0; c < count_of(rows.channels); ++c) means.push_back(mean_residual(rows, c));

    WindowAnswer answer = restarted_windows(rows, means, forward, p, problem.settings);
    where.windows = std::move(answer.windows);
    where.phases = std::move(answer.phases);
    where.force = force_residual(problem, rows, means, forward, p);
    if (datasets.size() > 1)
      where.notes.emplace_back("windows, phases and residual force are those of the first dataset");
    return;
  }
}

std::string names_of(const std::vector<Component>& components) {
  std::vector<std::string> names;
  for (const Component c : components) names.emplace_back(component_name(c));
  return fmt::format("{}", fmt::join(names, ", "));
}

/// Whether no channel of any dataset but the base's motion was measured, on a robot that has
/// motors.
bool motion_capture_alone(const std::vector<ResidualRows>& datasets) {
  for (const ResidualRows& rows : datasets) {
    if (rows.observed.model.motors.empty()) return false;
    for (const Channel& channel : rows.observed.channels)
      if (channel.name != "x" && channel.name != "z" && channel.name != "pitch") return false;
  }
  return true;
}

/// What these channels can't tell about components.
void note_components(const Localisation& where, double noted, std::vector<std::string>& notes) {
  std::vector<Component> blind;
  for (const ComponentShare& c : where.components) {
    if (c.present && !c.visible) blind.push_back(c.component);
    if (c.share >= noted && !c.indistinguishable.empty())
      notes.push_back(fmt::format(
          "{} could be {} just as well: these channels don't tell them apart at this gap",
          component_name(c.component), names_of(c.indistinguishable)));
  }
  if (!blind.empty())
    notes.push_back(fmt::format("nothing of {} would show in these channels", names_of(blind)));
}

/// Overall gap, rms in noise floors; NaN where no channel has scatter.
double strength_of(const std::vector<ChannelGap>& gaps) {
  double squares = 0.0, samples = 0.0;
  for (const ChannelGap& g : gaps) {
    squares += g.multiple * g.multiple * g.samples;
    samples += g.noise_floor > 0.0 ? g.samples : 0;
  }
  return samples > 0.0 ? std::sqrt(squares / samples) : kNaN;
}

/// Predictions and nuisances of the nominal model at p, in the noise that the gap is judged by, so
/// that a channel has one floor everywhere.
NoiseModel nominal_in_the_noise_of(const Problem& problem, const Vector& p,
                                   const NoiseModel& judged) {
  NoiseModel noise = estimate_noise(problem, p, judged.alignments);
  if (!noise.valid()) return noise;
  for (std::size_t d = 0; d < noise.datasets.size(); ++d)
    noise.datasets[d].channels = judged.datasets[d].channels;
  return noise;
}

}  // namespace

Localisation localise(const Problem& problem, const PlantForward& forward,
                      const Selection& selection, const Vector& stated, const Posterior& posterior,
                      bool named) {
  Localisation where;
  const NoiseModel noise = nominal_in_the_noise_of(problem, stated, selection.comparison.noise);
  if (!noise.valid()) {
    where.notes.push_back("the model can't be simulated through this experiment: " +
                          noise.at_p.message);
    return where;
  }

  std::vector<ResidualRows> datasets;
  for (int d = 0; d < count_of(problem.observations.datasets); ++d)
    datasets.push_back(residual_rows(problem, noise, d));
  where.channels = channel_gaps(datasets);
  for (const ChannelGap& g : where.channels)
    if (!(g.noise_floor > 0.0))
      where.notes.push_back(g.name + " has no scatter, so it has no part in what follows");
  where.strength = strength_of(where.channels);
  if (std::isnan(where.strength)) return where;

  where.departure = departure_of(datasets, problem.settings, where.notes);
  add_windows(problem, datasets, forward, stated, where);
  ComponentShares shares = component_shares(problem, selection, posterior);
  where.components = std::move(shares.components);
  where.unexplained = shares.unexplained;
  note_components(where, problem.settings.component_noted, where.notes);
  if (!named && where.unexplained < 1.0)
    where.notes.emplace_back(
        "the verdict names no effect: what components are given is how the fitted models would "
        "share the gap, which held-out data or evidence refuse");
  if (motion_capture_alone(datasets))
    where.notes.emplace_back(
        "motion capture alone: joints are inferred from feet that are taken to stand still; record "
        "joint angles to tell components apart");
  return where;
}

}  // namespace jaculus::diagnosis
