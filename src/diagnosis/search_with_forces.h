#pragma once
// The search among models, and again with pushes and forces of other forms as candidates where
// effects alone don't do.
//
// A cause that no list holds is still a force somewhere that follows something. Left out of the
// comparison, it is drawn by those effects of the catalogue that are most like it: legs whose motors
// cog become dry friction with other gains, which leaves little more than noise. So what such a
// cause may do (place_patterns.h) competes with the catalogue by evidence.

#include "diagnosis/build_problem.h"
#include "diagnosis/remainder/place_patterns.h"

namespace jaculus::diagnosis {

/// What can be judged, and the models that were found for it.
struct Searched {
  Prepared prepared;
  Selection selection;  ///< without models where prepared has reasons, or none can't be fitted
  std::vector<PlacePattern> patterns;  ///< that were candidates
};

/// Effects first. Where the leading model leaves more (fit.h) or needs several effects, under a
/// plan and with one dataset, the search is made again among the effects that it found worth a fit,
/// likely pushes (push_scan.h) and likely patterns (pattern_scan.h). It counts if a model with a
/// push leads it, one that every trial had, that is shorter than half of the motion and that is
/// established; where effects alone left nothing more, if it also takes the place of one of them
/// and clearly leads what has none. Or if a model with patterns leads it, and these are
/// established. What is not is left out of the comparison, and what leads then is asked.
Searched search_with_forces(Prepared prepared, const ProblemBuilder& rebuild,
                            const DiagnoseOptions& options);

/// Whether a leading model's push is established: nothing is lacking beside it, or, though
/// something is, no effects are more probable than none by more than a bare mention, while the
/// push clearly leads the best model without one. What lasts a moment has some
/// half sine that is like it: where effects explain something and forces remain, a push may stand
/// in for what those effects lack.
bool push_established(const Problem& problem, const SearchResult& with_pushes,
                      const SearchResult& effects_alone);

/// Whether a leading model has no patterns, or leads the best one that has none by
/// settings.clear_lead and the logarithm of how many patterns were tried: each was as likely before.
bool pattern_established(const Problem& problem, const SearchResult& search, int tried);

}  // namespace jaculus::diagnosis
