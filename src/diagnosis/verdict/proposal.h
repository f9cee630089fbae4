#pragma once
// Which effects a posterior would have reported, before held-out data accept or refuse them.

#include <string>
#include <vector>

#include "diagnosis/validation/acceptance.h"

namespace jaculus::diagnosis {

enum class Naming {
  nothing,  ///< none or something unknown is more probable than not
  sure,     ///< these effects
  rivals    ///< these effects, among which the data don't decide
};

struct Proposal {
  Naming naming = Naming::nothing;
  std::vector<int> effects;  ///< candidates, most probable first
  const ModelFit* chosen =
      nullptr;  ///< whose held-out gap is judged: the named effects', else the most evident
  std::vector<std::string> reasons;  ///< why fewer than the posterior lists
};

/// In order:
///   nothing  where p(unknown structure) or p(none) exceeds settings.likely;
///   sure     effects of inclusion probability settings.sure or more, where no other reaches
///            settings.likely;
///   sure     the same beside less sure ones that held-out data don't ask for: they may merely bend
///            to the form of the first;
///   rivals   else all that reach settings.listed of what effects explain (sure where that is one
///            alone).
/// Of several sure ones those stay without which held-out data are predicted worse.
Proposal propose(const Posterior& posterior, HeldOutGaps& gaps, const Settings& settings);

}  // namespace jaculus::diagnosis
