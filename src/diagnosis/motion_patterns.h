#pragma once
// What the stated model leaves under a plan or script, described by simulation of whole motions:
// for robots that stand on feet, or whose torques nobody logged, where no force can be had box by
// box.
//
// About the stated model, p as fitted, white residuals of the measured rows are
//   r = sum_k Y_k b_k + e,   Y_k = M^-1/2 T df/db_k,   b_k ~ N(0, 1) prior scales,
// f simulated with the force of a pattern k (place_patterns.h) at work, tolerances and gains
// marginalised by M as in preflight/signatures.h, e with the misfit of noise/random_effects.h of
// most likely size. Contacts, closures and free flight are the simulation's: a force at a foot acts
// where the foot touches, and no coordinate has to be measured.
//   gain of a set S:  G(S) = log Z(S) - log Z(nothing),  Z by linear algebra
// Patterns join one by one, the one of most gain first, while that exceeds settings.worth and the
// logarithm of how many were tried (each is as likely as another before). On folds of trials,
// coefficients fitted to the others predict a fold's rows r_f:
//   v(S) = sum_f (|r_f|^2 - |r_f - Y_f b|^2)/sum_f (|r_f|^2 - rows)
// is the share of what is left beyond noise, of each pattern by Shapley's mean, with Student's
// interval over the folds. Stated is what has a lower end above zero, settings.least_followed or
// more, where some channel leaves settings.plain_gap noise floors.

#include "diagnosis/forward/hypotheses.h"
#include "jaculus/diagnosis/diagnosis.h"
#include "jaculus/diagnosis/options.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::diagnosis {

/// Places with what they follow; empty where nothing is left, or one trial alone tells of it.
std::vector<RemainderPlace> patterns_of_motion(const std::vector<trajectory::Dataset>& datasets,
                                               const DiagnoseOptions& options,
                                               const Diagnosis& found);

/// Parameters of the model that a diagnosis states, in a problem about other effects or windows of
/// the same data.
Vector stated_parameters(const Diagnosis& found, const Hypotheses& hypotheses);

}  // namespace jaculus::diagnosis
