#pragma once
// Small questions about truths and predictions that scoring and summing up share.

#include "jaculus/evaluation/case_scores.h"

namespace jaculus::evaluation {

/// Whether an effect is (one of) the true one(s) or equivalent to it.
bool names_truth(const CaseTruth& truth, const std::string& effect);
/// Whether the verdict blames effects of the catalogue.
bool is_alarm(const Prediction& prediction);
/// Whether left and right legs part by 20 mrad or more, though nothing that was put on the robot is
/// one-sided: a cause that no model in the plane holds.
bool is_parted(const CaseTruth& truth);
/// Row of the confusion table: the effect, "a + b", "none" or "outside".
std::string truth_label(const CaseTruth& truth);

}  // namespace jaculus::evaluation
