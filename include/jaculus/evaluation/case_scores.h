#pragma once
// How predictions do against their truths: a score each, and metrics of a set of cases. The rules:
// score.h.

#include <map>
#include <string>
#include <vector>

#include "jaculus/evaluation/predictions.h"

namespace jaculus::evaluation {

/// How one prediction does against its truth.
struct CaseScore {
  double credit = 0.0;
  double log_score = 0.0;
  /// the leading statement: an effect, a set "a|b", "none", "unexplained", "insufficient"
  std::string stated;
  double confidence = 0.0;  ///< its probability
  bool right = false;       ///< whether the truth is in it
  bool top1 = false;  ///< the most probable effect (or verdict) is the truth or equivalent to it
  bool component_right = false;
  double parameter_error = kNaN;
  int parameters_covered = 0, parameters_judged = 0;  ///< intervals that hold the true value
  double shrink_ratio = kNaN;                         ///< gap after / possible gap after
  /// share of the gap's energy above the floor that is explained, over that of the true effects
  double energy_ratio = kNaN;
  bool remainder = false;  ///< whether the prediction says that more is there than it names
  int events_found = 0, events_invented = 0;  ///< pushes told rightly; said and not there
  bool described = false;                     ///< whether a pattern is said of what is left
  /// of the kind that no catalogue holds (descriptions.h)
  bool place_right = false;
  double family_credit = 0.0;
};
CaseScore score_case(const CaseTruth& truth, const Prediction& prediction);

/// A proportion or mean with its 95 % interval.
struct ScoreEstimate {
  double value = kNaN;
  Bounds ci95{kNaN, kNaN};
  int count = 0;  ///< cases behind it
};

struct ReliabilityBin {
  Bounds probability;
  double stated = kNaN;  ///< mean probability in the bin
  ScoreEstimate right;
};

/// Everything about one predictor on a set of cases.
struct Metrics {
  std::string predictor;          ///< "diagnosis" or a baseline
  std::vector<CaseScore> scores;  ///< a case each
  /// "singles credit at 3 or more", "false alarms", ... in words
  std::map<std::string, ScoreEstimate> by;
  std::map<std::string, ScoreEstimate> credit_by_effect;
  std::map<std::string, ScoreEstimate> credit_by_strength;
  std::map<std::string, std::map<std::string, int>> confusion;  ///< truth -> stated -> cases
  std::vector<ReliabilityBin> reliability;
  double calibration_error = kNaN;  ///< mean |stated - right| over bins, weighted by cases
  ScoreEstimate seconds;  ///< [s] that a case took; not in `by`, which is the same on every run
};

/// A baseline against the diagnosis on the same cases, paired.
struct Comparison {
  std::string predictor;
  ScoreEstimate log_score_gain, accuracy_gain;  ///< diagnosis minus baseline
};

}  // namespace jaculus::evaluation
