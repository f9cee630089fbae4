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
//   tune everything           all parameters at once by bounded least squares, as a sysid toolbox
//                             does; the one that moved most in units of its prior's width wins
// Each says "none" where |r|^2 is under 1.3 a row. None knows a probability; scoring gives it one.

#include "jaculus/evaluation/score.h"

namespace jaculus::evaluation {

const std::vector<std::string>& baseline_names();
/// Answers of all baselines on one dataset, in that order.
std::vector<Prediction> baseline_answers(const std::filesystem::path& dataset);

}  // namespace jaculus::evaluation
