#include "diagnosis/localise/events.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <tuple>

#include "jaculus/dynamics/rigid_body.h"

namespace jaculus::diagnosis {
namespace {

/// Median of |x| of a normal number.
constexpr double kMedianOfNormal = 0.6745;
constexpr int kWidths[] = {1, 2, 4, 8};
/// Share of an event's largest force that still belongs to it.
constexpr double kBelongs = 0.3;
constexpr double kSameTime = 1e-6;  // [s]

double run_mean(const ForceSeries& series, int first, int width) {
  double sum = 0.0;
  for (int i = 0; i < width; ++i) sum += series.force[first + i];
  return sum / width;
}

double usual_size(const std::vector<ForceSeries>& series, int width) {
  std::vector<double> sizes;
  for (const ForceSeries& own : series)
    for (int i = 0; i + width <= count_of(own.force); ++i)
      sizes.push_back(std::abs(run_mean(own, i, width)));
  if (sizes.empty()) return kInfinity;
  const auto middle = sizes.begin() + (std::ssize(sizes) / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return *middle / kMedianOfNormal;
}

/// Mean of a run, or of it with a box more at either side where that is nearer to zero: a rate that
/// was measured wrongly at one instant pushes the boxes on both sides of it against one another.
double steady_mean(const ForceSeries& series, int first, int width) {
  const double own = run_mean(series, first, width) * width;
  double least = own;
  for (const int before : {0, 1}) {
    for (const int after : {0, 1}) {
      const int from = first - before, to = first + width + after;
      if (from < 0 || to > count_of(series.force)) continue;
      const double sum = run_mean(series, from, to - from) * (to - from);
      if (sum * own <= 0.0) return 0.0;
      if (std::abs(sum) < std::abs(least)) least = sum;
    }
  }
  return least / width;
}

bool overlaps(const EventRun& a, const EventRun& b) {
  return a.series == b.series && a.first <= b.last && b.first <= a.last;
}

bool same_way(const ForceSeries& a, const EventRun& of_a, const ForceSeries& b,
              const EventRun& of_b) {
  const bool together =
      a.time[of_a.first] <= b.time[of_b.last] && b.time[of_b.first] <= a.time[of_a.last];
  return together &&
         a.force[(of_a.first + of_a.last) / 2] * b.force[(of_b.first + of_b.last) / 2] > 0.0;
}

/// Without what another trial has at the same time: that comes with the motion.
std::vector<EventRun> only_once(const std::vector<ForceSeries>& series,
                                const std::vector<EventRun>& found) {
  std::vector<EventRun> events;
  for (const EventRun& event : found) {
    const auto repeats = [&](const EventRun& other) {
      return other.series != event.series &&
             same_way(series[event.series], event, series[other.series], other);
    };
    if (std::none_of(found.begin(), found.end(), repeats)) events.push_back(event);
  }
  return events;
}

/// The run with the boxes beside it that push the same way by a share of its largest force.
EventRun widened(const ForceSeries& series, EventRun run) {
  double peak = 0.0;
  for (int i = run.first; i <= run.last; ++i)
    if (std::abs(series.force[i]) > std::abs(peak)) peak = series.force[i];
  const auto belongs = [&](int i) {
    return i >= 0 && i < count_of(series.force) && series.force[i] / peak >= kBelongs;
  };
  while (belongs(run.first - 1)) --run.first;
  while (belongs(run.last + 1)) ++run.last;
  while (run.first < run.last && !belongs(run.first)) ++run.first;
  while (run.first < run.last && !belongs(run.last)) --run.last;
  return run;
}

/// The force that is missing between the starts of two windows, along every coordinate; empty where
/// the second doesn't follow the first, or can't be simulated.
Vector force_between(const PlantForward& forward, int dataset, int segment,
                     const ObservedDataset& observed, double box, const Vector& p) {
  if (segment + 1 >= count_of(observed.segments)) return {};
  const Segment &own = observed.segments[segment], &next = observed.segments[segment + 1];
  const double length = next.start - own.start;
  if (next.trial != own.trial || std::abs(length - box) > kSameTime) return {};

  SimulationSetup setup = forward.setup(dataset, segment, p);
  setup.options.sample_times = Vector::LinSpaced(2, 0.0, length);
  setup.options.duration = length;
  const simulation::Simulation simulated =
      simulate(setup.plant, setup.controller, setup.start, setup.options);
  if (simulated.status != simulation::SimulationStatus::done || simulated.time.size() != 2 ||
      !simulated.v.allFinite())
    return {};

  const dynamics::AbsoluteTree tree(setup.plant.model);
  dynamics::Motion motion(tree);
  if (!set_configuration(tree, next.start_q, motion)) return {};
  return mass_matrix(tree, motion) * (next.start_v - simulated.v.col(1)) / length;
}

/// Forces of a dataset, a series for every trial and coordinate.
std::vector<std::vector<ForceSeries>> series_of(const Problem& all, const PlantForward& forward,
                                                int dataset, const Vector& p) {
  const ObservedDataset& observed = all.observations.datasets[dataset];
  const double box = all.settings.window_length;
  std::vector<Vector> forces(observed.segments.size());
  tbb::parallel_for(0, count_of(forces), [&](int s) {
    forces[s] = force_between(forward, dataset, s, observed, box, p);
  });

  const std::size_t trials = observed.dataset.trials.size();
  std::vector<std::vector<ForceSeries>> series(observed.model.size(),
                                               std::vector<ForceSeries>(trials));
  for (int s = 0; s < count_of(forces); ++s) {
    const Segment& own = observed.segments[s];
    for (int i = 0; i < forces[s].size(); ++i) {
      ForceSeries& at = series[i][own.trial];
      at.time.push_back(own.start + 0.5 * box);
      at.force.push_back(forces[s][i]);
    }
  }
  return series;
}

/// Largest mean of two boxes of a run that follow one another: one box alone may be noise.
double peak_of(const ForceSeries& series, const EventRun& run) {
  double peak = run.first == run.last ? series.force[run.first] : 0.0;
  for (int i = run.first; i < run.last; ++i)
    if (const double mean = run_mean(series, i, 2); std::abs(mean) > std::abs(peak)) peak = mean;
  return peak;
}

double probability_of(double deviations, std::size_t tried) {
  return 1.0 - std::min(1.0, static_cast<double>(tried) * std::erfc(deviations / std::sqrt(2.0)));
}

}  // namespace

std::vector<EventRun> unusual_runs(const std::vector<ForceSeries>& series, double level) {
  std::vector<EventRun> tried;
  for (const int width : kWidths) {
    const double usual = usual_size(series, width);
    for (int s = 0; s < count_of(series); ++s)
      for (int i = 0; i + width <= count_of(series[s].force); ++i)
        tried.push_back({s, i, i + width - 1, std::abs(steady_mean(series[s], i, width)) / usual});
  }
  if (tried.empty()) return {};
  const double bound =
      std::sqrt(2.0) * boost::math::erfc_inv(level / static_cast<double>(tried.size()));
  std::erase_if(tried, [&](const EventRun& run) { return !(run.deviations > bound); });
  std::stable_sort(tried.begin(), tried.end(), [](const EventRun& a, const EventRun& b) {
    return a.deviations > b.deviations;
  });

  std::vector<EventRun> events;
  for (const EventRun& run : tried) {
    const EventRun whole = widened(series[run.series], run);
    const auto known = [&](const EventRun& event) { return overlaps(event, whole); };
    if (std::none_of(events.begin(), events.end(), known)) events.push_back(whole);
  }
  return only_once(series, events);
}

std::vector<ForceEvent> force_events(const Problem& all, const PlantForward& forward,
                                     const Vector& p) {
  std::vector<ForceEvent> events;
  if (!in_windows(all)) return events;
  const double half = 0.5 * all.settings.window_length;
  for (int d = 0; d < count_of(all.observations.datasets); ++d) {
    const ObservedDataset& observed = all.observations.datasets[d];
    const auto by_coordinate = series_of(all, forward, d, p);
    for (int i = 0; i < observed.model.size(); ++i) {
      const model::Coordinate& coordinate = observed.model.coordinates[i];
      const std::vector<ForceSeries>& series = by_coordinate[i];
      std::size_t tried = 0;
      for (const ForceSeries& own : series) tried += own.force.size() * std::size(kWidths);
      for (const EventRun& run : unusual_runs(series, all.settings.event_level)) {
        const ForceSeries& own = series[run.series];
        events.push_back({d, observed.dataset.trials[run.series].name, coordinate.name,
                          own.time[run.first] - half, own.time[run.last] + half, peak_of(own, run),
                          coordinate.angular ? "N m" : "N", probability_of(run.deviations, tried)});
      }
    }
  }
  std::stable_sort(events.begin(), events.end(), [](const ForceEvent& a, const ForceEvent& b) {
    return std::tie(a.dataset, a.trial, a.from) < std::tie(b.dataset, b.trial, b.from);
  });
  return events;
}

}  // namespace jaculus::diagnosis
