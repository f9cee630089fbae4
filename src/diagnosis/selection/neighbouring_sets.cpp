#include "diagnosis/selection/neighbouring_sets.h"

#include <algorithm>
#include <string_view>
#include <utility>

namespace jaculus::diagnosis {
namespace {

/// The effect of which a candidate is one joint's, its own name where it is no joint's.
std::string_view shared_name(const Candidate& candidate) {
  return std::string_view(candidate.name).substr(0, candidate.name.find('@'));
}

/// The candidates that are one joint's part of a shared effect.
Members parts_of(const Hypotheses& hypotheses, int shared) {
  const std::string& name = hypotheses.candidates[shared].name;
  Members parts;
  for (int d = 0; d < count_of(hypotheses.candidates); ++d) {
    const Candidate& own = hypotheses.candidates[d];
    if (d != shared && shared_name(own) == name && own.name != name) parts.push_back(d);
  }
  return parts;
}

}  // namespace

std::vector<Members> larger_sets(const Members& set, int candidates, int largest) {
  std::vector<Members> out;
  if (count_of(set) >= largest) return out;
  for (int c = 0; c < candidates; ++c) {
    if (std::binary_search(set.begin(), set.end(), c)) continue;
    const Members one = with_member(set, c);
    out.push_back(one);
    for (int d = c + 1; d < candidates && count_of(one) < largest; ++d)
      if (!std::binary_search(set.begin(), set.end(), d)) out.push_back(with_member(one, d));
  }
  return out;
}

Members with_member(Members set, int c) {
  set.insert(std::upper_bound(set.begin(), set.end(), c), c);
  return set;
}

Members without_one(Members set, int c) {
  std::erase(set, c);
  return set;
}

Members exchanged(Members set, int from, int to) {
  return with_member(without_one(std::move(set), from), to);
}

std::vector<Members> exchanged_sets(const Members& set, int dropped, int candidates) {
  std::vector<Members> out;
  for (int c = 0; c < candidates; ++c)
    if (!std::binary_search(set.begin(), set.end(), c)) out.push_back(exchanged(set, dropped, c));
  return out;
}

bool holds_twice(const Hypotheses& hypotheses, const Members& set) {
  return std::any_of(set.begin(), set.end(), [&](int c) {
    const std::string& shared = hypotheses.candidates[c].name;
    const auto of_one = [&](int d) {
      const Candidate& own = hypotheses.candidates[d];
      return own.name != shared && shared_name(own) == shared;
    };
    return std::any_of(set.begin(), set.end(), of_one);
  });
}

std::vector<Members> parted_sets(const Hypotheses& hypotheses, const Members& set, int largest) {
  std::vector<Members> out;
  for (int shared = 0; shared < count_of(hypotheses.candidates); ++shared) {
    const Members parts = parts_of(hypotheses, shared);
    if (parts.size() < 2) continue;
    const auto has = [&](int c) { return std::binary_search(set.begin(), set.end(), c); };
    const bool whole = has(shared), parted = std::all_of(parts.begin(), parts.end(), has);
    if (!whole && !parted) continue;

    Members other = set;
    std::erase_if(other, [&](int c) { return c == shared || index_of(parts, c) >= 0; });
    if (parted) other.push_back(shared);
    if (whole) other.insert(other.end(), parts.begin(), parts.end());
    std::sort(other.begin(), other.end());
    if (count_of(other) <= largest) out.push_back(std::move(other));
  }
  return out;
}

bool extends(const Hypotheses& hypotheses, int candidate, int other) {
  const effects::Effect* effect = hypotheses.candidates[candidate].effect;
  return effect != nullptr && effect->special_case == hypotheses.candidates[other].name;
}

std::vector<Members> plainer_sets(const Hypotheses& hypotheses, const Members& set) {
  std::vector<Members> out;
  for (const int c : set)
    for (int other = 0; other < count_of(hypotheses.candidates); ++other)
      if (extends(hypotheses, c, other) && index_of(set, other) < 0)
        out.push_back(exchanged(set, c, other));
  return out;
}

}  // namespace jaculus::diagnosis
