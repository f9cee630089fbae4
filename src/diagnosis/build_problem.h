#pragma once
// From datasets to a problem in which models can be compared, and fits of given sets of effects in
// it.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/forward/plant_forward.h"
#include "diagnosis/selection/search.h"
#include "jaculus/diagnosis/diagnosis.h"
#include "jaculus/diagnosis/options.h"

namespace jaculus::diagnosis {

/// A problem, and its plant where it has one.
struct BuiltProblem {
  std::shared_ptr<const Problem> problem;
  std::optional<PlantForward> forward;
};

/// Datasets as a problem over options.effects (none named: the catalogue). Without a forward model
/// where the observations are insufficient.
BuiltProblem build_problem(const std::vector<trajectory::Dataset>& datasets,
                           const DiagnoseOptions& options);

/// The problem over boxes of time that follow one another over all of every trial; without a
/// forward model where it can't be had. `box` [s].
BuiltProblem in_boxes(const std::vector<trajectory::Dataset>& datasets, DiagnoseOptions options,
                      double box);

/// Makes a problem of observations: a plant's forward model depends on them.
using ProblemBuilder = std::function<BuiltProblem(Observations)>;
ProblemBuilder builder_of(const DiagnoseOptions& options);
/// Of these effects and no others.
ProblemBuilder builder_of(std::vector<effects::Effect> effects, const Settings& settings);
/// For models that are no plant: the same hypotheses and forward model about other observations.
ProblemBuilder builder_like(const Problem& problem);

/// A problem whose data can be judged: aligned, noise known, one-off disturbances left out.
struct Prepared {
  BuiltProblem built;
  NoiseModel noise;  ///< about nominal
  std::vector<OneOff> disturbances;
  std::vector<std::string> notes;    ///< what was left out
  std::vector<std::string> reasons;  ///< why the data can't go on; empty where they can
};
Prepared prepare(BuiltProblem built, const ProblemBuilder& rebuild);

/// The space in which models are compared first: gains are fitted, and everything is about them and
/// the files' values.
Comparison first_comparison(const Problem& problem, NoiseModel noise);

/// All of some candidates fitted, one joining the others after another, with tolerances by their
/// slopes; linear.p: where the rest stays.
Fit fit_members_by_slopes(const Problem& problem, const Whitening& whitening,
                          const LinearNuisances& linear, const std::vector<int>& members);
/// The same and then with tolerances simulated.
Fit fit_members(const Problem& problem, const Whitening& whitening, const Vector& p,
                const std::vector<int>& members);

}  // namespace jaculus::diagnosis
