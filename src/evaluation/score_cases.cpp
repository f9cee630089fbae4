// Diagnoses of all cases, baselines beside them, then the labels.

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>

#include "evaluation/baselines.h"
#include "evaluation/names.h"
#include "evaluation/run_diagnosis.h"
#include "jaculus/core/error.h"
#include "jaculus/core/executor.h"
#include "jaculus/core/installation.h"
#include "jaculus/core/journal.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/testbed/blinded_cases.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::evaluation {
namespace {

namespace fs = std::filesystem;

std::uint64_t hash_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw InputError(fmt::format("{}: can't be read; allowed: the jaculus program", file.string()));
  std::string block(1 << 20, '\0');
  std::uint64_t hash = hash64("");
  while (stream.read(block.data(), block.size()) || stream.gcount() > 0)
    hash = hash64(std::string_view(block).substr(0, stream.gcount()), hash);
  return hash;
}

/// Everything that predictions depend on: program, cases, flags, seed.
std::string fingerprint(const fs::path& folder, const std::vector<std::string>& case_ids,
                        const ScoreOptions& options) {
  std::string text = fmt::format("{} {:x} {} {}", version(), hash_of(options.binary), options.seed,
                                 fs::weakly_canonical(folder).string());
  for (const std::string& flag : options.flags) text += " " + flag;
  for (const std::string& id : case_ids) text += " " + id;
  return text;
}

TaskOptions task_options(const ScoreOptions& options, const std::string& name,
                         const std::string& key) {
  TaskOptions tasks;
  tasks.workers = options.jobs;
  tasks.journal = options.out / (name + ".journal");
  tasks.fingerprint = name + " " + key;
  tasks.progress = options.progress;
  tasks.notice = options.notice;
  tasks.until = options.limit;
  tasks.executor = options.executor;
  tasks.stage = name;
  const bool worker = options.executor && !worker_stage().empty();  // the journal is not its own
  if (fs::exists(tasks.journal) && !options.resume && !worker) {
    throw InputError(
        fmt::format("{}: answers of an earlier run are there; allowed: --resume, or another folder",
                    tasks.journal.string()));
  }
  return tasks;
}

/// How many of the cases are to be scored.
int scored(const std::vector<std::string>& case_ids, const ScoreOptions& options) {
  return std::min(count_of(case_ids), options.limit.value_or(count_of(case_ids)));
}

/// Predictions of the first `count` tasks in order, or nothing where one was interrupted.
bool take(const std::vector<TaskResult>& results, int count, std::vector<std::string>& texts) {
  for (int i = 0; i < count; ++i) {
    const TaskResult& result = results[i];
    if (result.state == TaskState::cancelled) return false;
    Prediction failed;
    failed.message = result.error;
    texts.push_back(result.state == TaskState::done ? result.bytes : prediction_to_text(failed));
  }
  return true;
}

bool diagnose_all(const fs::path& folder, const std::vector<std::string>& case_ids,
                  const std::string& key, const ScoreOptions& options,
                  std::map<std::string, std::vector<Prediction>>& predictions) {
  const auto task = [&](int i) {
    const std::string& id = case_ids[i];
    evaluation::DiagnosisRun run{options.binary, folder / id, options.out / "answers" / id,
                                 options.flags,  0,           0.0};
    run.seed = options.seed;
    run.time_limit_s = options.time_limit_s;
    return prediction_to_text(evaluation::run_diagnosis(run));
  };
  std::vector<std::string> texts;
  const auto results = run_tasks(count_of(case_ids), task, task_options(options, "diagnosis", key));
  if (!take(results, scored(case_ids, options), texts)) return false;
  for (const std::string& text : texts)
    predictions["diagnosis"].push_back(prediction_from_text(text));
  return true;
}

bool run_baselines(const fs::path& folder, const std::vector<std::string>& case_ids,
                   const std::string& key, const ScoreOptions& options,
                   std::map<std::string, std::vector<Prediction>>& predictions) {
  const std::vector<std::string>& names = evaluation::baseline_names();
  const auto task = [&](int i) {
    std::string lines;
    for (const Prediction& a : baseline_answers(testbed::case_datasets(folder / case_ids[i])))
      lines += prediction_to_text(a) + "\n";
    return lines;
  };

  TaskOptions tasks = task_options(options, "baselines", key);
  tasks.time_limit_s = options.time_limit_s;
  std::vector<std::string> texts;
  const auto results = run_tasks(count_of(case_ids), task, tasks);
  if (!take(results, scored(case_ids, options), texts)) return false;
  for (std::string text : texts) {
    if (text.empty() || text.back() != '\n') text += "\n";
    const bool failed = std::count(text.begin(), text.end(), '\n') != std::ssize(names);
    for (const std::string& name : names) {
      const std::size_t end = text.find('\n');
      predictions[name].push_back(prediction_from_text(text.substr(0, end)));
      if (!failed) text.erase(0, end + 1);  // one line stands for all where the task failed
    }
  }

  return true;
}

std::optional<PossibleGap> possible_gap(const fs::path& folder, const CaseTruth& truth) {
  std::vector<effects::Effect> actual;
  for (const std::string& name : truth.effects)
    if (auto effect = placed_effect(name)) actual.push_back(std::move(*effect));
  if (actual.empty() || actual.size() != truth.effects.size()) return {};

  diagnosis::DiagnoseOptions only;
  for (const effects::Effect& effect : actual) only.effects.push_back(&effect);
  std::vector<trajectory::Dataset> datasets;
  for (const fs::path& dataset : testbed::case_datasets(folder / truth.case_id))
    datasets.push_back(trajectory::read_dataset(dataset));
  const diagnosis::HeldOut reached = diagnosis::held_out_with(datasets, only);
  if (!reached.valid) return PossibleGap{};
  return PossibleGap{reached.after, reached.adjusted, reached.log_gain};
}

/// Empty where there is none.
std::string possible_text(const std::optional<PossibleGap>& gap) {
  return gap ? fmt::format("{} {} {}", gap->after, gap->tolerances, gap->log_gain) : "";
}

/// stod, for streams don't read NaN.
std::optional<PossibleGap> possible_of(const std::string& text) {
  if (text.empty()) return {};
  std::istringstream words(text);
  PossibleGap gap;
  for (double* value : {&gap.after, &gap.tolerances, &gap.log_gain})
    if (std::string word; words >> word) *value = std::stod(word);
  return gap;
}

/// Fills in what could have been reached, once all predictions are there; false where it was
/// interrupted.
bool add_possible_gaps(const fs::path& folder, int sealed, const std::string& key,
                       const ScoreOptions& options, std::vector<CaseTruth>& truths) {
  const auto task = [&](int i) { return possible_text(possible_gap(folder, truths[i])); };
  const auto results = run_tasks(sealed, task, task_options(options, "possible", key));
  for (std::size_t i = 0; i < truths.size(); ++i) {
    if (results[i].state == TaskState::cancelled) return false;
    truths[i].possible =
        results[i].state == TaskState::done ? possible_of(results[i].bytes) : PossibleGap{};
  }
  return true;
}

/// The answers that an earlier run kept; one that is missing is none.
std::vector<Prediction> kept_answers(const fs::path& answers,
                                     const std::vector<std::string>& case_ids) {
  std::vector<Prediction> predictions;
  for (const std::string& id : case_ids) {
    const fs::path file = answers / id / "diagnosis.json";
    predictions.push_back(fs::exists(file) ? read_prediction(file) : Prediction());
  }
  return predictions;
}

void check_cases(const fs::path& folder, const std::vector<std::string>& case_ids) {
  if (case_ids.empty())
    throw InputError(fmt::format("{}: no case; allowed: one or more", folder.string()));
  for (const std::string& id : case_ids) {
    if (testbed::case_datasets(folder / id).empty())
      throw InputError(
          fmt::format("{}: no dataset.yaml, nor set_1/dataset.yaml; allowed: a dataset or a group "
                      "of them in every case's folder",
                      (folder / id).string()));
  }
}

/// Truths in the order of the cases; an error where one is missing.
std::vector<CaseTruth> in_order(const std::vector<CaseTruth>& truths,
                                const std::vector<std::string>& case_ids) {
  std::vector<CaseTruth> ordered;
  for (const std::string& id : case_ids) {
    const auto found = std::find_if(truths.begin(), truths.end(),
                                    [&](const CaseTruth& truth) { return truth.case_id == id; });
    if (found == truths.end())
      throw InputError(fmt::format("labels: none for case '{}'; allowed: one a case", id));
    ordered.push_back(*found);
  }
  return ordered;
}

}  // namespace

Score score_cases(const fs::path& folder, const std::vector<std::string>& case_ids,
                  const std::function<std::vector<CaseTruth>()>& open_labels,
                  const ScoreOptions& options) {
  check_cases(folder, case_ids);
  fs::create_directories(options.out);
  const std::string key = fingerprint(folder, case_ids, options);
  const std::vector<std::string> first(case_ids.begin(),
                                       case_ids.begin() + scored(case_ids, options));
  std::map<std::string, std::vector<Prediction>> predictions;
  const bool kept = !options.answers.empty();
  if (kept) predictions["diagnosis"] = kept_answers(options.answers, first);
  if (!kept && !diagnose_all(folder, case_ids, key, options, predictions)) return {};
  if (!kept && options.baselines && !run_baselines(folder, case_ids, key, options, predictions))
    return {};

  std::vector<CaseTruth> truths = in_order(open_labels(), first);
  if (!kept && !add_possible_gaps(folder, count_of(case_ids), key, options, truths)) return {};
  Score score = score_predictions(truths, predictions);
  score.sealed = count_of(case_ids);
  score.provenance = options.provenance;
  trajectory::write_file(options.out / "timing.json", timing_json(score));
  trajectory::write_file(options.out / "score.json", score_json(score));
  trajectory::write_file(options.out / "score.txt", score_text(score));
  if (options.executor) remove_jobs(*options.executor);
  return score;
}

}  // namespace jaculus::evaluation
