#pragma once
// Posterior over fitted models: the only place where models get probabilities.
//
// Posterior = prior x evidence: prior 0.5 none, 0.38 shared by singles, 0.09 by pairs, 0.02 by
// triples, each model's with a share of 1e-3 for "and something unknown" (structure.h).
// Form: no effect on hardware has quite the form that the plant gives it. Structure counts beyond
// settings.form_left of the log evidence that the model gains over none, and every effect beyond
// the first beyond settings.form_member of it.

#include <vector>

#include "diagnosis/selection/screen.h"

namespace jaculus::diagnosis {

/// A fitted set of effects.
struct ModelFit {
  std::vector<int> candidates;  ///< sorted; empty: none
  Fit fit;
  double log_prior = 0.0;
  double structure = -kInfinity;  ///< log Bayes factor of unknown structure; -infinity: not tested
  double probability = 0.0;       ///< of the model without unknown structure
  double unknown_probability = 0.0;  ///< of the model with it
};

/// What a search found (search.h).
struct SearchResult {
  std::vector<ModelFit> models;  ///< none first, then as fitted; without probabilities
  std::vector<Probe> probes;     ///< of all candidates about none
  /// A candidate each: those that its fitted signature can't be told from, itself first; empty
  /// where it was not fitted alone.
  std::vector<std::vector<int>> indistinguishable;
  long predictions = 0;
};

struct Posterior {
  std::vector<ModelFit> models;  ///< most probable first (structure included)
  double none = 0.0;             ///< probability
  double unexplained = 0.0;      ///< probability
  std::vector<double>
      inclusion;  ///< a candidate each: probability that it is at work, nothing unknown
  std::vector<std::vector<int>> indistinguishable;  ///< as in SearchResult

  /// The valid fitted model of some candidates; null where there is none.
  [[nodiscard]] const ModelFit* find(const std::vector<int>& candidates) const;
  /// The valid model of most prior x evidence, form aside; null where there is none.
  [[nodiscard]] const ModelFit* most_evident() const;
  /// The most probable valid model with effects, with or without something unknown; null without
  /// any.
  [[nodiscard]] const ModelFit* leading() const;
};

double log_prior(std::size_t members, std::size_t candidates, const Settings& settings);

/// log prior x evidence less form; -infinity for an invalid fit. `none`: log evidence without
/// effects.
double log_weight(const ModelFit& model, double none, double form_member);

/// Probabilities of all models, by the form that settings.form_member allows for.
Posterior posterior_of(const SearchResult& search, const Settings& settings);

}  // namespace jaculus::diagnosis
