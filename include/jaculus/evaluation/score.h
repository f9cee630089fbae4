#pragma once
// Scoring of a diagnosis on blinded cases: datasets whose labels are encrypted until then.
//
// A case's truth is a single effect, a pair, none, or something outside the catalogue. A prediction
// is a diagnosis.json.
//   credit       single: 1/k where the prediction's set holds the true effect, k = 1 + members that
//                the generator's own sensitivities do not call equivalent to it; pair: true members
//                named over the larger of 2 and the set's size, equivalents counting as the member;
//                none: verdict none; outside: verdict unexplained; mixed: as single, for its named
//                part. Else 0. Cases in which left and right legs part are a class of their own.
//   log score    ln of the probability given to the truth (a class's members summed), not below ln
//                1e-3.
//   wrong and confident   the prediction's leading statement has p of 0.8 or more and is wrong.
//   parameter error       |estimate - true| / |true - nominal| of the first parameter of a rightly
//                         named single.
//   shrink       gap after over the gap that the true effect with fitted parameters reaches.
// Proportions carry Wilson intervals (95 %), means of credit percentile bootstrap ones
// from a fixed seed.

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "jaculus/core/tasks.h"
#include "jaculus/evaluation/case_scores.h"

namespace jaculus::evaluation {

struct Score {
  std::vector<CaseTruth> truths;
  std::vector<Metrics> metrics;  ///< the diagnosis first
  std::vector<Comparison> comparisons;
  std::string provenance;  ///< of the blinded batch: seed, commit, date
};

/// Scores and sums up. `predictions` by predictor: one prediction a truth, in its order;
/// "diagnosis" must be there.
Score score_predictions(const std::vector<CaseTruth>& truths,
                        const std::map<std::string, std::vector<Prediction>>& predictions);

std::string score_json(const Score& score);
std::string score_text(const Score& score);

struct ScoreOptions {
  std::filesystem::path binary;  ///< the jaculus program that diagnoses
  std::filesystem::path out;     ///< predictions are kept here, a folder a case, and the journal
  std::uint64_t seed = 1;
  int jobs = 0;
  bool resume = false;    ///< go on from the journal in `out`; else one that is there is an error
  bool baselines = true;  ///< run the baselines too
  double time_limit_s = 900.0;          ///< of one diagnosis
  std::vector<std::string> flags = {};  ///< further flags of `jaculus diagnose`
  std::function<void(const TaskProgress&)> progress = {};
  std::function<void(const std::string&)> notice = {};
};

/// Diagnoses every case of `folder` (a dataset each in folder/<case_id>) in a process of its own,
/// in a folder that holds a copy of that dataset and nothing else, with an environment without
/// labels or keys; then, and not before, calls `open_labels`, fits the true effects to see what gap
/// they leave, and scores. Writes score.json and score.txt into options.out. Empty `truths` in the
/// result: interrupted, resume goes on.
Score score_cases(const std::filesystem::path& folder, const std::vector<std::string>& case_ids,
                  const std::function<std::vector<CaseTruth>()>& open_labels,
                  const ScoreOptions& options);

}  // namespace jaculus::evaluation
