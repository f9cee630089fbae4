// Scales of parameters that an experiment can't judge, and which it could.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/effects/check.h"

namespace jaculus::effects {
namespace {

// Of a parameter's step, as the length of the change in noises: below one it is less than its own
// standard error.
constexpr double kLeastSignal = 1.0;
// Root mean square of the change in noises. 3000 noises of a good encoder, 1e-3 rad, are half a
// turn: the two motions have nothing in common. Effects that ship move theirs by 0.1 to 600.
constexpr double kMostInfluence = 3000.0;
// Where a better scale is looked for: plain in every sample, and the motion is still the same one.
constexpr double kGoodInfluence = 10.0;
constexpr double kFactor = 2.0;
constexpr int kMostSteps = 24;  // factors of two, 1.7e7 in all
// A scale is a guess, but no one's is off by more than a prefix of units. Where so small a step
// shows that plainly, the motion itself takes any change apart.
constexpr double kPrefix = 1e-3;

/// The influence of a step in one parameter beside the others at their probing steps.
class Probe {
 public:
  Probe(const Effect& effect, const DataOf& data, int parameter)
      : parameter(effect.parameters[parameter]),
        data_(data),
        index_(parameter),
        all_(parameter == 0 ? effect.nominal() : effect.probed()),
        without_(data_at(0.0)) {}

  /// Root mean square [noise] and number of samples; NaN where a simulation does not end.
  [[nodiscard]] std::pair<double, double> influence(double step) const {
    const auto with = data_at(step);
    if (!with || !without_ || with->size() != without_->size()) return {kNaN, 0.0};
    const auto samples = static_cast<double>(with->size());
    return {(*with - *without_).norm() / std::sqrt(samples), samples};
  }

  const EffectParameter& parameter;

 private:
  [[nodiscard]] std::optional<Vector> data_at(double step) const {
    Vector theta = all_;
    theta[index_] =
        std::clamp(parameter.nominal + step, parameter.bounds.lower, parameter.bounds.upper);
    std::string why;
    return data_(theta, why);
  }

  const DataOf& data_;
  int index_;
  Vector all_;
  std::optional<Vector> without_;
};

/// To one digit, as people write scales.
double rounded(double value) {
  const double digit = std::pow(10.0, std::floor(std::log10(value)));
  return std::round(value / digit) * digit;
}

/// The step nearest to `step`, by factors of two, with a good influence; 0 where there is none.
double better_step(const Probe& probe, double step, bool larger) {
  const EffectParameter& p = probe.parameter;
  for (int i = 0; i < kMostSteps; ++i) {
    step *= larger ? kFactor : 1.0 / kFactor;
    if (!p.bounds.contains(p.nominal + step)) return 0.0;
    const double size = probe.influence(step).first;
    if (larger ? size >= kGoodInfluence : size <= kGoodInfluence) return step;
    if (larger && std::isnan(size)) return 0.0;
  }
  return 0.0;
}

std::string hint_for(const Probe& probe) {
  const EffectParameter& p = probe.parameter;
  const double step = p.probed() - p.nominal;
  const auto [size, samples] = probe.influence(step);
  const bool ends = !std::isnan(size);
  const bool small = ends && size * std::sqrt(samples) < kLeastSignal;
  const bool large = !ends || size > kMostInfluence;
  if (!small && !large) return {};

  const double better = std::abs(better_step(probe, step, small));
  const std::string found =
      !ends ? "a simulation with it does not end"
            : fmt::format("it moves the readings by {:.2g} noises (rms of {:.0f} samples)", size,
                          samples);
  const std::string what = small ? "too small to be seen in this experiment"
                                 : "so large that nothing of the motion is left";
  const std::string then = better <= 0.0 ? std::string("within its bounds no other is better")
                           : large && better < kPrefix * std::abs(step)
                               ? fmt::format(
                                     "even {:.1g} {} is plain in it, so that the motion takes "
                                     "any change apart: a shorter one shows more",
                                     better, p.unit)
                               : fmt::format("try about {:g} {}", rounded(better), p.unit);
  return fmt::format("scale {:g} {} of {} is {}: {}; {}", p.scale, p.unit, p.name, what, found,
                     then);
}

}  // namespace

std::vector<std::string> scale_hints(const Effect& effect,
                                     const simulation::Experiment& experiment) {
  const DataOf data = data_of(experiment, effect);
  std::vector<std::string> hints;
  for (int i = 0; i < count_of(effect.parameters); ++i) {
    // Who states a probing step has said that the scale shows nothing.
    if (!std::isnan(effect.parameters[i].probe)) continue;
    std::string hint = hint_for({effect, data, i});
    if (!hint.empty()) hints.push_back(std::move(hint));
  }
  return hints;
}

}  // namespace jaculus::effects
