#pragma once
// Small questions about truths and predictions that scoring and summing up share.

#include <optional>

#include "jaculus/evaluation/case_scores.h"

namespace jaculus::evaluation {

/// Whether an effect is (one of) the true one(s) or equivalent to it, at the right joint where the
/// truth has one and the prediction says joints.
bool names_truth(const CaseTruth& truth, const NamedEffect& effect);
/// Whether a case has two or three effects of the catalogue.
bool is_several(const CaseTruth& truth);
/// Whether more acts than effects of the catalogue: outside, mixed, legs that part.
bool has_remainder(const CaseTruth& truth);
/// Whether the verdict blames effects of the catalogue.
bool is_alarm(const Prediction& prediction);
/// Whether left and right legs part by 20 mrad or more, though nothing that was put on the robot is
/// one-sided: a cause that no model in the plane holds.
bool is_parted(const CaseTruth& truth);

/// Whether held-out trials tell the true effects from the builder's tolerances: with these effects
/// fitted to the others 5 % less error and 10 nats more log density than with tolerances alone. Not
/// told where no fit could be had; none where it was not asked.
std::optional<bool> is_told(const CaseTruth& truth);
/// Row of the confusion table: the effect, "a + b", "none", "outside" or "event".
std::string truth_label(const CaseTruth& truth);

}  // namespace jaculus::evaluation
