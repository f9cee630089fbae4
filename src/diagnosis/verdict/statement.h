#pragma once
// The parts of a diagnosis that state a verdict: effects with their parameters, and the ranking.

#include <memory>

#include "diagnosis/validation/held_out.h"
#include "diagnosis/verdict/proposal.h"
#include "diagnosis/verdict/told_events.h"
#include "jaculus/diagnosis/diagnosis.h"

namespace jaculus::diagnosis {

/// What a verdict states of a selection.
struct Statement {
  Verdict verdict = Verdict::insufficient;
  std::string rule;
  std::vector<std::string> reasons;
  std::vector<FoundEffect> effects;
  std::vector<ToldPush> pushes;       ///< of what is proposed those that every trial had
  std::vector<FoundEffect> patterns;  ///< and those that are forces of a stated form
  std::vector<Ranked> ranking;
  HeldOut gap;                       ///< by effects and pushes
  HeldOut gap_by_effects;            ///< by effects alone
  HeldOut gap_with;                  ///< by effects, pushes and patterns
  double lacking_probability = 0.0;  ///< that `model` lacks forces, given that it is at work
  std::vector<LackingForce> lacking;
  std::vector<FittedModel> rivals;
  FittedModel stated, none, model;
  std::vector<Vector> theta;         ///< of `model`'s effects, as Diagnosis has it
  std::vector<Tolerated> tolerated;  ///< of `model`
  Posterior posterior;               ///< as held-out data leave it
};

/// Judges a selection by held-out data and states what follows. `one_trial`: nothing tells the
/// noise.
Statement state_verdict(const Problem& problem, const Selection& selection, bool one_trial);

}  // namespace jaculus::diagnosis
