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

/// A goal of the scoring, by the key of Metrics::by.
struct Goal {
  std::string key;
  bool at_least = true;
  double target = 0.0;
};
const std::vector<Goal>& goals();

/// A baseline names one effect and knows no probability. It is given its own accuracy over the
/// other cases, (hits + 1)/(others + 2), for the effect that it names, and the rest evenly for the
/// other effects it ranked: the best constant confidence it could have.
void give_confidence(const std::vector<CaseTruth>& truths, std::vector<Prediction>& predictions);

}  // namespace jaculus::evaluation
