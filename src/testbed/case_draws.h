#pragma once
// One blinded case: which effects, on which experiments, how strong, played.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/testbed/blinded_cases.h"
#include "testbed/draws.h"

namespace jaculus::testbed {

/// Effects that may be drawn, each list by what a name is before "@": one entry is drawn, then one
/// of its names.
using Families = std::vector<std::vector<std::string>>;

struct Pool {
  Families catalogue, outside, events;
  std::map<std::string, std::string> components;  ///< where each acts
};

/// InputError for a withheld name that no robot has.
Pool pool_of(const std::vector<Stage>& stages, const std::vector<std::string>& withheld);

/// What cases are drawn on: experiments, what each effect shows on them, effects to draw.
struct Grounds {
  std::vector<Stage> stages;
  std::vector<Signatures> signatures;
  Pool pool;
  bool clutter = false;
};

/// What is to be drawn.
struct CaseKind {
  std::string name;    ///< as CaseLabel::kind
  bool group = false;  ///< several datasets
};

struct MadeCase {
  CaseLabel label;
  std::vector<trajectory::Dataset> datasets;
};

/// InputError where nothing of this kind can be drawn at all.
void check_kind(const CaseKind& kind, const Grounds& grounds);

/// Names of the effects that are to be in a case, drawn before anything else. Those of a case act
/// on different parts; of a mixed case the second is from outside. Misuse: a kind that check_kind()
/// refuses.
std::vector<std::string> draw_effects(Random& random, const CaseKind& kind, const Grounds& grounds);

/// The stages of a case, all of one robot, the first of them that on which strengths are drawn.
std::vector<int> draw_stages(Random& random, const CaseKind& kind, const Grounds& grounds,
                             const std::vector<std::string>& effects);

/// What a push of these numbers is to a diagnosis, within commands that last `end` [s].
TrueEvent event_of(const Dose& dose, double end);

/// Draws until a case comes out that shows; std::runtime_error where none does. Draws that are left
/// out because left and right legs diverge are listed in the label.
MadeCase draw_case(const CaseKind& kind, std::uint64_t seed, const Grounds& grounds);

}  // namespace jaculus::testbed
