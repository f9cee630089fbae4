#pragma once
// Probabilities as stated: how often such verdicts were right. The posterior knows noise and
// starts, not what the plant itself gets wrong, so it is nearly always sure where it names
// something. Of `right` in `cases` the next one is right with w = (right + 1)/(cases + 2)
// (Laplace's rule of succession). Where nothing is there the posterior is modest itself, for an
// effect too small to be told keeps its prior: it counts where it claims more than w for none.
//   rows of the ranking that the verdict reports: p = w x (their part of the reported rows'
//   posterior);
//   the others share 1 - w: unexplained, none, and the remaining effects by rank of their evidence,
//   each half of the one before.
// An effect's own probability is that of the reported rows that it is part of. Where effects are
// named beside others each may be right though not all are: then it is how often such an effect
// was.

#include <string>
#include <vector>

#include "jaculus/diagnosis/diagnosis.h"

namespace jaculus::diagnosis {

/// What a verdict was given beside, by which its reliability differs.
struct Circumstances {
  bool event = false;    ///< a push that every trial had, or something else that acts briefly
  bool doubted = false;  ///< something speaks against it: doubts()
};

/// How often a verdict was right, counted on cases that were blind for the programs that answered.
struct Reliability {
  Verdict verdict;
  Circumstances beside;              ///< of what is not, any
  int right, cases;                  ///< as counted
  double unexplained, none, others;  ///< parts of the rest
  const char* origin;                ///< robot and cases
  /// Effects named beside others or beside something more, and how many of them were right; 0: such
  /// a verdict names one thing.
  int named_right = 0, named = 0;

  /// Whether the posterior's word counts where it claims more.
  [[nodiscard]] bool by_posterior() const { return verdict == Verdict::none; }
  /// Probability that is stated for it.
  [[nodiscard]] double stated() const { return (right + 1.0) / (cases + 2.0); }
  [[nodiscard]] double stated_of_each() const { return (named_right + 1.0) / (named + 2.0); }
};
const std::vector<Reliability>& reliabilities();

/// What speaks against the one effect that is reported: another predicts held-out data nearly as
/// well, the gap was small from the start, or not all of it went. Empty for other verdicts.
std::vector<std::string> doubts(Verdict verdict, const HeldOut& gap,
                                const std::vector<FoundEffect>& effects,
                                const std::vector<Ranked>& ranking, const Settings& settings);

/// Effects and ranking with stated probabilities.
struct Calibrated {
  std::vector<FoundEffect> effects;
  std::vector<Ranked> ranking;  ///< sums to 1, most probable first
};
/// As they come where nothing was counted for the verdict.
Calibrated calibrate(Verdict verdict, const Circumstances& beside, std::vector<FoundEffect> effects,
                     std::vector<Ranked> ranking);

}  // namespace jaculus::diagnosis
