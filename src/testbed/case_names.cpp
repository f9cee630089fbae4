// Which effects are in a case, and on which experiments it can be had.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <set>

#include "jaculus/core/error.h"
#include "testbed/case_draws.h"

namespace jaculus::testbed {
namespace {

using NameList = std::vector<std::string>;

constexpr int kNameDraws = 10000;  ///< draws of names until they can be had together
constexpr int kMostSets = 3;       ///< datasets of a group

template <class Value>
const Value& any_of_them(Random& random, const std::vector<Value>& values) {
  return values[std::uniform_int_distribution<std::size_t>(0, values.size() - 1)(random)];
}

void add_to(Families& families, const std::string& name) {
  const std::string family = name.substr(0, name.find('@'));
  for (NameList& names : families) {
    if (names.front().substr(0, names.front().find('@')) != family) continue;
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    return;
  }
  families.push_back({name});
}

NameList all_names(const Families& families) {
  NameList all;
  for (const NameList& names : families) all.insert(all.end(), names.begin(), names.end());
  return all;
}

/// Takes out a name, or a family by what its names are before "@".
bool take_out(Families& families, const std::string& name) {
  std::size_t taken = 0;
  for (NameList& names : families) {
    taken += std::erase_if(
        names, [&](const std::string& one) { return one == name || one.starts_with(name + "@"); });
  }
  std::erase_if(families, [](const NameList& names) { return names.empty(); });
  return taken > 0;
}

bool all_act(const Stage& stage, const NameList& effects) {
  return std::all_of(effects.begin(), effects.end(), [&](const std::string& name) {
    return acting_effect(stage, name) != nullptr;
  });
}

/// Stages on which all effects can act; those of `like`'s robot alone, where it is given.
std::vector<int> fitting_stages(const Grounds& grounds, const NameList& effects,
                                const Stage* like = nullptr) {
  std::vector<int> fitting;
  for (int i = 0; i < count_of(grounds.stages); ++i) {
    const Stage& stage = grounds.stages[i];
    if (like != nullptr && (&stage == like || stage.asked.robot != like->asked.robot)) continue;
    if (all_act(stage, effects)) fitting.push_back(i);
  }
  return fitting;
}

/// Stages on which a case may begin: a group needs another of the same robot.
std::vector<int> first_stages(const CaseKind& kind, const Grounds& grounds,
                              const NameList& effects) {
  std::vector<int> fitting = fitting_stages(grounds, effects);
  if (!kind.group) return fitting;
  std::erase_if(fitting, [&](int at) {
    return fitting_stages(grounds, effects, &grounds.stages[at]).empty();
  });
  return fitting;
}

/// Lists that the effects of a case are drawn from, one an effect.
std::vector<const Families*> lists_of(Random& random, const std::string& kind, const Pool& pool) {
  if (kind == "none") return {};
  if (kind == "single") return {&pool.catalogue};
  if (kind == "pair") return {&pool.catalogue, &pool.catalogue};
  if (kind == "outside") return {&pool.outside};
  if (kind == "mixed") return {&pool.catalogue, &pool.outside};
  if (kind == "event") return {&pool.events};
  assert(kind == "several");
  return std::vector<const Families*>(std::uniform_int_distribution<int>(2, 3)(random),
                                      &pool.catalogue);
}

/// One draw; nothing where two of the catalogue act on one part or no stage has them all.
std::optional<NameList> names_of_one_draw(Random& random, const CaseKind& kind,
                                          const Grounds& grounds) {
  NameList drawn;
  std::set<std::string> parts;
  for (const Families* families : lists_of(random, kind.name, grounds.pool)) {
    if (families->empty()) return std::nullopt;
    drawn.push_back(any_of_them(random, any_of_them(random, *families)));
    if (families != &grounds.pool.catalogue) continue;
    if (!parts.insert(grounds.pool.components.at(drawn.back())).second) return std::nullopt;
  }
  if (first_stages(kind, grounds, drawn).empty()) return std::nullopt;
  return drawn;
}

}  // namespace

Pool pool_of(const std::vector<Stage>& stages, const std::vector<std::string>& withheld) {
  Pool pool;
  for (const Stage& stage : stages) {
    for (const BenchEffect& effect : stage.effects) {
      if (effect.by_name_only) continue;
      add_to(effect.event     ? pool.events
             : effect.outside ? pool.outside
                              : pool.catalogue,
             effect.name);
      pool.components[effect.name] = effect.component;
    }
  }

  for (const std::string& name : withheld) {
    if (take_out(pool.outside, name) || take_out(pool.events, name)) continue;
    NameList allowed = all_names(pool.outside);
    for (const std::string& event : all_names(pool.events)) allowed.push_back(event);
    throw InputError(fmt::format("--withhold '{}': no outside effect of these robots; allowed: {}",
                                 name, fmt::join(allowed, ", ")));
  }
  return pool;
}

void check_kind(const CaseKind& kind, const Grounds& grounds) {
  Random random(1);
  for (int i = 0; i < kNameDraws; ++i)
    if (names_of_one_draw(random, kind, grounds)) return;
  throw InputError(fmt::format(
      "testbed seal: cases of kind '{}'{} asked for, but no experiment of these robots has such "
      "effects; allowed: other robots or plans, or none of this kind",
      kind.name, kind.group ? " in groups" : ""));
}

std::vector<std::string> draw_effects(Random& random, const CaseKind& kind,
                                      const Grounds& grounds) {
  std::optional<NameList> drawn;
  while (!drawn) drawn = names_of_one_draw(random, kind, grounds);
  return *drawn;
}

std::vector<int> draw_stages(Random& random, const CaseKind& kind, const Grounds& grounds,
                             const std::vector<std::string>& effects) {
  std::vector<int> stages = {any_of_them(random, first_stages(kind, grounds, effects))};
  if (!kind.group) return stages;

  std::vector<int> others = fitting_stages(grounds, effects, &grounds.stages[stages.front()]);
  std::shuffle(others.begin(), others.end(), random);
  const int more = std::uniform_int_distribution<int>(1, kMostSets - 1)(random);
  if (count_of(others) > more) others.resize(more);
  stages.insert(stages.end(), others.begin(), others.end());
  return stages;
}

}  // namespace jaculus::testbed
