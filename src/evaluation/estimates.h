#pragma once
// Estimates with 95 % intervals.
//   proportion  k of n: Clopper-Pearson, [B(0.025; k, n-k+1), B(0.975; k+1, n-k)] with quantiles B of the beta distribution:
//               covers at 95 % or more whatever n, so it can be trusted at 0 of 60.
//   mean        percentile bootstrap over cases, 4000 resamples of a fixed seed; one value alone has no interval.
//   median      order statistics whose binomial tails are within 2.5 %; the ends are infinite where there are too few values.
// Source: Clopper and Pearson, Biometrika 26 (1934); Efron, Annals of Statistics 7 (1979).

#include <vector>

#include "jaculus/evaluation/score.h"

namespace jaculus::evaluation {

ScoreEstimate proportion(int successes, int trials);
ScoreEstimate mean(const std::vector<double>& values);
ScoreEstimate median(std::vector<double> values);

}  // namespace jaculus::evaluation
