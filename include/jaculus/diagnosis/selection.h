#pragma once
// Search among models: none, single effects, pairs, triples; and what no effect of the catalogue explains.
//
// 1. Screen all candidates on the residual of `none`; fit the best by score and whatever these data can't tell from the best fit.
// 2. Unless none is best, or nothing smooth is left to explain (3.): screen again on the best single (and on a second one that the
//    first one's form may hide, see 4.) and fit pairs; exchange each member of the best pair one for one; where the pair gains and takes
//    half off what is left, the same for triples; drop members backwards. Every model fitted on the way stays in the comparison.
// 3. Structure: does what the best models leave hold smooth shapes? z = Q^T r with Q an orthonormal basis of T D (fault modes of
//    every channel, K = 10), the model's own sensitivities projected out. Against N(0, I): z ~ N(0, (1 + a^2) I), a unknown,
//        log BF = log mean over a^2 in {1, 3, 10, ... 1e5} of (1 + a^2)^(-k/2) exp(|z|^2 a^2/(2 (1 + a^2))).
// 4. Form: no effect on hardware has quite the form that the plant gives it. Structure counts beyond 2.5 % of the log evidence that
//    the model gains over none (testbed: effects of the catalogue leave up to 1.5 %, those from outside 4 % and more), and every effect
//    beyond the first beyond 1 %.
// Posterior over all: prior x evidence, prior 0.5 none, 0.38 shared by singles, 0.09 by pairs, 0.02 by triples, each
// model's with a share of 1e-3 for "and something unknown".

#include <functional>
#include <string>
#include <vector>

#include "jaculus/diagnosis/screen.h"

namespace jaculus {

struct ModelFit {
  std::vector<int> candidates;  ///< sorted; empty: none
  Fit fit;
  double log_prior = 0.0;
  double structure = -kInfinity;     ///< log Bayes factor of unknown structure on top; -infinity: not tested
  double probability = 0.0;          ///< of the model without unknown structure
  double unknown_probability = 0.0;  ///< of the model with it
};

struct Selection {
  std::vector<ModelFit> models;  ///< most probable first (structure included)
  std::vector<Probe> probes;     ///< of all candidates about none
  std::vector<std::vector<int>>
      equivalent;                ///< a candidate each: those that its fitted signature can't be told from, itself first
  double none = 0.0;             ///< probability
  double unexplained = 0.0;      ///< probability
  std::vector<double> involved;  ///< a candidate each: probability that it is at work (and nothing unknown)
  long predictions = 0;
};

struct SelectionOptions {
  int kept = 8;  ///< singles fitted after screening
  int kept_pairs = 5;
  int largest = 3;           ///< effects at once
  double equivalence = 3.0;  ///< log Bayes factor below which two signatures are one class
  std::function<void(const std::string&)> progress;
};

/// `earlier`: a selection in another space, whose fits of singles are further starts here.
Selection select_models(const DiagnosisProblem& problem, const EvidenceSpace& space,
                        const SelectionOptions& options = {}, const Selection* earlier = nullptr);

/// log Bayes factor of smooth unknown structure in what a fit leaves.
double structure_evidence(const DiagnosisProblem& problem, const EvidenceSpace& space, const Fit& fit);

}  // namespace jaculus
