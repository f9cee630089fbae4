#pragma once
// Sets of candidates next to a set: what a search tries from where it stands. Members rise.

#include <vector>

#include "diagnosis/forward/hypotheses.h"

namespace jaculus::diagnosis {

using Members = std::vector<int>;  ///< candidates, rising

/// Every set of one or two more candidates than `set`, of at most `largest`.
std::vector<Members> larger_sets(const Members& set, int candidates, int largest);
/// `set` with one member exchanged for each other candidate.
std::vector<Members> exchanged_sets(const Members& set, int dropped, int candidates);
/// The set with one member more, with one less.
Members with_member(Members set, int c);
Members without_one(Members set, int c);
/// The set with one member exchanged.
Members exchanged(Members set, int from, int to);
/// Whether a set holds an effect of all joints and the same of one of them: what they can do
/// together, one for each joint can.
bool holds_twice(const Hypotheses& hypotheses, const Members& set);
/// Whether a candidate is another with parameters more, so that it stands beside that one as no
/// other cause.
bool extends(const Hypotheses& hypotheses, int candidate, int other);
/// `set` with an effect that joints share, of one value, given to each of them with its own, and
/// the other way round.
std::vector<Members> parted_sets(const Hypotheses& hypotheses, const Members& set, int largest);
/// `set` with a member that is another candidate with parameters more in that one's place.
std::vector<Members> plainer_sets(const Hypotheses& hypotheses, const Members& set);

}  // namespace jaculus::diagnosis
