#include "diagnosis/localise/events.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <map>
#include <tuple>

#include "diagnosis/noise/force_bands.h"
#include "diagnosis/noise/whitening.h"

namespace jaculus::diagnosis {
namespace {

/// Median of |x| of a normal number.
constexpr double kMedianOfNormal = 0.6745;
constexpr int kWidths[] = {1, 2, 4, 8};
/// Share of an event's largest force that still belongs to it.
constexpr double kBelongs = 0.3;

/// Posterior mean of w of a block, of the white residual of its rows.
Vector mean_forces(const RandomBlock& block, const Vector& scales, const Vector& residual) {
  Vector own(count_of(block.group));
  for (int k = 0; k < count_of(block.group); ++k) own[k] = scales[block.group[k]];
  Matrix inner = own.asDiagonal() * block.gram * own.asDiagonal();
  inner.diagonal().array() += 1.0;
  const Vector along =
      own.cwiseProduct(block.columns.transpose() * residual.segment(block.first, block.count));
  return own.cwiseProduct(inner.llt().solve(along));
}

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

bool overlaps(const EventRun& a, const EventRun& b) {
  return a.series == b.series && a.first <= b.last && b.first <= a.last;
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

/// Series by dataset, joint and trial.
using Place = std::tuple<int, int, int>;

std::map<Place, ForceSeries> series_of(const Problem& all, const Whitening& whitening,
                                       const Vector& residual, const Vector& scales) {
  std::map<Place, ForceSeries> series;
  int block = 0;
  for (int d = 0; d < count_of(all.observations.datasets); ++d) {
    const ObservedDataset& observed = all.observations.datasets[d];
    for (const SegmentBlock& segment : whitening.datasets[d].blocks) {
      const Vector w = mean_forces(whitening.random.blocks[block++], scales, residual);
      const Segment& own = observed.segments[segment.segment];
      int column = 0;
      for (int g = 0; g < count_of(all.hypotheses.forces); ++g) {
        const ForceGroup& group = all.hypotheses.forces[g];
        const int boxes = count_of(group.boxes);
        const Vector f = cosines(boxes) * w.segment(column, boxes) *
                         all.hypotheses.parameters[group.boxes.front()].scale;
        column += boxes;
        ForceSeries& at = series[{d, g, own.trial}];
        for (int k = 0; k < boxes; ++k) {
          const double time = own.start + (k + 0.5) * all.settings.force_box;
          if (time > own.end()) break;
          at.time.push_back(time);
          at.force.push_back(f[k]);
        }
      }
    }
  }
  return series;
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
        tried.push_back({s, i, i + width - 1, std::abs(run_mean(series[s], i, width)) / usual});
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
  return events;
}

std::vector<ForceEvent> force_events(const Problem& all, const Vector& p) {
  NoiseModel noise = estimate_noise(all, p);
  if (!in_windows(all) || !noise.valid()) return {};
  const std::vector<Vector> rows = rows_of(all, noise, noise.at_p);
  const Whitening whitening = whitening_of(all, with_random_effects(all, std::move(noise)));
  const Vector residual = whitening.residual(rows);
  const ScaleEstimate scales = estimated_scales(
      whitening.random, products_of(whitening.random, residual), first_scales(whitening.random),
      all.settings.scale_steps, all.settings.scale_spread);

  std::vector<ForceEvent> events;
  const auto by_place = series_of(all, whitening, residual, scales.scales);
  for (int d = 0; d < count_of(all.observations.datasets); ++d) {
    const ObservedDataset& observed = all.observations.datasets[d];
    for (int g = 0; g < count_of(all.hypotheses.forces); ++g) {
      std::vector<ForceSeries> series;
      std::vector<int> trials;
      for (const auto& [place, own] : by_place) {
        if (std::get<0>(place) != d || std::get<1>(place) != g) continue;
        series.push_back(own);
        trials.push_back(std::get<2>(place));
      }
      std::size_t tried = 0;
      for (const ForceSeries& own : series) tried += own.force.size() * std::size(kWidths);
      const ForceGroup& group = all.hypotheses.forces[g];
      for (const EventRun& run : unusual_runs(series, all.settings.event_level)) {
        const ForceSeries& own = series[run.series];
        double peak = 0.0;
        for (int i = run.first; i <= run.last; ++i)
          if (std::abs(own.force[i]) > std::abs(peak)) peak = own.force[i];
        const double half = 0.5 * all.settings.force_box;
        events.push_back({d, observed.dataset.trials[trials[run.series]].name, group.name,
                          own.time[run.first] - half, own.time[run.last] + half, peak,
                          all.hypotheses.parameters[group.boxes.front()].unit,
                          probability_of(run.deviations, tried)});
      }
    }
  }
  std::stable_sort(events.begin(), events.end(), [](const ForceEvent& a, const ForceEvent& b) {
    return std::tie(a.dataset, a.trial, a.from) < std::tie(b.dataset, b.trial, b.from);
  });
  return events;
}

}  // namespace jaculus::diagnosis
