#pragma once
// Which effects a posterior would have reported, before held-out data accept or refuse them.

#include <string>
#include <vector>

#include "diagnosis/validation/acceptance.h"

namespace jaculus::diagnosis {

enum class Naming {
  nothing,  ///< none, or something that no effect explains, is more probable than not
  sure,     ///< these effects
  rivals    ///< one of these effects, among which the data don't decide
};

/// One thing at work: an effect, or one of several that the data can't tell from it.
struct Established {
  int effect = -1;           ///< candidate, the most probable
  std::vector<int> others;   ///< candidates that may stand in its place, most probable first
  double probability = 0.0;  ///< that one of them is at work
};

struct Proposal {
  Naming naming = Naming::nothing;
  std::vector<Established> effects;  ///< most probable first
  ModelFit chosen;  ///< whose held-out gap is judged: the named effects', else the most probable
  std::vector<std::string> reasons;  ///< why fewer than the posterior lists
};

/// In order:
///   nothing  where p(no effect, something lacking) or p(none) exceeds settings.likely;
///   sure     the members of the set whose place is filled more probably than not
///            (settings.likely), by themselves or by others that could stand in (the same set with
///            the member exchanged, of settings.listed of its probability or more), if one is by
///            itself or there are several; the set is the most probable one, or one hardly less
///            probable that predicts held-out data better;
///   rivals   one place that several could fill, or else all that reach settings.listed of what
///            effects explain.
/// Of them those stay without which held-out data are predicted worse.
Proposal propose(HeldOutGaps& gaps);

}  // namespace jaculus::diagnosis
