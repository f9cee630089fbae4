#pragma once
// From which size on an effect would be seen.
//
// Structurally: an effect that changes nothing in exact data, at no size that was tried, is seen by
// no sensor of the experiment. Statistically: it is seen where a diagnosis would name it, on the
// mean over the data's noise:
//   log odds   log prior_A + E log Z_A - log prior_none - E log Z_none >= settings.worth,
//              none complete or with forces that it lacks (expected_evidence.h)
//   gap        g^2 = 1 + mean over channels of the mean square of the signature, in noise floors
//              once the robot's tolerances are fitted, must reach settings.plain_gap, or else E log
//              gain = |g|^2/2 must pass worth_small_gap and 1/g fall by least_improvement_small_gap
// (rules `small gap`, `none probable` of verdict/rules.h). The size is bisected on signatures that
// are simulated at each size, for effects with a threshold have no slope.

#include "diagnosis/preflight/expected_evidence.h"

namespace jaculus::diagnosis {

/// How data with an effect at work would look to a diagnosis.
struct Sight {
  double log_odds = -kInfinity;  ///< against none, prior odds included
  double gap = 1.0;              ///< [noise floors]
  bool named = false;            ///< whether a diagnosis would name it, on the mean
  /// Share of the data that would: noise e adds g . e to the log odds, of deviation |g|.
  double chance = 0.0;
};
/// `curve`: the effect's own, a point of it at work.
Sight sight_of(const SignatureSpace& space, const SignatureCurve& curve, const CurvePoint& at_work);

/// What is seen of one candidate.
struct Detection {
  bool structural = false;  ///< whether anything changes in exact data
  double size = kNaN;      ///< least departure of the first parameter that is named, signed [unit];
                           ///< NaN: none within reach
  double farthest = kNaN;  ///< departure that was tried at most, signed [unit]
  Sight stated;            ///< at the stated departure
};
/// `departure`: stated_departure(); `curve` along it.
Detection detect(const SignatureSpace& space, int candidate, const SignatureCurve& curve,
                 const Vector& departure);

}  // namespace jaculus::diagnosis
