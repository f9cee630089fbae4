#pragma once
// Windows of a log in which something acted once: a push, a hand, a cable that caught.
//
// Missing forces of a window are part of the model, of one usual size in all windows
// (noise/random_effects.h). A push is no such force: it makes the size large for all of them, by
// which evidence for every effect falls, and what effects take over of it bends names and values.
// So about what a first search found, pushes are told over all of every trial (remainder/events.h),
// and windows are cut beside those that one trial alone had. What every trial has at the same time
// is no accident and stays.

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/build_problem.h"

namespace jaculus::diagnosis {

struct BesidePushes {
  Observations observations;       ///< windows cut beside pushes
  std::vector<std::string> notes;  ///< a sentence a push
};
/// Nothing where no window of the problem holds a push of one trial. `about`: the model that led,
/// in the problem's parameters.
std::optional<BesidePushes> beside_pushes(const Problem& problem, const ModelFit& about,
                                          const DiagnoseOptions& options);

}  // namespace jaculus::diagnosis
