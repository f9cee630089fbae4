#include "diagnosis/verdict/proposal.h"

#include <algorithm>
#include <numeric>

namespace jaculus::diagnosis {
namespace {

/// Candidates by inclusion probability, highest first.
std::vector<int> by_inclusion(const Posterior& posterior) {
  std::vector<int> order(posterior.inclusion.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return posterior.inclusion[a] > posterior.inclusion[b]; });
  return order;
}

std::vector<int> at_least(const Posterior& posterior, double probability) {
  std::vector<int> found = by_inclusion(posterior);
  std::erase_if(found, [&](int c) { return posterior.inclusion[c] < probability; });
  return found;
}

std::vector<int> sorted(std::vector<int> members) {
  std::sort(members.begin(), members.end());
  return members;
}

/// Whether the sure ones of a longer list stand alone: held-out data don't ask for the rest.
bool stand_alone(const std::vector<int>& sure, const Posterior& posterior, HeldOutGaps& gaps,
                 const Settings& settings) {
  const ModelFit* alone = sure.empty() ? nullptr : posterior.find(sorted(sure));
  return alone != nullptr && gaps.of(*alone).valid &&
         !further_effects_predict(gaps, posterior, *alone, settings);
}

Proposal name_effects(const Posterior& posterior, HeldOutGaps& gaps, const Settings& settings) {
  const double by_effects = 1.0 - posterior.none - posterior.unexplained;
  const std::vector<int> sure = at_least(posterior, settings.sure);
  const std::vector<int> likely = at_least(posterior, settings.likely);
  if (!sure.empty() && likely.size() == sure.size()) return {Naming::sure, sure, nullptr, {}};

  const std::vector<int> listed = at_least(posterior, settings.listed * by_effects);
  if (listed.size() == 1) return {Naming::sure, listed, nullptr, {}};
  if (stand_alone(sure, posterior, gaps, settings)) {
    return {
        Naming::sure,
        sure,
        nullptr,
        {"more effects fit better, but which is not clear, and held-out data don't ask for them"}};
  }
  return {Naming::rivals, listed, nullptr, {}};
}

}  // namespace

Proposal propose(const Posterior& posterior, HeldOutGaps& gaps, const Settings& settings) {
  if (posterior.unexplained > settings.likely)
    return {Naming::nothing, {}, posterior.most_evident(), {}};
  if (posterior.none > settings.likely) return {Naming::nothing, {}, posterior.find({}), {}};

  Proposal proposal = name_effects(posterior, gaps, settings);
  const ModelFit* named =
      proposal.naming == Naming::sure ? posterior.find(sorted(proposal.effects)) : nullptr;
  proposal.chosen = named != nullptr ? named : posterior.most_evident();
  if (proposal.naming != Naming::sure || proposal.effects.size() < 2) return proposal;

  const ModelFit* kept = without_idle_members(posterior, gaps, proposal.chosen, settings);
  if (kept != proposal.chosen)
    proposal.reasons.emplace_back("left out what held-out data are predicted as well without");
  std::erase_if(proposal.effects, [&](int c) {
    return !std::binary_search(kept->candidates.begin(), kept->candidates.end(), c);
  });
  proposal.chosen = kept;
  return proposal;
}

}  // namespace jaculus::diagnosis
