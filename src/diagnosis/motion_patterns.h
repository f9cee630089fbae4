#pragma once
// What the stated model leaves under a plan or script, described by simulation of whole motions:
// for robots that stand on feet, or whose torques nobody logged, where no force can be had box by
// box.
//
// About the stated model, with the gains and columns of pattern_scan.h:
// patterns join one by one, the one of most gain first, while that exceeds settings.worth and the
// logarithm of how many were tried (each is as likely as another before). On folds of trials,
// coefficients fitted to the others predict a fold's rows r_f:
//   v(S) = sum_f (|r_f|^2 - |r_f - Y_f b|^2)/sum_f (|r_f|^2 - rows)
// is the share of what is left beyond noise, of each pattern by Shapley's mean, with Student's
// interval over the folds. Stated is what has a lower end above zero, settings.least_followed or
// more, where some channel leaves settings.plain_gap noise floors.

#include "diagnosis/forward/hypotheses.h"
#include "diagnosis/remainder/place_patterns.h"
#include "diagnosis/verdict/told_events.h"
#include "jaculus/diagnosis/diagnosis.h"
#include "jaculus/diagnosis/options.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::diagnosis {

/// Places with what they follow; empty where nothing is left, or one trial alone tells of it.
std::vector<RemainderPlace> patterns_of_motion(const Diagnosis& found);

/// A share of energy with its interval over folds.
struct TakenShare {
  double value = kNaN;
  Bounds ci95{kNaN, kNaN};
};

/// Of the held-out gap's energy that one model leaves, what another one leaves less of it; not
/// known where that one leaves no gap (settings.gap_of_fold).
TakenShare share_taken(const HeldOut& by_effects, const HeldOut& with_forces,
                       const Settings& settings);

/// What a statement tells beside effects.
struct ToldForces {
  const std::vector<FoundEffect>& patterns;
  const std::vector<ToldPush>& pushes;
  const model::PlanarModel& robot;
};

/// Places of patterns that a diagnosis has as candidates and of pushes, with what was found of
/// them. `taken`: what they take of the gap that the effects beside them leave; by their shares of
/// the whole gap it is each one's.
std::vector<RemainderPlace> places_of(const std::vector<PlacePattern>& candidates,
                                      const ToldForces& found, const TakenShare& taken);

/// Parameters of the model that a diagnosis states, in a problem about other effects or windows of
/// the same data.
Vector stated_parameters(const Diagnosis& found, const Hypotheses& hypotheses);

}  // namespace jaculus::diagnosis
