#pragma once
// Scoring of a diagnosis on sealed cases: datasets whose effect is known to the sealer alone.
//
// A case's truth is a single effect, a pair, none, or something outside the catalogue. An answer is a diagnosis.json.
//   credit       single: 1/k where the answer's set holds the true effect, k = 1 + members that the generator's own sensitivities
//                do not call equivalent to it; pair: true members named over the larger of 2 and the set's size, equivalents
//                counting as the member; none: verdict none; outside: verdict unexplained. Else 0.
//   log score    ln of the probability given to the truth (a class's members summed), not below ln 1e-3.
//   wrong and confident   the answer's leading statement has p > 0.8 and is wrong.
//   parameter error       |estimate - true| / |true - nominal| of the first parameter of a rightly named single.
//   shrink       gap after over the gap that the true effect with fitted parameters reaches.
// Proportions carry Clopper-Pearson intervals (95 %), means of credit percentile bootstrap ones from a fixed seed.

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "jaculus/core/tasks.h"
#include "jaculus/core/types.h"

namespace jaculus {

/// What was sealed of one case.
struct SealedTruth {
  std::string case_id;                          ///< opaque; the dataset's folder
  std::string kind;                             ///< "single", "pair", "none", "outside"
  std::vector<std::string> effects;             ///< names in the catalogue; of outside the generator's own names
  std::vector<std::vector<double>> parameters;  ///< an effect each, in the catalogue's order and terms; NaN: not known
  double strength_in_noise_floors = 0.0;  ///< rms of the gap over all channels, beyond clocks and starts [noise floors]
  std::vector<std::string> parted;        ///< draws before it that were left out because left and right legs part
  std::vector<std::string> equivalent;  ///< effects that the generator can't tell from the true ones in this experiment
  std::string component;                ///< where it acts, by component_name; empty: not scored
  double possible_after_gap = kNaN;     ///< what the true effect with fitted parameters leaves [noise floors]
};

/// An effect as an answer names it.
struct NamedEffect {
  std::string name;
  double probability = 0.0;
  std::map<std::string, double> parameters;  ///< by the name shown, "stiffness"
  std::map<std::string, Bounds> ci95;
};

/// What a diagnosis.json says, or that there is none.
struct CaseAnswer {
  std::string
      verdict;  ///< "effect", "several", "ambiguous", "none", "unexplained", "insufficient"; "failed": no answer came
  std::string message;  ///< why failed
  std::vector<NamedEffect> effects;
  std::map<std::string, double> ranking;       ///< probability by effect; may hold "none" and "unexplained"
  std::map<std::string, double> components;    ///< share by component
  double gap_before = kNaN, gap_after = kNaN;  ///< [noise floors]
  double seconds = kNaN;                       ///< that it took; NaN where not known
};

/// Reads a diagnosis.json. InputError (file: key path: what) where it is none.
CaseAnswer read_answer(const std::filesystem::path& file);
std::string answer_to_text(const CaseAnswer& answer);  ///< JSON, one line
CaseAnswer answer_from_text(const std::string& text);

/// How one answer does against its truth.
struct CaseMark {
  double credit = 0.0;
  double log_score = 0.0;
  std::string stated;       ///< the leading statement: an effect, a set "a|b", "none", "unexplained", "insufficient"
  double confidence = 0.0;  ///< its probability
  bool right = false;       ///< whether the truth is in it
  bool top1 = false;        ///< the most probable effect (or verdict) is the truth or equivalent to it
  bool component_right = false;
  double parameter_error = kNaN;
  int parameters_covered = 0, parameters_judged = 0;  ///< intervals that hold the true value
  double shrink_ratio = kNaN;                         ///< gap after / possible gap after
};
CaseMark mark_answer(const SealedTruth& truth, const CaseAnswer& answer);

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

/// Everything about one answerer on a set of cases.
struct ScoreSheet {
  std::string answerer;                     ///< "diagnosis" or a baseline
  std::vector<CaseMark> marks;              ///< a case each
  std::map<std::string, ScoreEstimate> by;  ///< "singles credit at 3 or more", "false alarms", ... in words
  std::map<std::string, ScoreEstimate> credit_by_effect;
  std::map<std::string, ScoreEstimate> credit_by_strength;
  std::map<std::string, std::map<std::string, int>> confusion;  ///< truth -> stated -> cases
  std::vector<ReliabilityBin> reliability;
  double calibration_error = kNaN;  ///< mean |stated - right| over bins, weighted by cases
};

/// A baseline against the diagnosis on the same cases, paired.
struct Comparison {
  std::string answerer;
  ScoreEstimate log_score_gain, accuracy_gain;  ///< diagnosis minus baseline
};

struct Score {
  std::vector<SealedTruth> truths;
  std::vector<ScoreSheet> sheets;  ///< the diagnosis first
  std::vector<Comparison> comparisons;
  std::string provenance;  ///< of the sealed batch: seed, commit, date
};

/// Marks and sums up. `answers` by answerer: one answer a truth, in its order; "diagnosis" must be there.
Score score_answers(const std::vector<SealedTruth>& truths,
                    const std::map<std::string, std::vector<CaseAnswer>>& answers);

std::string score_json(const Score& score);
std::string score_text(const Score& score);

struct ScoreOptions {
  std::filesystem::path binary;  ///< the jaculus program that diagnoses
  std::filesystem::path out;     ///< answers are kept here, a folder a case, and the journal
  std::uint64_t seed = 1;
  int jobs = 0;
  bool resume = false;                  ///< go on from the journal in `out`; else one that is there is an error
  bool baselines = true;                ///< run the baselines too
  double time_limit_s = 900.0;          ///< of one diagnosis
  std::vector<std::string> flags = {};  ///< further flags of `jaculus diagnose`
  std::function<void(const TaskProgress&)> progress = {};
  std::function<void(const std::string&)> notice = {};
};

/// Diagnoses every case of `folder` (a dataset each in folder/<case_id>) in a process of its own, in a folder that holds a copy
/// of that dataset and nothing else, with an environment without labels or keys; then, and not before, calls `open_labels`,
/// fits the true effects to see what gap they leave, and scores. Writes score.json and score.txt into options.out. Empty `truths` in the result: interrupted, resume goes on.
Score score_cases(const std::filesystem::path& folder, const std::vector<std::string>& case_ids,
                  const std::function<std::vector<SealedTruth>()>& open_labels, const ScoreOptions& options);

}  // namespace jaculus
