#pragma once
// What is no effect: pushes that lead among the models (push_scan.h) and forces of a stated form
// (pattern_scan.h) are told as what is left, pushes as events too. A verdict is about the effects,
// but a push that every trial had is no accident: it is beyond a builder's tolerances, so that
// beside it the answer is never that nothing is.

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

/// A verdict on all that is proposed, about the effects: a pattern or a push is what they leave.
Verdict about_effects(Verdict verdict, const PartedProposal& proposal);

/// The ranking with rows that differ in events and patterns alone put together: their probabilities
/// added, the rest that of the most probable. These without effects are `unexplained`.
std::vector<Ranked> ranked_by_effects(const Problem& problem, const std::vector<Ranked>& ranking);

/// A push as found: its parameters are push_effect's.
ForceEvent event_of(const Problem& problem, const FoundEffect& found);

/// A push that every trial had, with what it explains.
struct ToldPush {
  FoundEffect found;
  ForceEvent event;
};

}  // namespace jaculus::diagnosis
