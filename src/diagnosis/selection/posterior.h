#pragma once
// Posterior over fitted models: the only place where models get probabilities.
//
// Posterior = prior x evidence: prior 0.5 none, 0.38 shared by singles, 0.09 by pairs, 0.02 by
// triples. Each model stands twice: complete, where nothing beyond noise and tolerances is left,
// and with forces that it lacks (noise/random_effects.h), at odds of settings.prior_lacking.
// Effects are at work in either, so that what is established is not cleared because more remains.
// An effect that was not worth a fit is not ruled out by that: it may be there, smaller than these
// data tell. It counts with its prior and the evidence of its linear model about none, where
// nothing lacks.

#include <vector>

#include "diagnosis/selection/screen.h"

namespace jaculus::diagnosis {

/// A fitted set of effects.
struct ModelFit {
  std::vector<int> candidates;  ///< sorted; empty: none
  Fit fit;
  double log_prior = 0.0;
  /// By how much its log evidence moves where contenders tell the noise in turn (contenders.h), and
  /// the same without forces. 0: the space of its fit is the only one.
  double moved = 0.0, moved_complete = 0.0;
  double complete = 0.0;  ///< probability of the model with nothing beside it
  double lacking = 0.0;   ///< probability of the model with forces beside it that it lacks

  [[nodiscard]] double probability() const { return complete + lacking; }
  /// log prior x evidence; -infinity for an invalid fit
  [[nodiscard]] double log_weight() const;
  /// The same in the space of its fit alone.
  [[nodiscard]] double log_weight_there() const;
  [[nodiscard]] double log_evidence() const { return fit.log_evidence + moved; }
  [[nodiscard]] double log_complete() const { return fit.log_complete + moved_complete; }
};

/// log prior x evidence of a model in one space, with the forces that it lacks and without;
/// -infinity where it has none.
struct SpaceWeight {
  double lacking = -kInfinity, complete = -kInfinity;
};
/// By a fit of the model in that space.
SpaceWeight weight_of(const ModelFit& model, const Fit& fit, const Settings& settings);

/// The most probable of the models of which a condition holds, of equals the first; null where it
/// holds of none. `models`: const or not, as what is returned.
template <typename Models, typename Condition>
auto most_probable(Models& models, const Condition& holds) -> decltype(models.data()) {
  decltype(models.data()) best = nullptr;
  for (auto& model : models)
    if (holds(model) && (best == nullptr || model.log_weight() > best->log_weight())) best = &model;
  return best;
}
/// All of them, of equals as they stand.
std::vector<const ModelFit*> most_probable_first(const std::vector<ModelFit>& models);

/// What a search found (search.h).
struct SearchResult {
  std::vector<ModelFit> models;  ///< none first, then as fitted; without probabilities
  std::vector<Probe> probes;     ///< of all candidates about none
  /// A candidate each: those that its fitted signature can't be told from, itself first; empty
  /// where it was not fitted alone.
  std::vector<std::vector<int>> indistinguishable;
  /// Of the nuisances where the noise was told, under a plan: those nearby follow from them.
  RowSlopes nuisance_rows{};
  long predictions = 0;
};

struct Posterior {
  std::vector<ModelFit> models;   ///< most probable first
  double none = 0.0;              ///< probability of no effect, nothing lacking
  double unexplained = 0.0;       ///< probability of no effect, but something lacking
  std::vector<double> inclusion;  ///< a candidate each: probability that it is at work, as fitted
  /// A candidate each: probability that it is at work alone and too small for a fit; 0 where it was
  /// fitted alone.
  std::vector<double> untold;
  std::vector<double> scores;  ///< a candidate each: log evidence beyond none's, by screening
  std::vector<std::vector<int>> indistinguishable;  ///< as in SearchResult

  /// The valid fitted model of some candidates; null where there is none.
  [[nodiscard]] const ModelFit* find(const std::vector<int>& candidates) const;
  /// Probability that no effect is told, at work or not, and nothing lacks.
  [[nodiscard]] double nothing_told() const;
  /// The most probable valid model with effects; null without any.
  [[nodiscard]] const ModelFit* leading() const;
};

double log_prior(std::size_t members, std::size_t candidates, const Settings& settings);

/// Probabilities of all models.
Posterior posterior_of(const SearchResult& search, const Settings& settings);

}  // namespace jaculus::diagnosis
