#pragma once
// The search among models, and again with pushes as candidates where effects alone don't do.

#include "diagnosis/build_problem.h"

namespace jaculus::diagnosis {

/// What can be judged, and the models that were found for it.
struct Searched {
  Prepared prepared;
  Selection selection;  ///< without models where prepared has reasons, or none can't be fitted
};

/// Effects first. Where the leading model leaves more (fit.h), under a plan and with one dataset,
/// the search is made again among the effects that it found worth a fit and likely pushes
/// (push_scan.h). It counts if a model with a push leads it, one that every trial had and that is
/// shorter than half of the motion, and leaves no misfit: what lasts a moment has some half sine
/// that is like it, but only of a push does nothing else remain.
Searched search_with_pushes(Prepared prepared, const ProblemBuilder& rebuild,
                            const DiagnoseOptions& options);

}  // namespace jaculus::diagnosis
