#pragma once
// What contenders are worth, whichever of them tells the noise.
//
// Under a plan the space in which models are compared is about one of them: the slopes of clocks
// and starts are that model's, what trials differ by beyond these is noise, and where impacts fall
// decides which rows are sharp. On real robots no model is true, and evidence in the spaces of two
// models that predict equally well differs by ten nats and more, either way: which one a search
// happened to set out from would decide. So each contender tells the noise once, all are fitted
// there, and probabilities are the means over these spaces j,
//   p(i) = 1/K sum_j p(i | y, j),
// a linear opinion pool (Stone 1961; Genest and Zidek 1986) of K noise models that nothing ranks:
// their likelihoods could be compared, but are decided by how sharp a thousand rows are. What leads
// clearly in every space still does; what leads in one alone does not. A space in which a contender
// can't be fitted has no voice.
// Contenders are the models, none among them, that were fitted with tolerances simulated and that
// none leads by settings.clear_lead in the space of the search. Other sets that were simulated
// are fitted in their spaces too; the rest, none where it does not contend, is as far behind what
// leads as in the space of the search.

#include <optional>
#include <vector>

#include "diagnosis/selection/comparison.h"
#include "diagnosis/selection/posterior.h"

namespace jaculus::diagnosis {

/// Of all models in one space; nothing of those that were not fitted there.
using SpaceWeights = std::vector<std::optional<SpaceWeight>>;

/// Weights whose probabilities are the means over the spaces `there`, with the sum of those `here`,
/// in the space of the search, which are what comes back where there is no other.
std::vector<SpaceWeight> over_spaces(const std::vector<SpaceWeight>& here,
                                     const std::vector<SpaceWeights>& there);

/// Models of a search in one space, with what the spaces of its contenders make of them
/// (ModelFit::moved). As they are where there is one contender, or under a logged input, whose
/// windows restart from what was measured. `predictions`: counts those that it takes.
std::vector<ModelFit> pooled(const Problem& problem, const Comparison& comparison,
                             std::vector<ModelFit> models, long& predictions);

}  // namespace jaculus::diagnosis
