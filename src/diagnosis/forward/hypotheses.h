#pragma once
// The parameters that a diagnosis may move, as a flat vector, and the candidates that free some of
// them. The statistics know nothing of robots: they see this list and a forward model (problem.h).
//
//   p = [effects' parameters | unknown gains and feed-forward scales | start offsets |
//        builder's tolerances | forces that the plant lacks]
// Effects' parameters are zero-cost at nominal. Unknown gains, with wide priors, and tolerances, by
// what the builder vouches for, are nuisances: every model fits its own. A tolerance alone may move
// a robot so far (a landing, two seconds of free swing) that slopes at the files' own values say
// nothing of it. Start offsets are free in every segment, forces are random effects of a dataset
// (noise/random_effects.h): these two enter through their sensitivities alone.

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/effects/effect.h"

namespace jaculus::diagnosis {

struct FreeParameter {
  std::string owner;  ///< effect, or "nuisance", "start", "tolerance", "force"
  std::string name;
  std::string unit;
  double nominal = 0.0;
  double scale = 1.0;  ///< standard deviation of the normal prior about nominal
  Bounds bounds;
  double probe = kNaN;  ///< signed step from nominal whose influence is plain; NaN: one scale

  [[nodiscard]] double usual_step() const { return std::isnan(probe) ? scale : probe; }
  /// A value moved by so many prior scales, as far as the bounds let it go.
  [[nodiscard]] double moved(double value, double scales) const {
    return std::clamp(value + scales * scale, bounds.lower, bounds.upper);
  }
  /// Of u = (p - nominal)/scale.
  [[nodiscard]] Bounds scaled_bounds() const {
    return {(bounds.lower - nominal) / scale, (bounds.upper - nominal) / scale};
  }
  /// Nominal is an end of the range, so that the prior is the half of a normal one.
  [[nodiscard]] bool one_sided() const {
    return nominal <= bounds.lower || nominal >= bounds.upper;
  }
};

struct Candidate {
  std::string name;
  effects::Component where = effects::Component::body;
  std::vector<int> parameters;              ///< indices of its parameters
  const effects::Effect* effect = nullptr;  ///< null for models that are no plant

  /// Its own parameters out of all, in its effect's order.
  [[nodiscard]] Vector theta(const Vector& p) const;
  /// Whether it is a force that acted once and is told as an event, no effect of the robot.
  [[nodiscard]] bool is_event() const;
  [[nodiscard]] bool is_pattern() const;
  /// A push or a pattern: a force that no effect is.
  [[nodiscard]] bool beyond_effects() const { return is_event() || is_pattern(); }
};

/// The generalised force along one coordinate that the plant may lack: constant over boxes of time
/// from a segment's start on, settings.force_box each, as far as forces are sought (windows of a
/// log; else plans). A scale of 1 is a force that counts as large there.
struct ForceGroup {
  std::string name;        ///< "body x", "elbow"
  std::vector<int> boxes;  ///< indices of their parameters, in order of time
};

/// Its name; of a pattern what it does.
std::string told_name(const Candidate& candidate);

struct Hypotheses {
  /// of the candidates, with this robot's sizes; they point into it
  std::shared_ptr<const std::vector<effects::Effect>> effects;
  std::vector<FreeParameter> parameters;
  std::vector<Candidate> candidates;
  std::vector<int> gains;       ///< indices, of factors and clocks that files don't state
  std::vector<int> starts;      ///< indices; free in every segment
  std::vector<int> tolerances;  ///< indices, in deviations that the builder vouches for
  std::vector<ForceGroup> forces;

  [[nodiscard]] Vector nominal() const;
  /// u = (p - nominal)/scale of the parameters `free`, within their bounds.
  [[nodiscard]] Vector scaled(const std::vector<int>& free, const Vector& p) const;
  /// p with the parameters `free` set from u, within their bounds.
  [[nodiscard]] Vector unscaled(const std::vector<int>& free, const Vector& u, Vector p) const;
  /// p, and p with one unknown gain or clock a deviation more or less: what moves a motion most has
  /// valleys.
  [[nodiscard]] std::vector<Vector> gain_starts(const Vector& p) const;
  /// Unknown gains, then tolerances: what every model fits.
  [[nodiscard]] std::vector<int> nuisances() const;
  /// Indices of the parameters of some candidates, in the order of these.
  [[nodiscard]] std::vector<int> parameters_of(const std::vector<int>& members) const;
  /// Indices of the parameters that a model of some candidates frees: theirs, then the nuisances.
  [[nodiscard]] std::vector<int> freed_by(const std::vector<int>& members) const;
  /// p with the nuisances of another point; with the parameters of some candidates at nominal.
  [[nodiscard]] Vector with_nuisances_of(Vector p, const Vector& other) const;
  [[nodiscard]] Vector without_effects(Vector p, const std::vector<int>& members) const;
  /// Whether one of some candidates is an event.
  [[nodiscard]] bool has_event(const std::vector<int>& members) const;
  /// Whether some of these, or of all candidates, are no effects.
  [[nodiscard]] bool beyond_effects(const std::vector<int>& members) const;
  [[nodiscard]] bool beyond_effects() const;
  /// Copies of the effects of some candidates, those left out that have none.
  [[nodiscard]] std::vector<effects::Effect> effects_of(const std::vector<int>& members) const;
  [[nodiscard]] int candidate(const std::string& name) const;  ///< index, -1 where there is none
};

}  // namespace jaculus::diagnosis
