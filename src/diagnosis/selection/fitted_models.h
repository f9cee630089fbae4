#pragma once
// The models fitted so far in a search, and how more are added.

#include <map>
#include <set>
#include <vector>

#include "diagnosis/selection/comparison.h"
#include "diagnosis/selection/linear_sets.h"
#include "diagnosis/selection/neighbouring_sets.h"
#include "diagnosis/selection/posterior.h"

namespace jaculus::diagnosis {

class FittedModels {
 public:
  /// Fits none, from where the noise was told; or has the models of an earlier search of this
  /// space. Models are fitted with tolerances by their slopes there, until they are refined.
  FittedModels(const Problem& problem, const Comparison& comparison, const SearchResult* earlier,
               bool same_space);

  /// From here on of sets of effects only those with a push or a pattern (Hypotheses) are fitted
  /// beside singles: another search of these data had the others, and what led there is among them.
  void seek_beyond_effects() { beyond_effects_only_ = true; }
  /// Whether a set is sought and was not fitted yet.
  [[nodiscard]] bool to_fit(const Members& members) const;

  [[nodiscard]] const std::vector<ModelFit>& all() const { return models_; }
  [[nodiscard]] const ModelFit& none() const { return models_.front(); }
  [[nodiscard]] long predictions() const { return predictions_; }
  /// Slopes of the nuisances' rows where the noise was told; none in windows.
  [[nodiscard]] const RowSlopes& nuisance_rows() const { return linear_.rows; }

  /// log prior x evidence.
  [[nodiscard]] double value(const ModelFit& model) const;
  /// The model of some candidates, valid or not; null where it was not fitted.
  [[nodiscard]] const ModelFit* find(const Members& members) const;
  /// The best valid model of a size; null where there is none.
  [[nodiscard]] const ModelFit* best(int size) const;
  /// The best valid model of all, none among them; null where none is valid.
  [[nodiscard]] const ModelFit* leading() const;
  /// `from` and the next best of its size, best first.
  [[nodiscard]] std::vector<ModelFit> close_to(const ModelFit& from, int count) const;

  /// Screens all candidates about a model, by line search about none; once, for fits stay as they
  /// are until they are refined, which lets go of what is returned here.
  const std::vector<Probe>& probe(const ModelFit& base);
  /// Fits `base` and one more candidate each, of the best `count` probes.
  void extend(const ModelFit& base, const std::vector<Probe>& probes, int count);
  /// Fits sets of effects from their linear estimates about a model, those that were not fitted
  /// yet. `probes`: screened about that model.
  void fit_sets(const ModelFit& about, const std::vector<LinearSet>& sets,
                const std::vector<Probe>& probes);
  /// Fits models of an earlier search again, from where they were, those that were not fitted yet.
  void fit_again(const std::vector<ModelFit>& earlier);
  /// Fits the effects of sets with a push or a pattern without it, from where they are with it, of
  /// those that none leads by settings.clear_lead: what a force gains must be over these.
  void fit_without_forces();
  /// The leading models again, best first, and none, with tolerances simulated: slopes served to
  /// find them. Each sets out from where it is, from where slopes were told or from the nuisances
  /// of what leads, with the tolerances that are what its effects are, none from where it stands in
  /// its own space (`none_in_own`) too; under a plan they then try each other's. `led`: what led a
  /// search without forces, and is refined with them whatever slopes make of it; may be empty.
  void refine(const std::optional<Vector>& none_in_own, const Members& led);
  /// The same of these candidates.
  void extend(const ModelFit& base, const std::vector<Probe>& probes, const Members& which);

 private:
  struct Job {
    Members members;
    std::vector<Vector> starts;
    Fit base{};                 ///< of the model that this one extends
    double enough = kInfinity;  ///< log evidence at which no further start is tried
    Vector scales{};            ///< deviations of the forces at the starts; empty: not known
    Matrix effect_slopes{};     ///< at the starts (fit.h); none: not known
    Vector estimate{};          ///< where slopes promise `enough`, nuisances too; empty: not known
  };

  [[nodiscard]] std::vector<Vector> starts_of(const ModelFit& about, const LinearSet& set,
                                              const std::vector<Probe>& probes) const;
  /// Slopes of a set's effects about a model: its own, or of what it lacks those of screening. None
  /// where these are no slopes.
  [[nodiscard]] Matrix slopes_about(const ModelFit& about, const Members& set,
                                    const std::vector<Probe>& probes) const;
  [[nodiscard]] const Fit* fitted_earlier(int candidate) const;
  /// The best fit of what is left where one member of a set is dropped, or none's.
  [[nodiscard]] const Fit& contained_in(const Members& members) const;
  void refine(ModelFit& model, std::vector<Vector> starts = {});
  /// The model of these members, where it is fitted and was not refined yet.
  void refine_once(const Members& members, std::set<Members>& refined);
  /// The next of the models by slopes that may come to lead; null where none may. `moved`: by how
  /// much refining changed others; `widely`: also those by less than clear_lead below what led by
  /// slopes, `best_by_slopes`.
  [[nodiscard]] ModelFit* next_to_refine(const std::set<Members>& refined,
                                         const std::map<Members, double>& moved,
                                         double best_by_slopes, bool widely);
  /// Where a model would stand if tolerances, as far as they reach, were what a leading one's other
  /// effects are: the same robot by other names.
  [[nodiscard]] Vector by_tolerances(const ModelFit& lead, const ModelFit& model) const;
  /// What forces that are no effects have to lead: the model that led without them, and the best of
  /// effects alone, until the best is refined.
  void refine_effects_alone(const Members& led, std::set<Members>& refined);
  /// The models that a refined one is compared with where one of its effects is dropped: by slopes
  /// they would be judged at a poorer optimum than it is.
  void refine_within(const ModelFit& larger, std::set<Members>& refined);
  /// Each of the models that were refined from the nuisances of every other, wherever the cost is
  /// lower there: tolerances have several valleys, and no model shall lead by its start alone.
  void share_valleys(const std::set<Members>& refined);
  /// A model whose effects are among those of a larger one that leads it, from where that one is
  /// without what it has more and from where its slopes have their optimum then: what these effects
  /// gain must be theirs, and no valley that the smaller model has as well.
  void fit_within(const ModelFit& larger, ModelFit& model);
  /// A model with tolerances simulated, from `start` by slopes that are known, of the nuisances'
  /// rows.
  Fit fit_by_known(const ModelFit& model, const Vector& start, const RowSlopes& rows);
  /// Of a fit with tolerances simulated.
  [[nodiscard]] FitOptions exact_options(const ModelFit& model) const;
  void fit(const std::vector<Job>& jobs);

  const Problem& problem_;
  const Comparison& comparison_;
  const SearchResult* earlier_;
  bool same_space_;
  bool beyond_effects_only_ = false;
  LinearNuisances linear_;  ///< at the noise model's point; no columns: there are none
  std::map<Members, std::vector<Probe>> probed_;  ///< about fitted models, as they were
  std::vector<ModelFit> models_;
  long predictions_ = 0;
};

}  // namespace jaculus::diagnosis
