#pragma once
// The search among models, and again with pushes as candidates where effects alone don't do.

#include "diagnosis/build_problem.h"

namespace jaculus::diagnosis {

/// What can be judged, and the models that were found for it.
struct Searched {
  Prepared prepared;
  Selection selection;  ///< without models where prepared has reasons, or none can't be fitted
};

/// Effects first. Where the leading model leaves more (fit.h) or needs several effects, under a
/// plan and with one dataset, the search is made again among the effects that it found worth a fit
/// and likely pushes (push_scan.h). It counts if a model with a push leads it, one that every trial
/// had, that is shorter than half of the motion and that is established; where effects alone left
/// nothing more, if it also takes the place of one of them and clearly leads what has none.
Searched search_with_pushes(Prepared prepared, const ProblemBuilder& rebuild,
                            const DiagnoseOptions& options);

/// Whether a leading model's push is established: nothing is lacking beside it, or, though
/// something is, no effects are more probable than none by more than a bare mention, while the
/// push clearly leads the best model without one. What lasts a moment has some
/// half sine that is like it: where effects explain something and forces remain, a push may stand
/// in for what those effects lack.
bool push_established(const Problem& problem, const SearchResult& with_pushes,
                      const SearchResult& effects_alone);

}  // namespace jaculus::diagnosis
