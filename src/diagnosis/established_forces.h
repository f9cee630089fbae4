#pragma once
// Which forces that are no effects hold: pushes and patterns that lead among the models.

#include "diagnosis/selection/search.h"

namespace jaculus::diagnosis {

/// The most probable of all models, none among them.
const ModelFit& leading(const SearchResult& search);

/// Whether the leading model leads the best one without one of its pushes or patterns, and without
/// any in its place, by the logarithm of how many were tried (of each force that it has), for each
/// was as likely before, and by settings.worth where that one leaves more, so that a force is
/// missing anyhow; by settings.clear_lead where it leaves nothing. Beside as many effects no more
/// is asked: it is not charged as one effect more of the catalogue besides. Which of several forms
/// it is may be open all the same.
bool force_established(const Problem& problem, const SearchResult& search, int candidate,
                       int patterns_tried);

/// Leaves out models with a push that not every trial had, or that is as long as the motion; then
/// what leads with a push or a pattern that is not established, one model after the other. In the
/// end pushes and patterns that don't lead are left out as if they had been no candidates: of a
/// push that holds and a pattern that does as well the more probable one is told.
void leave_out_unfounded(const Problem& with, int patterns_tried, Selection& again);

/// A search and its problem.
struct Led {
  const Problem& problem;
  const Selection& selection;
};

/// Whether what leads with a force predicts trials held out no worse than what led without any
/// (5 %: settings.least_improvement_small_gap), each over what the files state in the space that it
/// was found in, and on all folds that the other is judged on. Evidence of two spaces can't be
/// compared, and within one it rests on how misfits are described and on which models the search
/// came to; what was fitted to a shape that all trials share need not be what made it. Of one trial
/// nothing can be held out: there the evidence stands alone.
bool predicts_as_well(const Led& by_force, const Led& by_effects);

}  // namespace jaculus::diagnosis
