#pragma once
// What is no effect: pushes that lead among the models (push_scan.h) are told as events, and forces
// of a stated form (pattern_scan.h) as what is left. A verdict is about the effects.

#include "diagnosis/verdict/proposal.h"
#include "jaculus/diagnosis/diagnosis.h"

namespace jaculus::diagnosis {

/// A proposal with what it proposes in three parts.
struct PartedProposal {
  Naming naming = Naming::nothing;
  std::vector<Established> effects;  ///< where an effect and something else are rivals, both
  std::vector<Established> events;
  std::vector<Established> patterns;

  /// Whether anything is proposed that is no effect.
  [[nodiscard]] bool beyond_effects() const { return !events.empty() || !patterns.empty(); }
};
PartedProposal parted(const Problem& problem, const Proposal& proposal);

/// A verdict on all that is proposed, about the effects: a pattern is what they leave.
Verdict about_effects(Verdict verdict, const PartedProposal& proposal);

/// The ranking with rows that differ in events and patterns alone put together: their probabilities
/// added, the rest that of the most probable. A pattern without effects is `unexplained`.
std::vector<Ranked> ranked_by_effects(const Problem& problem, const std::vector<Ranked>& ranking);

/// A push as found: its parameters are push_effect's.
ForceEvent event_of(const Problem& problem, int candidate, const FoundEffect& found);

}  // namespace jaculus::diagnosis
