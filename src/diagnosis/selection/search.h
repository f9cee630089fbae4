#pragma once
// Search among models: none, single effects, sets; and what no effect of the catalogue explains.
//
// Under a plan:
// 1. Screen all candidates on the residual of `none`; fit the best by score and whatever these data
//    can't tell from the best fit.
// 2. Unless none is best, or the best needs no force that the plant lacks (noise/random_effects.h):
//    screen again on the best singles and fit pairs, about the first two also sets of two more
//    that lead every pair by linear algebra (a centre of mass and a delay, of which neither helps
//    alone); exchange each member of the best pair one for one; where the pair gains, the same for
//    triples; drop members backwards.
// 3. From what leads then, moves as under a logged input: it may be no neighbour of a better set.
// Under a logged input errors start anew with each window, so that slopes hold for a while and sets
// can be judged by linear algebra (linear_sets.h):
// 1. From none, the best sets of one or two effects more are fitted; about what leads then, all
//    candidates are screened again, and so on while a larger set leads.
// 2. Then every member is exchanged for what stands in for it; where that leads, again from 1.
// Every model fitted on the way stays in the comparison.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/selection/comparison.h"
#include "diagnosis/selection/posterior.h"
#include "diagnosis/selection/relinearise.h"

namespace jaculus::diagnosis {

struct SearchOptions {
  int largest = 3;                        ///< effects at once
  const SearchResult* earlier = nullptr;  ///< its fits are starts here
  bool same_space = false;                ///< whether it was in this space: then they stay
  std::optional<int> rounds{};            ///< of moves at most; else settings.search_rounds
  /// Where the model without effects stands in a space of its own; nothing where it has none.
  std::optional<Vector> none{};
  /// Models of another search of these data, by effects alone, that shall not be missed, in this
  /// problem's parameters, the leading one first. Other sets of effects alone are then not sought.
  std::vector<ModelFit> known{};
  std::function<void(const std::string&)> progress{};
};
SearchResult search_models(const Problem& problem, const Comparison& comparison,
                           const SearchOptions& options);

/// Search twice: where one effect leads clearly after the singles, everything is relinearised about
/// it first, or about none with its tolerances fitted where no effect leads or that leaves less.
/// Nuisances act differently once an effect is there (a shift on a tail that swings, the clocks by
/// which an impact is dated).
struct Selection {
  Comparison comparison;                     ///< about the clear leader, or none
  SearchResult search;                       ///< no models where none can't be fitted
  std::optional<Relinearised> about_none{};  ///< the space about none, where it was worked out
};
/// `known`: as SearchOptions has them.
Selection select_models(const Problem& problem, Comparison comparison,
                        const std::function<void(const std::string&)>& progress,
                        std::vector<ModelFit> known = {});
/// The same from what a search on a part of the data found (data/observations.h, with_windows): its
/// leading models are fitted to all data; about what leads then, all candidates are screened and
/// the search moves settings.rounds_after_part times more at most.
Selection select_models_from(const Problem& problem, Comparison comparison, SearchResult part,
                             const std::function<void(const std::string&)>& progress);

}  // namespace jaculus::diagnosis
