#pragma once
// Where the gap lies.
//
// By channel    gap = rms over trials and samples of measured - predicted; multiple = gap over the
//               channel's noise floor.
// By time       the model is restarted from the measured state at the start of every window, so
//               that an early error doesn't smear into late ones; the share of a phase is the
//               energy of its windows' errors beyond noise, in noise floors.
// Departure     the first time at which the mean residual over the trials leaves its band and stays
//               out (band: normal quantile at 5 % over channels times effective samples), then a
//               hinge fitted back to its onset:
//                   r_c(t) = a_c (t - t0)+^2 + b_c (t - t0)+^3   (rates: one power less),
//               t0 by profile likelihood over all channels together.
// By component  from the posterior of selection, the only one there is (components.h).
// Where base and joints are both measured, the generalised force that the model lacks along the
// measured motion, through a smoother (force.h).

#include "diagnosis/forward/plant_forward.h"
#include "diagnosis/selection/search.h"
#include "jaculus/diagnosis/localisation.h"
#include "jaculus/diagnosis/verdict.h"

namespace jaculus::diagnosis {

/// Localises the gap that the model as its files state it, at `stated`, leaves. What is judged in
/// time has its nuisances from the prefix alone; for the components they are those of the fitted
/// models. `posterior` is over `selection`'s models. Where the verdict has `named` nothing, a note
/// says that the components' shares were refused.
Localisation localise(const Problem& problem, const PlantForward& forward,
                      const Selection& selection, const Vector& stated, const Posterior& posterior,
                      bool named);

}  // namespace jaculus::diagnosis
