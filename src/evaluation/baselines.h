#pragma once
// What one would try without a diagnosis, on the same datasets and through the same forward model.
// Residuals are the diagnosis' own whitened ones (nuisances of every run marginalised, noise's
// correlation known), which is more than these methods have by themselves; dataset-wide nuisances
// are fitted along.
//
//   lowest training error     each candidate fitted alone; the one that leaves the smallest |r|^2
//                             wins
//   correlation               the candidate whose signature S at its probing step has the largest
//                             |S . r|/(|S| |r|) wins
//   ridge on all parameters   all parameters at once in the model linearised about nominal, within
//                             bounds, the weight of the priors by held-out error (ridge.h); the
//                             effect of the largest share of the explained energy |S u|^2 wins
//   sparse regression         of the torque that the nominal model lacks at each joint
//                             (residual_torque.h, sparse_regression.h); the effect that the term of
//                             most energy, in deviations of the torque, stands for; unexplained
//                             where it stands for none, insufficient where joints aren't measured
// Each says "none" where |r|^2 is under 1.3 a row.
//
// Probabilities: lowest training error has a likelihood: softmax of -BIC/2 over candidates and
// none, BIC = |r|^2 + k ln(rows). The others have none and get their smoothed frequency in scoring
// (give_confidence in metrics.h).

#include "jaculus/evaluation/score.h"

namespace jaculus::evaluation {

const std::vector<std::string>& baseline_names();
/// Whether a predictor states probabilities of its own.
bool states_probability(const std::string& baseline);
/// Answers of all baselines on the datasets of one case, in that order.
std::vector<Prediction> baseline_answers(const std::vector<std::filesystem::path>& datasets);

}  // namespace jaculus::evaluation
