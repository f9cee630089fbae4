#pragma once
// One answerer's marks, summed up.

#include "jaculus/evaluation/score.h"

namespace jaculus::evaluation {

/// Gap from which on the goals hold [noise floors].
inline constexpr double kPlainGap = 3.0;

ScoreSheet make_sheet(const std::string& answerer, const std::vector<SealedTruth>& truths,
                      const std::vector<CaseAnswer>& answers);

/// A goal of the scoring, by the key of ScoreSheet::by.
struct Goal {
  std::string key;
  bool at_least = true;
  double target = 0.0;
};
const std::vector<Goal>& goals();

/// A baseline names one effect and knows no probability. It is given its own accuracy over the other cases, (hits + 1)/(others + 2),
/// for the effect that it names, and the rest evenly for the other effects it ranked: the best constant confidence it could have.
void give_confidence(const std::vector<SealedTruth>& truths, std::vector<CaseAnswer>& answers);

}  // namespace jaculus::evaluation
