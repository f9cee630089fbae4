#pragma once
// The verdict: one ordered table of rules, of which the first that applies decides.

#include <string>
#include <vector>

#include "diagnosis/verdict/proposal.h"
#include "jaculus/diagnosis/verdict.h"

namespace jaculus::diagnosis {

/// What a verdict is decided on.
struct VerdictEvidence {
  bool one_trial = false;    ///< of one dataset, whose noise nothing tells
  double none = 0.0;         ///< posterior probability
  double unexplained = 0.0;  ///< posterior probability of something unknown
  Naming naming = Naming::nothing;
  int effects = 0;        ///< how many are proposed
  double lacking = 0.0;   ///< probability that the proposed model lacks forces, given the model
  HeldOut gap;            ///< of the chosen model against the nominal one
  double log_odds = 0.0;  ///< posterior, of effects against none; 0 under a logged input
};

struct VerdictRule {
  const char* name;
  Verdict verdict;
  const char* reason;  ///< for users; empty where the verdict says it all
  bool (*applies)(const VerdictEvidence& evidence, const Settings& settings);
};

/// In order; the last one always applies.
const std::vector<VerdictRule>& verdict_rules();

/// The first rule that applies.
const VerdictRule& decide(const VerdictEvidence& evidence, const Settings& settings);

/// What is said of the nearest model, of these names, where nothing is established, and of the gap
/// that it leaves [noise floors]: below settings.plain_gap nothing need be missing.
std::string nearest_text(const std::string& names, const HeldOut& gap, const Settings& settings);

}  // namespace jaculus::diagnosis
