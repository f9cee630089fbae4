#include "diagnosis/selection/relinearise.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "diagnosis/noise/force_bands.h"
#include "diagnosis/noise/input_noise.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kLeastSize = 1e-30;  // of a channel's squares [unit^2], where logarithms end

/// As how many independent values each white row counts: a share of those of a coordinate with a
/// misfit.
Vector independent_values(const Whitening& whitening) {
  Vector values = Vector::Ones(whitening.rows);
  for (const Misfit& misfit : whitening.random.misfits) {
    int rows = 0;
    for (const auto& [first, count] : misfit.spans) rows += count;
    for (const auto& [first, count] : misfit.spans)
      values.segment(first, count).setConstant(misfit.values / rows);
  }
  return values;
}

/// log density of the data and of what a model's parameters u strain, each in its prior scale,
///   -sum n/2 log(r^T r/N) - |u|^2/2,
/// of white residuals scaled back to the data's units, N rows of a channel that count as n
/// independent values, where the size of its noise is not known: a measure, rough, of models that
/// are each told about in a space of their own, in which what fits badly is granted more noise.
double log_density_by_size(const Problem& problem, const Relinearised& told) {
  const Whitening& whitening = told.comparison.whitening;
  const Vector white = whitening.in_rows(told.fit.residual);
  const Vector values = independent_values(whitening);
  double sum = -0.5 * problem.hypotheses.scaled(told.fit.free, told.fit.p).squaredNorm();
  Eigen::Index first = 0;
  for (const DatasetWhitening& own : whitening.datasets) {
    const Vector r = white.segment(first, own.rows).cwiseProduct(own.sigma);
    struct Size {
      double squares = 0.0, values = 0.0;
      int rows = 0;
    };
    std::map<int, Size> sizes;  // by channel
    int row = 0;
    for (const RowSpan& span : own.spans) {
      Size& size = sizes[span.channel];
      size.squares += r.segment(row, span.count).squaredNorm();
      size.values += values.segment(first + row, span.count).sum();
      size.rows += span.count;
      row += span.count;
    }
    for (const auto& [channel, size] : sizes)
      sum -= 0.5 * size.values * std::log(std::max(size.squares / size.rows, kLeastSize));
    first += own.rows;
  }
  return sum;
}

/// The flicker of logged inputs that a model needs: what was granted, and the forces that it lacks
/// beyond.
std::map<std::string, double> flicker_needed(const Problem& problem, const Comparison& comparison,
                                             const Fit& fit) {
  std::map<std::string, double> flicker = comparison.noise.flicker;
  const RandomEffects& random = comparison.whitening.random;
  for (int g = 0; g < random.size(); ++g) {
    const RandomGroup& group = random.groups[g];
    if (group.force < 0) continue;
    const double rms = force_of_band(problem.hypotheses, group, fit.scales[g]);
    const int boxes = count_of(problem.hypotheses.forces[group.force].boxes);
    double& own = flicker[group.name];
    own = std::hypot(own, flicker_of_force(rms, boxes));
  }
  return flicker;
}

}  // namespace

FitOptions short_fit() {
  FitOptions options;
  options.rounds = 1;
  options.effects_follow = true;
  return options;
}

Relinearised relinearise(const Problem& problem, Comparison comparison, Fit fit) {
  return relinearise(problem, std::move(comparison), std::move(fit),
                     problem.settings.relinearisations, {});
}

Relinearised relinearise(const Problem& problem, Comparison comparison, Fit fit, int rounds,
                         FitOptions options) {
  // Under a plan; in windows effects' slopes follow as well, from where all are differenced.
  options.keep_rows = !in_windows(problem);
  for (int round = 0; round < rounds; ++round) {
    NoiseModel again = estimate_noise(problem, fit.simulated, comparison.noise.alignments);
    if (!again.valid()) break;
    again.flicker = flicker_needed(problem, comparison, fit);
    Comparison about = comparison_about(problem, with_random_effects(problem, std::move(again)));

    // A fit goes with the comparison that it was made in: both are taken, or neither.
    const Fit next = fit_model(problem, about.whitening, fit.free, {fit.simulated}, options);
    if (!next.valid) break;
    options.known_rows = next.nuisance_rows;
    comparison = std::move(about);
    const Vector moved =
        problem.hypotheses.scaled(fit.free, next.p) - problem.hypotheses.scaled(fit.free, fit.p);
    fit = next;
    if (moved.size() == 0 || moved.cwiseAbs().maxCoeff() < problem.settings.relinearised_within)
      break;
  }
  return {std::move(comparison), std::move(fit)};
}

std::optional<Relinearised> relinearise_about_none(const Problem& problem, Comparison comparison,
                                                   const FitOptions& options) {
  Fit none = fit_model(problem, comparison.whitening, problem.hypotheses.nuisances(),
                       {comparison.noise.p}, options);
  if (!none.valid) return {};
  return relinearise(problem, std::move(comparison), std::move(none),
                     problem.settings.relinearisations, options);
}

ToldAnew told_anew(const Problem& problem, const Comparison& comparison, const Fit& none,
                   const ModelFit* leader, int rounds, const RowSlopes& near) {
  FitOptions options = in_windows(problem) ? short_fit() : FitOptions{};
  options.known_rows = near;
  const auto about_none = [&] { return relinearise(problem, comparison, none, rounds, options); };
  if (leader == nullptr) {
    Relinearised about = about_none();
    Comparison told = about.comparison;
    return {std::move(told), std::move(about)};
  }

  Relinearised about = relinearise(problem, comparison, leader->fit, rounds, options);
  if (problem.hypotheses.tolerances.empty() || !leaves_more(problem, about.fit))
    return {std::move(about.comparison), {}};
  Relinearised other = about_none();
  const bool leads = log_density_by_size(problem, about) > log_density_by_size(problem, other);
  return {leads ? std::move(about.comparison) : other.comparison, std::move(other)};
}

}  // namespace jaculus::diagnosis
