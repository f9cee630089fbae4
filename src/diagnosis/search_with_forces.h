#pragma once
// The search among models, and again with pushes and forces of other forms as candidates where
// effects alone don't do.
//
// A cause that no list holds is still a force somewhere that follows something. Left out of the
// comparison, it is drawn by those effects of the catalogue that are most like it: legs whose
// motors cog become dry friction with other gains, which leaves little more than noise. So what
// such a cause may do (place_patterns.h) competes with the catalogue by evidence.

#include "diagnosis/build_problem.h"
#include "diagnosis/remainder/place_patterns.h"

namespace jaculus::diagnosis {

/// What can be judged, and the models that were found for it.
struct Searched {
  Prepared prepared;
  Selection selection;  ///< without models where prepared has reasons, or none can't be fitted
  std::vector<PlacePattern> patterns;  ///< those of the leading model
};

/// Effects first. Where the leading model leaves more (fit.h) or needs several effects, under a
/// plan and with one dataset, the search is made again with likely pushes (push_scan.h) and likely
/// patterns (pattern_scan.h) beside the whole catalogue, and with the models that led before. It
/// counts if a model with some leads it that hold (established_forces.h).
Searched search_with_forces(Prepared prepared, const ProblemBuilder& rebuild,
                            const DiagnoseOptions& options);

}  // namespace jaculus::diagnosis
