// Diagnoses of all cases, baselines beside them, then the labels.

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "evaluation/baselines.h"
#include "evaluation/run_diagnosis.h"
#include "jaculus/core/error.h"
#include "jaculus/core/journal.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/effects/select.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus {
namespace {

namespace fs = std::filesystem;

std::uint64_t hash_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(fmt::format("{}: can't be read; allowed: the jaculus program", file.string()));
  std::string block(1 << 20, '\0');
  std::uint64_t hash = hash64("");
  while (stream.read(block.data(), static_cast<std::streamsize>(block.size())) || stream.gcount() > 0)
    hash = hash64(std::string_view(block).substr(0, static_cast<std::size_t>(stream.gcount())), hash);
  return hash;
}

/// Everything that answers depend on: program, cases, flags, seed.
std::string fingerprint(const fs::path& folder, const std::vector<std::string>& case_ids, const ScoreOptions& options) {
  std::string text = fmt::format("{} {:x} {} {}", JACULUS_VERSION, hash_of(options.binary), options.seed,
                                 fs::weakly_canonical(folder).string());
  for (const std::string& flag : options.flags) text += " " + flag;
  for (const std::string& id : case_ids) text += " " + id;
  return text;
}

TaskOptions task_options(const ScoreOptions& options, const std::string& name, const std::string& key) {
  TaskOptions tasks;
  tasks.workers = options.jobs;
  tasks.journal = options.out / (name + ".journal");
  tasks.fingerprint = name + " " + key;
  tasks.progress = options.progress;
  tasks.notice = options.notice;
  if (fs::exists(tasks.journal) && !options.resume) {
    throw InputError(fmt::format("{}: answers of an earlier run are there; allowed: --resume, or another folder",
                                 tasks.journal.string()));
  }
  return tasks;
}

/// A task's answers in order, or nothing where it was interrupted.
bool take(const std::vector<TaskResult>& results, std::vector<std::string>& texts) {
  for (const TaskResult& result : results) {
    if (result.state == TaskState::cancelled) return false;
    CaseAnswer failed;
    failed.verdict = "failed";
    failed.message = result.error;
    texts.push_back(result.state == TaskState::done ? result.bytes : answer_to_text(failed));
  }
  return true;
}

bool diagnose_all(const fs::path& folder, const std::vector<std::string>& case_ids, const std::string& key,
                  const ScoreOptions& options, std::map<std::string, std::vector<CaseAnswer>>& answers) {
  const auto task = [&](int i) {
    const std::string& id = case_ids[static_cast<std::size_t>(i)];
    evaluation::DiagnosisRun run{options.binary, folder / id, options.out / "answers" / id, options.flags, 0, 0.0};
    run.seed = options.seed;
    run.time_limit_s = options.time_limit_s;
    return answer_to_text(evaluation::run_diagnosis(run));
  };
  std::vector<std::string> texts;
  const int count = static_cast<int>(case_ids.size());
  if (!take(run_tasks(count, task, task_options(options, "diagnosis", key)), texts)) return false;
  for (const std::string& text : texts) answers["diagnosis"].push_back(answer_from_text(text));
  return true;
}

bool run_baselines(const fs::path& folder, const std::vector<std::string>& case_ids, const std::string& key,
                   const ScoreOptions& options, std::map<std::string, std::vector<CaseAnswer>>& answers) {
  const std::vector<std::string>& names = evaluation::baseline_names();
  const auto task = [&](int i) {
    std::string lines;
    for (const CaseAnswer& a : evaluation::baseline_answers(folder / case_ids[static_cast<std::size_t>(i)]))
      lines += answer_to_text(a) + "\n";
    return lines;
  };
  TaskOptions tasks = task_options(options, "baselines", key);
  tasks.time_limit_s = options.time_limit_s;
  std::vector<std::string> texts;
  if (!take(run_tasks(static_cast<int>(case_ids.size()), task, tasks), texts)) return false;
  for (std::string text : texts) {
    if (text.empty() || text.back() != '\n') text += "\n";
    const bool failed = std::count(text.begin(), text.end(), '\n') != static_cast<std::ptrdiff_t>(names.size());
    for (const std::string& name : names) {
      const std::size_t end = text.find('\n');
      answers[name].push_back(answer_from_text(text.substr(0, end)));
      if (!failed) text.erase(0, end + 1);  // one line stands for all where the task failed
    }
  }
  return true;
}

/// Gap after that the true effects leave with their parameters fitted; NaN where the catalogue has none of them or none can be had.
double possible_gap(const fs::path& folder, const SealedTruth& truth) {
  DiagnoseOptions only;
  for (const std::string& name : truth.effects) only.effects.push_back(find_effect(name));
  if (only.effects.empty() || std::find(only.effects.begin(), only.effects.end(), nullptr) != only.effects.end())
    return kNaN;
  const HeldOut reached = held_out_with({read_dataset(folder / truth.case_id)}, only);
  return reached.valid ? reached.after : kNaN;
}

/// Fills in what could have been reached, once all answers are there; false where it was interrupted.
bool add_possible_gaps(const fs::path& folder, const std::string& key, const ScoreOptions& options,
                       std::vector<SealedTruth>& truths) {
  const auto task = [&](int i) { return fmt::format("{}", possible_gap(folder, truths[static_cast<std::size_t>(i)])); };
  const auto results = run_tasks(static_cast<int>(truths.size()), task, task_options(options, "possible", key));
  for (std::size_t i = 0; i < truths.size(); ++i) {
    if (results[i].state == TaskState::cancelled) return false;
    if (results[i].state == TaskState::done) truths[i].possible_after_gap = std::stod(results[i].bytes);
  }
  return true;
}

void check_cases(const fs::path& folder, const std::vector<std::string>& case_ids) {
  if (case_ids.empty()) throw InputError(fmt::format("{}: no case; allowed: one or more", folder.string()));
  for (const std::string& id : case_ids) {
    if (!fs::is_regular_file(folder / id / "dataset.yaml"))
      throw InputError(
          fmt::format("{}: no dataset.yaml; allowed: a dataset in every case's folder", (folder / id).string()));
  }
}

/// Truths in the order of the cases; an error where one is missing.
std::vector<SealedTruth> in_order(const std::vector<SealedTruth>& truths, const std::vector<std::string>& case_ids) {
  std::vector<SealedTruth> ordered;
  for (const std::string& id : case_ids) {
    const auto found =
        std::find_if(truths.begin(), truths.end(), [&](const SealedTruth& truth) { return truth.case_id == id; });
    if (found == truths.end()) throw InputError(fmt::format("labels: none for case '{}'; allowed: one a case", id));
    ordered.push_back(*found);
  }
  return ordered;
}

}  // namespace

Score score_cases(const fs::path& folder, const std::vector<std::string>& case_ids,
                  const std::function<std::vector<SealedTruth>()>& open_labels, const ScoreOptions& options) {
  check_cases(folder, case_ids);
  fs::create_directories(options.out);
  const std::string key = fingerprint(folder, case_ids, options);
  std::map<std::string, std::vector<CaseAnswer>> answers;
  if (!diagnose_all(folder, case_ids, key, options, answers)) return {};
  if (options.baselines && !run_baselines(folder, case_ids, key, options, answers)) return {};
  std::vector<SealedTruth> truths = in_order(open_labels(), case_ids);
  if (!add_possible_gaps(folder, key, options, truths)) return {};
  const Score score = score_answers(truths, answers);
  write_file(options.out / "score.json", score_json(score));
  write_file(options.out / "score.txt", score_text(score));
  return score;
}

}  // namespace jaculus
