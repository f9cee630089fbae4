#pragma once
// Small questions about truths and answers that marking and summing up share.

#include "jaculus/evaluation/score.h"

namespace jaculus::evaluation {

/// Whether an effect is (one of) the true one(s) or equivalent to it.
bool names_truth(const SealedTruth& truth, const std::string& effect);
/// Whether the verdict blames effects of the catalogue.
bool is_alarm(const CaseAnswer& answer);
/// Row of the confusion table: the effect, "a + b", "none" or "outside".
std::string truth_label(const SealedTruth& truth);

}  // namespace jaculus::evaluation
