#pragma once
// Which forces that are no effects hold: pushes and patterns that lead among the models.

#include "diagnosis/selection/search.h"

namespace jaculus::diagnosis {

/// The most probable of all models, none among them.
const ModelFit& leading(const SearchResult& search);

/// What was found without pushes and patterns.
struct EffectsAlone {
  const Problem& problem;
  const SearchResult& search;
};

/// Whether a leading model's push is established: nothing is lacking beside it, or, though
/// something is, no effects are more probable than none by more than a bare mention, while the
/// push clearly leads the best model of effects alone. What lasts a moment has some
/// half sine that is like it: where effects explain something and forces remain, a push may stand
/// in for what those effects lack.
bool push_established(const Problem& problem, const SearchResult& with_pushes,
                      const SearchResult& effects_alone);

/// Whether the leading model leads the best one without one of its patterns, and without any in
/// its place, by the logarithm of how many patterns were tried, for each was as likely before, and
/// by settings.worth where that one leaves more, so that a force is missing anyhow; by
/// settings.clear_lead where it leaves nothing. Which of several forms it is may be open all the
/// same.
bool pattern_established(const Problem& problem, const SearchResult& search, int pattern,
                         int tried);

/// Leaves out models with a push that not every trial had, or that is as long as half of the
/// motion; then what leads and doesn't hold, one after the other, as if it had been no candidate: a
/// push that is not established, or that takes nobody's place where effects alone left nothing
/// more; a pattern that is not established. What leads then is asked in turn. In the end what
/// doesn't lead is left out too: of a push that holds and a pattern that does as well the more
/// probable one is told.
void leave_out_unfounded(const Problem& with, const EffectsAlone& alone, int tried,
                         Selection& again);

}  // namespace jaculus::diagnosis
