#pragma once
// Cross-validation of fitted models.
//
// Folds: over datasets where there are several, else over trials, else (one trial) over its windows
// in time.
// In a fold the model is fitted on the rest, and held-out segments are judged after their prefix
// (judge.h has the errors e).
// Log density of the judged rows jointly: N(0, W^-1 + A P A^T).
// Gap: square root of the mean over channels of the mean square of e. Shrink = 1 - (after -
// 1)/(before - 1), nothing where before < settings.plain_gap. Its interval is Student's t over the
// folds.

#include <map>
#include <vector>

#include "diagnosis/selection/posterior.h"
#include "diagnosis/selection/search.h"
#include "jaculus/diagnosis/held_out.h"

namespace jaculus::diagnosis {

/// Judges a fitted model (its free parameters refitted in each fold by Gauss-Newton steps from
/// where they are) against the nominal one, in which only nuisances of whole datasets are fitted.
/// Both fits are of `comparison`. Not valid where there are no folds or a simulation fails.
/// `granted`: of tolerance_variances().
HeldOut held_out(const Problem& problem, const Comparison& comparison, const Fit& none,
                 const Fit& model, const std::vector<Vector>& granted);

/// Variance that the builder's tolerances add to held-out errors: rows of a dataset each [unit^2].
std::vector<Vector> tolerance_variances(const Problem& problem, const Comparison& comparison);

/// Held-out gaps of a search's models and of their subsets, each fitted and judged once.
class HeldOutGaps {
 public:
  HeldOutGaps(const Problem& problem, const Comparison& comparison, const Posterior& posterior,
              const Fit& none)
      : problem_(problem),
        comparison_(comparison),
        posterior_(posterior),
        none_(none),
        granted_(tolerance_variances(problem, comparison)) {}
  const HeldOut& of(const ModelFit& model);
  /// The model of `members`, a subset of a model's: as the search fitted it, else fitted from the
  /// first larger one that asks, with the others at nominal.
  const ModelFit& subset(const ModelFit& model, const std::vector<int>& members);

  [[nodiscard]] const Problem& problem() const { return problem_; }
  [[nodiscard]] const Settings& settings() const { return problem_.settings; }
  [[nodiscard]] const Posterior& posterior() const { return posterior_; }

 private:
  const Problem& problem_;
  const Comparison& comparison_;
  const Posterior& posterior_;
  const Fit& none_;
  std::vector<Vector> granted_;
  std::map<std::vector<int>, HeldOut> gaps_;
  std::map<std::vector<int>, ModelFit> subsets_;
};

}  // namespace jaculus::diagnosis
