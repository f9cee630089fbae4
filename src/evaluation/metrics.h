#pragma once
// One predictor's scores, summed up.

#include "jaculus/evaluation/case_scores.h"

namespace jaculus::evaluation {

/// Gap from which on the goals hold [noise floors].
inline constexpr double kPlainGap = 3.0;
/// Probability from which on a wrong statement counts as confident: what somebody would act on.
inline constexpr double kConfident = 0.8;

Metrics compute_metrics(const std::string& predictor, const std::vector<CaseTruth>& truths,
                        const std::vector<Prediction>& predictions);

/// Bins of stated probability, what is right in each, and their mean distance with the interval of
/// a bootstrap over cases (metrics.by, "calibration error").
void add_reliability(const std::vector<Prediction>& predictions, Metrics& metrics);

/// Gives statements without a probability one by their smoothed frequency: of the other cases with
/// a statement of that sort (an effect, or none), the share that is right, (right + 1)/(others +
/// 2), and the rest evenly for whatever else it ranked. The best constant confidence it could have.
/// Insufficient stays without: it scores at the floor.
void give_confidence(const std::vector<CaseTruth>& truths, std::vector<Prediction>& predictions);

}  // namespace jaculus::evaluation
