#pragma once
// Search among models: none, single effects, pairs, triples; and what no effect of the catalogue
// explains.
//
// 1. Screen all candidates on the residual of `none`; fit the best by score and whatever these data
//    can't tell from the best fit.
// 2. Unless none is best, or the best needs no force that the plant lacks (noise/random_effects.h):
//    screen again on the best single (and on the next best) and fit pairs; exchange each member of
//    the best pair one for one; where the pair gains, the same for triples; drop members backwards.
//    Every model fitted on the way stays in the comparison.

#include <functional>
#include <string>

#include "diagnosis/selection/comparison.h"
#include "diagnosis/selection/posterior.h"

namespace jaculus::diagnosis {

struct SearchOptions {
  int largest = 3;                        ///< effects at once
  const SearchResult* earlier = nullptr;  ///< in another space: its fits of singles are starts here
  std::function<void(const std::string&)> progress{};
};
SearchResult search_models(const Problem& problem, const Comparison& comparison,
                           const SearchOptions& options);

/// Search twice: where one effect leads clearly after the singles, everything is relinearised about
/// it first. Nuisances act differently once an effect is there (a shift on a tail that swings, the
/// clocks by which an impact is dated).
struct Selection {
  Comparison comparison;  ///< about the clear leader, if there is one
  SearchResult search;    ///< no models where none can't be fitted
};
Selection select_models(const Problem& problem, Comparison comparison,
                        const std::function<void(const std::string&)>& progress);

/// The space about a model, which is fitted again from there until it stays.
struct Relinearised {
  Comparison comparison;
  Fit fit;
};
Relinearised relinearise(const Problem& problem, Comparison comparison, Fit fit);

}  // namespace jaculus::diagnosis
