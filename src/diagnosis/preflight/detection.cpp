#include "diagnosis/preflight/detection.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diagnosis/selection/posterior.h"

namespace jaculus::diagnosis {
namespace {

/// rms in noise floors of data with this signature about the nominal robot: the root of the mean
/// over channels.
double gap_of(const SignatureSpace& space, const Vector& signature) {
  Vector squares = Vector::Zero(space.channels), rows = Vector::Zero(space.channels);
  const Vector in_rows = space.whitening.in_rows(signature);
  for (Eigen::Index i = 0; i < in_rows.size(); ++i) {
    squares[space.channel[i]] += in_rows[i] * in_rows[i];
    rows[space.channel[i]] += 1.0;
  }
  double mean = 0.0;
  int judged = 0;
  for (int c = 0; c < space.channels; ++c) {
    if (rows[c] == 0.0) continue;
    mean += squares[c] / rows[c];
    ++judged;
  }
  return std::sqrt(1.0 + mean / std::max(1, judged));
}

/// The search for the least share of a departure that is named.
class SizeSearch {
 public:
  SizeSearch(const SignatureSpace& space, const SignatureCurve& curve, const Vector& departure)
      : space_(space), curve_(curve), departure_(departure) {}

  /// Whether the departure times `share` is named. Not named where it can't be simulated.
  [[nodiscard]] bool named(double share) const {
    const Hypotheses& hypotheses = space_.problem->hypotheses;
    const Vector nominal = hypotheses.nominal();
    const Vector p = nominal + share * (departure_ - nominal);
    const auto change = change_of_rows(space_, p);
    if (!change) return false;
    CurvePoint point = nearest(share);
    point.share = share;
    point.u = hypotheses.scaled(curve_.free, p);
    point.signature = signature_of(space_, *change);
    return sight_of(space_, curve_, point).named;
  }

  /// Between a share that is not named and one that is.
  [[nodiscard]] double between(double below, double above) const {
    const Settings& settings = space_.problem->settings;
    for (int i = 0; i < settings.size_steps && above > (1.0 + settings.size_within) * below; ++i) {
      const double middle = std::sqrt(below * above);
      (named(middle) ? above : below) = middle;
    }
    return above;
  }

 private:
  /// The point whose slopes stand in for those at a share.
  [[nodiscard]] CurvePoint nearest(double share) const {
    const auto far = [&](const CurvePoint& p) {
      return p.share > 0.0 ? std::abs(std::log(p.share / share)) : kInfinity;
    };
    return *std::min_element(
        curve_.points.begin(), curve_.points.end(),
        [&](const CurvePoint& a, const CurvePoint& b) { return far(a) < far(b); });
  }

  const SignatureSpace& space_;
  const SignatureCurve& curve_;
  const Vector& departure_;
};

/// Share of a departure that takes its first parameter to its bound, or as far as screening's line
/// search goes where that is farther away.
double farthest_share(const SignatureSpace& space, const FreeParameter& own, double departure) {
  const double bound = departure > 0.0 ? own.bounds.upper : own.bounds.lower;
  const double share = (bound - own.nominal) / departure;
  return std::min(share, std::max(1.0, space.problem->settings.line_search_highest *
                                           std::abs(own.usual_step() / departure)));
}

/// The least share that is named; NaN where none is up to `farthest`.
double least_named(const SignatureSpace& space, const SignatureCurve& curve,
                   const Vector& departure, double farthest) {
  const SizeSearch search(space, curve, departure);
  double below = 0.0, above = kInfinity;
  for (const CurvePoint& point : curve.points) {
    if (point.share <= 0.0 || point.share > farthest) continue;
    const bool named = sight_of(space, curve, point).named;
    if (named) above = std::min(above, point.share);
    if (!named && point.share < above) below = std::max(below, point.share);
  }
  if (std::isinf(above)) {
    if (!search.named(farthest)) return kNaN;
    above = farthest;
  }
  const double factor = 1.0 / space.problem->settings.line_search_lowest;
  for (int i = 0; below <= 0.0 && i < space.problem->settings.size_steps; ++i) {
    if (search.named(above / factor))
      above /= factor;
    else
      below = above / factor;
  }
  return below > 0.0 ? search.between(below, above) : above;
}

}  // namespace

Sight sight_of(const SignatureSpace& space, const SignatureCurve& curve,
               const CurvePoint& at_work) {
  const Settings& settings = space.problem->settings;
  const std::size_t candidates = space.problem->hypotheses.candidates.size();
  const SignatureCurve own{curve.free, curve.bounds, {at_work}, {}, curve.misfits};
  Sight sight;
  sight.log_odds = log_prior(1, candidates, settings) + std::log1p(-settings.prior_lacking) +
                   expected_log_evidence(at_work.signature, own) -
                   log_prior(0, candidates, settings) -
                   expected_log_weight_of_none(space, at_work.signature);
  sight.gap = gap_of(space, at_work.signature);

  const bool plain = sight.gap >= settings.plain_gap;
  const double gain = 0.5 * at_work.signature.squaredNorm();
  const bool small = gain > settings.worth_small_gap &&
                     1.0 < (1.0 - settings.least_improvement_small_gap) * sight.gap;
  sight.named = sight.log_odds >= settings.worth && (plain || small);
  const Vector& g = at_work.signature;
  const double spread = g.cwiseQuotient(space.misfits.variances(g)).norm();
  if ((plain || small) && spread > 0.0)
    sight.chance =
        0.5 * std::erfc((settings.worth - sight.log_odds) / (spread * std::numbers::sqrt2));
  return sight;
}

Detection detect(const SignatureSpace& space, int candidate, const SignatureCurve& curve,
                 const Vector& departure) {
  const Problem& problem = *space.problem;
  const int first = problem.hypotheses.candidates[candidate].parameters.front();
  const FreeParameter& own = problem.hypotheses.parameters[first];
  const double stated = departure[first] - own.nominal;
  Detection out;
  for (const CurvePoint& point : curve.points)
    out.structural = out.structural || point.signature.norm() > problem.settings.structural_zero;
  if (const CurvePoint* point = curve.stated()) out.stated = sight_of(space, curve, *point);
  if (!out.structural || stated == 0.0) return out;

  const double farthest = farthest_share(space, own, stated);
  out.farthest = farthest * stated;
  out.size = least_named(space, curve, departure, farthest) * stated;
  return out;
}

}  // namespace jaculus::diagnosis
