#pragma once
// Whether one account holds for every dataset: gaps by dataset and channel in physical units.
//
// With f at parameters p, segments k of a dataset aligned by their own shifts (noise/alignment.h)
// and rest taken off, each channel's mean over the segments of a row's model time is
//     e_c(t) = mean_k [y_k(t + s_k) - f(t)] - its mean over rows before the command,
// in bins of the channel's spacing; the gap is its root mean square over bins from the command on.
// Scatter between trials is none of it, nor are clocks. Held out: p fitted to the other datasets
// alone, unknowns from where the files have them; clocks and noise are those of all.
//
// With g an effect's signature at its prior's scale and J the unknowns' slopes, white, the unknowns
// hide the effect where g^T V^-1 g/2 would tell it (settings.indistinguishable_below), and what of
// g no J c makes would not.
//
// An effect harms a set where the set's gap in noise floors, without it and all else fitted
// again to all sets, is smaller by settings.least_improvement.

#include "diagnosis/selection/fitted_models.h"
#include "jaculus/diagnosis/agreement.h"

namespace jaculus::diagnosis {

/// The agreement of the model that frees `candidates` at p (of `none` where they are empty),
/// against `none`, with unknowns as fitted. `probes`: of all candidates about `none`, or empty.
/// Empty where nothing is open and there is one dataset, or a fit fails.
Agreement agreement_of(const Problem& problem, const Comparison& comparison, const Fit& none,
                       const std::vector<Probe>& probes, const std::vector<int>& candidates,
                       const Vector& p);

}  // namespace jaculus::diagnosis
