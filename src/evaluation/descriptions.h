#pragma once
// Descriptions of what is left against what is there: for every kind of the generator that no
// catalogue holds, where it is and what it follows. The table was fixed before any answer was
// looked at; docs/measures.md has it with the measures.
//
// Of a case with such a kind the description's leading part is judged, the one of largest weight:
//   place    the leading part's class of place (joint, body, feet, sensor, commands) is one of the
//            kind's, at one of the limbs where the kind acts
//   family   1 where the leading part is at a right place and follows what the kind does; 1/k where
//            another of the k parts that are said does; else 0
// An answer without a description is wrong in both. Of kinds that are pushes the parts are the
// events that are said.

#include <string>
#include <vector>

#include "jaculus/evaluation/case_scores.h"

namespace jaculus::evaluation {

/// What a right description of one kind says.
struct RightDescription {
  std::string kind;                   ///< "tether"; a push at a joint: "joint_push"
  std::vector<std::string> places;    ///< "joint", "body", "feet", "sensor", "commands"
  std::string limb;                   ///< joints and feet of these names: "rear", "tail",
                                      ///< "!tail": all but these; empty: any
  std::vector<std::string> families;  ///< names of regressors, or "event"
  std::string reason;
};
const std::vector<RightDescription>& right_descriptions();
/// Of a generator's name, "joint_push@elbow" as "joint_push"; null where it is no such kind.
const RightDescription* right_description(const std::string& name);

/// The kind of an outside or mixed case that no catalogue holds; null in other cases.
const RightDescription* described_kind(const CaseTruth& truth);
/// Whether the leading part is at a right place.
bool place_right(const RightDescription& right, const Prediction& prediction);
/// Credit of families.
double family_credit(const RightDescription& right, const Prediction& prediction);

}  // namespace jaculus::evaluation
