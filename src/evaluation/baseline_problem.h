#pragma once
// What all baselines start from: the diagnosis' own problem, its noise, and the nominal robot with
// the nuisances of whole datasets fitted.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/build_problem.h"
#include "diagnosis/selection/screen.h"
#include "jaculus/evaluation/predictions.h"

namespace jaculus::evaluation {

struct BaselineProblem {
  std::shared_ptr<const diagnosis::Problem> problem;
  diagnosis::PlantForward forward;
  diagnosis::NoiseModel noise;  ///< about `base`
  diagnosis::Whitening whitening;
  diagnosis::Fit base;  ///< nominal, nuisances fitted

  /// Whether more is left of the data than 1.3 times the noise, mean square.
  [[nodiscard]] bool has_gap() const;
};

/// Nothing where the data are insufficient or the nominal model can't be fitted.
std::optional<BaselineProblem> baseline_problem(const std::vector<trajectory::Dataset>& datasets);

/// "none", or an effect; all that can be said is ranked, with probability 0.
Prediction statement(const BaselineProblem& ready, const std::string& effect);

/// Names the candidate of the largest value, NaN aside; none where there is no gap.
Prediction answer_by(const BaselineProblem& ready, const std::vector<double>& value);

}  // namespace jaculus::evaluation
