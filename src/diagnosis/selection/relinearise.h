#pragma once
// Everything that is linear about a point, told anew about a model: noise, nuisances and what makes
// rows white.

#include "diagnosis/selection/comparison.h"
#include "diagnosis/selection/fit.h"
#include "diagnosis/selection/posterior.h"

namespace jaculus::diagnosis {

/// The space about a model, which is fitted again from there until it stays.
struct Relinearised {
  Comparison comparison;
  Fit fit;
};
Relinearised relinearise(const Problem& problem, Comparison comparison, Fit fit);
/// The same, in so many rounds at most and with fits by some options.
Relinearised relinearise(const Problem& problem, Comparison comparison, Fit fit, int rounds,
                         FitOptions options);

/// The space about the model without effects, fitted in the space of `comparison` first; nothing
/// where that fails.
std::optional<Relinearised> relinearise_about_none(const Problem& problem, Comparison comparison,
                                                   const FitOptions& options);

/// Of a fit that tells what noise is about, no result: one round more, effects by secants. Each of
/// many windows is a simulation.
FitOptions short_fit();

struct ToldAnew {
  Comparison comparison;
  std::optional<Relinearised> about_none;  ///< where it was worked out
};
/// The space about a leading effect; about none where there is no such effect, or where it leaves
/// forces and the data, with what each model's parameters strain, are less probable by it than by
/// none with its tolerances fitted. `near`: slopes of the nuisances' rows to set out with, or none.
/// Singles are judged by slopes at the files' values: a strong
/// effect is told there, but what tolerances do beyond slopes may be taken for one.
ToldAnew told_anew(const Problem& problem, const Comparison& comparison, const Fit& none,
                   const ModelFit* leader, int rounds, const RowSlopes& near = {});

}  // namespace jaculus::diagnosis
