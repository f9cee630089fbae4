#pragma once
// Scoring of a diagnosis on blinded cases: datasets whose labels are encrypted until then.
//
// A case's truth is a single effect, several, none, something outside the catalogue, an effect and
// something outside it (mixed), or a push (event). A prediction is a diagnosis.json. Where
// docs/measures.md leaves room, the stricter reading is taken:
//   credit       single: 1/k where the prediction's set holds the true effect, k = 1 + members that
//                the generator's own sensitivities do not call equivalent to it; several: true
//                members named over the larger of their number and the set's size, equivalents
//                counting as the member; none: verdict none; outside: verdict unexplained; mixed:
//                as single, for its named part; event: found, and no effect named. Else 0. An
//                effect at one joint is named by its name with that joint among those said, or
//                without joints. Cases in which left and right legs part are a class of their own.
//   log score    ln of the probability given to the truth (a class's members summed), not below ln
//                1e-3. Event: where it is found, that of no effect (none and unexplained together);
//                else the floor, which also is of predictions that give no probability.
//   wrong and confident   the prediction's leading statement has p of 0.8 or more and is wrong; of
//                an event, also where nothing is named and the push is not told.
//   events       a said one that tells no true one (events.h), or tells it a second time in one
//                trial, is a false one. All pushes of a case have to be found.
//   coverage     of all parameters of rightly named effects, in cases of every kind.
//   parameter error       |estimate - true| / |true - nominal| of the first parameter of a rightly
//                         named single.
//   shrink       gap after over the gap that the true effect with fitted parameters reaches.
//   goals        met by the near end of the interval; of coverage the whole interval has to lie
//                within the aim.
// Proportions carry Wilson intervals (95 %), means of credit percentile bootstrap ones
// from a fixed seed.

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
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
  int sealed = 0;          ///< cases of the batch, of which truths may hold the first part
};

/// Scores and sums up. `predictions` by predictor: one prediction a truth, in its order;
/// "diagnosis" must be there.
Score score_predictions(const std::vector<CaseTruth>& truths,
                        const std::map<std::string, std::vector<Prediction>>& predictions);

/// The same bytes on every run of the same answers: what a case took is in timing_json alone.
std::string score_json(const Score& score);
std::string score_text(const Score& score);

/// Mean seconds of a case by answerer.
std::string timing_json(const Score& score);

struct ScoreOptions {
  std::filesystem::path binary;  ///< the jaculus program that diagnoses
  std::filesystem::path out;     ///< predictions are kept here, a folder a case, and the journal
  std::uint64_t seed = 1;
  int jobs = 0;
  bool resume = false;    ///< go on from the journal in `out`; else one that is there is an error
  bool baselines = true;  ///< run the baselines too
  /// answers of an earlier run, DIR/CASE/diagnosis.json: they are scored, nothing is diagnosed, and
  /// what could have been reached is left out; empty: the cases are diagnosed
  std::filesystem::path answers = {};
  std::optional<int> limit = {};  ///< only the first so many cases; a later run can go on to more
  std::string provenance = {};    ///< of the batch, for the result
  double time_limit_s = 900.0;    ///< of one diagnosis
  std::vector<std::string> flags = {};  ///< further flags of `jaculus diagnose`
  std::function<void(const TaskProgress&)> progress = {};
  std::function<void(const std::string&)> notice = {};
  std::shared_ptr<const Executor> executor = {};  ///< as of TaskOptions
};

/// Diagnoses every case of `folder` (in folder/<case_id> a dataset, or a group of them, set_1,
/// set_2..., that share a cause and are diagnosed together) in a process of its own,
/// in a folder that holds a copy of that case's datasets and nothing else, with an environment
/// without labels or keys; then, and not before, calls `open_labels`, fits the true effects to see
/// what gap they leave, and scores. Writes score.json and score.txt into options.out. Empty
/// `truths` in the result: interrupted, resume goes on.
Score score_cases(const std::filesystem::path& folder, const std::vector<std::string>& case_ids,
                  const std::function<std::vector<CaseTruth>()>& open_labels,
                  const ScoreOptions& options);

}  // namespace jaculus::evaluation
