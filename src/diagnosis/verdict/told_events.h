#pragma once
// What happened once is no property of a robot: pushes that lead among the models (push_scan.h) are
// told as events, and a verdict is about what is left.

#include "diagnosis/verdict/proposal.h"
#include "jaculus/diagnosis/diagnosis.h"

namespace jaculus::diagnosis {

/// A proposal with what it proposes in two parts.
struct PartedProposal {
  Naming naming = Naming::nothing;
  std::vector<Established> effects;  ///< where an effect and an event are rivals, both
  std::vector<Established> events;
};
PartedProposal parted(const Problem& problem, const Proposal& proposal);

/// A verdict on some events and on `effects` effects, about the effects.
Verdict about_effects(Verdict verdict, const PartedProposal& proposal);

/// The ranking with rows that differ in events alone put together: their probabilities added, the
/// rest that of the most probable.
std::vector<Ranked> ranked_without_events(const Problem& problem,
                                          const std::vector<Ranked>& ranking);

/// A push as found: its parameters are push_effect's.
ForceEvent event_of(const Problem& problem, int candidate, const FoundEffect& found);

}  // namespace jaculus::diagnosis
