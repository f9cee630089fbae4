#pragma once
// Cross-validation of fitted models.
//
// Folds: over datasets where there are several, else over trials, else (one trial) over its windows
// in time.
// In a fold the model is fitted on the rest, and held-out segments are judged after their prefix
// (judge.h has the errors e).
// Log density of the judged rows jointly: N(0, W^-1 + A P A^T), with B S B^T of judge.h where folds
// are over datasets.
// Gap: square root of the mean over channels of the mean square of e. Shrink = 1 - (after -
// 1)/(before - 1), nothing where before < settings.plain_gap. Its interval is Student's t over the
// folds.

#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "diagnosis/selection/posterior.h"
#include "diagnosis/selection/search.h"
#include "diagnosis/validation/folds.h"
#include "diagnosis/validation/judge.h"
#include "jaculus/diagnosis/held_out.h"

namespace jaculus::diagnosis {

/// Errors of a fitted model on what each fold leaves out; nothing where a fold could not be judged.
struct JudgedFit {
  std::vector<std::optional<Errors>> folds;
};
/// What the datasets of each fold leave open of tolerances and gains (judge.h, `open`): a fold
/// each, a dataset each. Nothing where folds are not over datasets, or where no simulation tells
/// it.
using OpenRows = std::vector<std::vector<Matrix>>;
/// `none`: the fit of `comparison` without effects.
OpenRows open_rows(const Problem& problem, const Comparison& comparison, const Folds& folds,
                   const Fit& none);

/// Free parameters are refitted in each fold: by Gauss-Newton steps with the slopes of the fit,
/// which is of `comparison`; to other datasets under a plan anew (fit_to_others.h).
JudgedFit judge_fit(const Problem& problem, const Comparison& comparison, const Folds& folds,
                    const Fit& fit, const OpenRows& open);

/// A model against the one that files state, and against that with tolerances fitted (`none`). Not
/// valid where no fold was judged of all three.
HeldOut held_out(const Problem& problem, const Folds& folds, const JudgedFit& stated,
                 const JudgedFit& none, const JudgedFit& model);

/// The model that the files state: unknown gains fitted, everything else at its nominal value.
Fit as_stated(const Problem& problem, const Whitening& whitening);

/// Whether a held-out error is no more than another, within settings.least_improvement_small_gap.
bool no_worse(double after, double before, const Settings& settings);

/// Held-out gaps of a search's models and of their subsets, each fitted and judged once.
class HeldOutGaps {
 public:
  /// `stated`, `none`: fits of `comparison`, of as_stated() and of no effect.
  HeldOutGaps(const Problem& problem, const Comparison& comparison, const Posterior& posterior,
              const Fit& stated, const Fit& none);
  const HeldOut& of(const ModelFit& model);
  /// The model of `members`, a subset of a model's, with the tolerances of the first larger one
  /// that asks and the others at nominal: what a member does is not what tolerances could do in its
  /// place.
  const ModelFit& subset(const ModelFit& model, const std::vector<int>& members);
  /// The same of all its members too: tolerances stay, what is left can be set beside it.
  const ModelFit& held(const ModelFit& model, const std::vector<int>& members);

  /// A subset with tolerances of its own, simulated: as the search fitted it, else fitted from
  /// there. Where that fails, as it was.
  const ModelFit& fitted(const ModelFit& held);

  [[nodiscard]] const Problem& problem() const { return problem_; }
  [[nodiscard]] const Settings& settings() const { return problem_.settings; }
  [[nodiscard]] const Posterior& posterior() const { return posterior_; }

 private:
  const Problem& problem_;
  const Comparison& comparison_;
  const Posterior& posterior_;
  Folds folds_;
  OpenRows open_;
  JudgedFit stated_, none_;
  /// Candidates and free parameters: a set is judged with tolerances of its own and with a larger
  /// set's.
  using Key = std::pair<std::vector<int>, std::vector<int>>;
  std::map<Key, HeldOut> gaps_;
  std::map<std::vector<int>, ModelFit> subsets_, fitted_;
};

}  // namespace jaculus::diagnosis
