#include "diagnosis/verdict/told_events.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace jaculus::diagnosis {

PartedProposal parted(const Problem& problem, const Proposal& proposal) {
  PartedProposal out{proposal.naming, {}, {}, {}};
  const auto event = [&](int c) { return problem.hypotheses.candidates[c].is_event(); };
  const auto pattern = [&](int c) { return problem.hypotheses.candidates[c].is_pattern(); };
  if (proposal.naming == Naming::rivals) {
    Established place = proposal.effects.front();
    const auto effect = [&](int c) { return !event(c) && !pattern(c); };
    const auto first = std::find_if(place.others.begin(), place.others.end(), effect);
    if (!effect(place.effect) && first == place.others.end()) {
      if (event(place.effect)) return {Naming::sure, {}, {place}, {}};
      return {Naming::sure, {}, {}, {place}};
    }
    // Rows are effects alone: whether it is one of them is open.
    if (!effect(place.effect)) std::swap(place.effect, *first);
    std::erase_if(place.others, [&](int c) { return !effect(c); });
    out.effects = {place};
    return out;
  }

  for (const Established& e : proposal.effects) {
    auto& own = event(e.effect) ? out.events : pattern(e.effect) ? out.patterns : out.effects;
    own.push_back(e);
  }
  const bool rivals = out.effects.size() == 1 && !out.effects.front().others.empty();
  if (out.beyond_effects() && rivals) out.naming = Naming::rivals;
  return out;
}

Verdict about_effects(Verdict verdict, const PartedProposal& proposal) {
  if (!names_effects(verdict) || !proposal.beyond_effects()) return verdict;
  if (proposal.effects.empty()) return Verdict::unexplained;
  return proposal.naming == Naming::rivals ? Verdict::ambiguous : Verdict::partial;
}

std::vector<Ranked> ranked_by_effects(const Problem& problem, const std::vector<Ranked>& ranking) {
  const Hypotheses& hypotheses = problem.hypotheses;
  std::vector<Ranked> out;
  for (Ranked row : ranking) {
    const std::size_t before = row.members.size();
    std::erase_if(row.members, [&](const std::string& name) {
      return hypotheses.candidates[hypotheses.candidate(name)].beyond_effects();
    });
    if (row.members.size() != before)
      row.effect = row.members.empty() ? to_text(Verdict::unexplained)
                                       : fmt::format("{}", fmt::join(row.members, " + "));
    std::erase_if(row.parameters, [&](const FoundParameter& value) {
      const int c = hypotheses.candidate(value.name.substr(0, value.name.rfind('.')));
      return c >= 0 && hypotheses.candidates[c].beyond_effects();
    });

    const auto same = std::find_if(out.begin(), out.end(),
                                   [&](const Ranked& r) { return r.effect == row.effect; });
    if (same == out.end())
      out.push_back(std::move(row));
    else
      same->probability += row.probability;
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Ranked& a, const Ranked& b) { return a.probability > b.probability; });
  return out;
}

ForceEvent event_of(const Problem& problem, const FoundEffect& found) {
  const std::string place = found.name.substr(found.name.find('@') + 1);
  const bool of_body = problem.observations.datasets.front().model.body_of_joint(place) < 0;
  const FoundParameter &peak = found.parameters[0], &middle = found.parameters[1],
                       &length = found.parameters[2];

  ForceEvent event;
  event.joint = of_body ? "base" : place;
  event.along = of_body ? place : "";
  const double end = problem.observations.datasets.front().window_end;
  event.from = std::max(0.0, middle.value - 0.5 * length.value);
  event.to = std::min(end, middle.value + 0.5 * length.value);
  event.peak = peak.value;
  event.peak_ci95 = peak.ci95;
  event.unit = peak.unit;
  event.probability = found.probability;
  event.every_trial = true;
  return event;
}

}  // namespace jaculus::diagnosis
