#include "diagnosis/noise/noise_model.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "diagnosis/forward/sensitivities.h"
#include "diagnosis/noise/alignment.h"
#include "diagnosis/noise/input_noise.h"
#include "diagnosis/noise/start_curvature.h"

namespace jaculus::diagnosis {
namespace {

StartSlopes start_slopes(const Problem& problem, const NoiseModel& noise) {
  const std::vector<Vector> rows = rows_of(problem, noise, noise.at_p);
  StartSlopes slopes;
  for (const int start : problem.hypotheses.starts) {
    const double step = problem.settings.start_step * problem.hypotheses.parameters[start].scale;
    auto moved = difference_at(problem, noise.alignments, noise.p, rows, start, step);
    slopes.emplace_back();
    if (!moved) continue;
    for (Vector& own : moved->rows) own /= step;
    slopes.back() = std::move(moved->rows);
  }
  return slopes;
}

/// Nuisances and scatter of a dataset; takes the start's curvature off its alignment.
DatasetNoise dataset_noise(const Problem& problem, const Vector& p, int dataset,
                           const std::vector<const Prediction*>& predictions,
                           const StartSlopes& starts, Alignment& alignment) {
  const ObservedDataset& observed = problem.observations.datasets[dataset];
  DatasetNoise noise;
  for (int s = 0; s < count_of(observed.segments); ++s)
    noise.nuisances.push_back(
        segment_nuisances(problem, alignment, *predictions[s], starts, dataset, s));
  noise.channels =
      channel_noise(observed, predictions, alignment, noise.nuisances, problem.settings);

  if (auto changed = without_start_curvature(problem, p, dataset, predictions, noise.nuisances,
                                             noise.channels, alignment)) {
    alignment = std::move(*changed);
    noise.channels =
        channel_noise(observed, predictions, alignment, noise.nuisances, problem.settings);
  }

  std::vector<double> variability;
  for (const ChannelNoise& channel : noise.channels) variability.push_back(channel.variability);
  for (int s = 0; s < count_of(observed.segments); ++s)
    noise.nuisances[s] = with_variability(std::move(noise.nuisances[s]), observed, s, variability,
                                          problem.settings.variability_modes);
  return noise;
}

}  // namespace

NoiseModel estimate_noise(const Problem& problem, const Vector& p,
                          const std::vector<Alignment>& from) {
  const std::vector<ObservedDataset>& datasets = problem.observations.datasets;
  NoiseModel noise;
  noise.p = p;
  noise.at_p = predict_all(problem, p);
  if (!noise.valid()) return noise;

  std::vector<std::vector<const Prediction*>> predictions;
  for (int d = 0; d < count_of(datasets); ++d) {
    predictions.push_back(noise.at_p.segments(datasets[d], d));
    const Alignment first = from.empty() ? unaligned(datasets[d]) : from[d];
    noise.alignments.push_back(align(datasets[d], predictions[d], first, problem.settings));
  }

  const StartSlopes starts = start_slopes(problem, noise);
  for (int d = 0; d < count_of(datasets); ++d)
    noise.datasets.push_back(
        dataset_noise(problem, p, d, predictions[d], starts, noise.alignments[d]));
  return noise;
}

NoiseModel with_random_effects(const Problem& problem, NoiseModel noise) {
  noise.may_lack = true;
  const auto& datasets = problem.observations.datasets;
  if (std::any_of(datasets.begin(), datasets.end(),
                  [](const ObservedDataset& d) { return d.measured_input; }))
    noise.random =
        random_columns(problem, noise.alignments, noise.p, rows_of(problem, noise, noise.at_p));
  for (int d = 0; d < count_of(datasets); ++d) {
    std::map<std::string, InputNoise> input = input_noise(datasets[d], problem.settings);
    for (auto& [joint, own] : input) {
      const auto needed = noise.flicker.find(joint);
      own.flicker = std::min(own.flicker, needed == noise.flicker.end() ? 0.0 : needed->second);
    }
    if (input.empty()) continue;
    for (SegmentNuisances& own : noise.datasets[d].nuisances) {
      const Matrix slopes = noise.random.forces[d].middleRows(own.first, own.count);
      own = with_input_noise(std::move(own), problem.hypotheses, input, slopes);
    }
  }
  return noise;
}

std::vector<Vector> rows_of(const Problem& problem, const NoiseModel& noise,
                            const PredictionSet& predictions) {
  return rows_of(problem, noise.alignments, predictions);
}

}  // namespace jaculus::diagnosis
