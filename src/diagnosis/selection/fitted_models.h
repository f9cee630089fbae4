#pragma once
// The models fitted so far in a search, and how more are added.

#include <vector>

#include "diagnosis/selection/comparison.h"
#include "diagnosis/selection/linear_sets.h"
#include "diagnosis/selection/posterior.h"

namespace jaculus::diagnosis {

using Members = std::vector<int>;

class FittedModels {
 public:
  /// Fits none, from nominal.
  FittedModels(const Problem& problem, const Comparison& comparison, const SearchResult* earlier);

  [[nodiscard]] const std::vector<ModelFit>& all() const { return models_; }
  [[nodiscard]] const ModelFit& none() const { return models_.front(); }
  [[nodiscard]] long predictions() const { return predictions_; }

  /// log prior x evidence.
  [[nodiscard]] double value(const ModelFit& model) const;
  /// The model of some candidates, valid or not; null where it was not fitted.
  [[nodiscard]] const ModelFit* find(const Members& members) const;
  /// The best valid model of a size; null where there is none.
  [[nodiscard]] const ModelFit* best(int size) const;
  /// `from` and the next best of its size, best first.
  [[nodiscard]] std::vector<ModelFit> close_to(const ModelFit& from, int count) const;

  /// Screens all candidates about a model, by line search about none.
  std::vector<Probe> probe(const ModelFit& base);
  /// Fits `base` and one more candidate each, of the best `count` probes.
  void extend(const ModelFit& base, const std::vector<Probe>& probes, int count);
  /// Fits sets of effects from their linear estimates, those that were not fitted yet.
  void fit_sets(const std::vector<LinearSet>& sets);
  /// The same of these candidates.
  void extend(const ModelFit& base, const std::vector<Probe>& probes, const Members& which);

 private:
  struct Job {
    Members members;
    std::vector<Vector> starts;
    Fit base{};                 ///< of the model that this one extends
    double enough = kInfinity;  ///< log evidence at which no further start is tried
  };

  [[nodiscard]] const Fit* fitted_earlier(int candidate) const;
  /// The best fit of what is left where one member of a set is dropped, or none's.
  [[nodiscard]] const Fit& contained_in(const Members& members) const;
  void fit(const std::vector<Job>& jobs);

  const Problem& problem_;
  const Comparison& comparison_;
  const SearchResult* earlier_;
  std::vector<ModelFit> models_;
  long predictions_ = 0;
};

}  // namespace jaculus::diagnosis
