#pragma once
// Estimates with 95 % intervals.
//   proportion  k of n, p = k/n, z = 1.96: Wilson's score interval,
//               (p + z^2/2n +- z sqrt(p (1-p)/n + z^2/4n^2))/(1 + z^2/n): near 95 % at small n
//               and at 0 of n, where it ends at z^2/(n + z^2).
//   mean        percentile bootstrap over cases, 4000 resamples of a fixed seed; one value alone
//               has no interval.
//   median      order statistics whose binomial tails are within 2.5 %; the ends are infinite where
//               there are too few values.
// Source: Wilson, Journal of the American Statistical Association 22 (1927); Efron,
// Annals of Statistics 7 (1979).

#include <vector>

#include "jaculus/evaluation/case_scores.h"

namespace jaculus::evaluation {

ScoreEstimate proportion(int successes, int trials);
ScoreEstimate mean(const std::vector<double>& values);
ScoreEstimate median(std::vector<double> values);

}  // namespace jaculus::evaluation
