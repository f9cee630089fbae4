#include "core/submission.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <optional>
#include <set>
#include <thread>

#include "core/run_local.h"
#include "core/slurm.h"
#include "core/stage_folder.h"
#include "core/worker.h"
#include "jaculus/core/error.h"
#include "jaculus/core/interrupt.h"

namespace jaculus::detail {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point time) {
  return std::chrono::duration<double>(Clock::now() - time).count();
}

// Chunks.
constexpr int kMostElements = 1000;  // Slurm's MaxArraySize is 1001 unless a site changes it
constexpr int kEnoughElements = 64;  // more nodes than that are rarely free at once
// Slurm takes up to a second from one element to the next: 3 % of this.
constexpr double kLeastChunk_s = 30.0;
// The first tasks run where the command was given, to size chunks.
constexpr int kPilotTasks = 4;
constexpr double kPilot_s = 10.0;  // a login node is shared
// Slurm is asked every 2 % of the time that has passed, so that an end is not noticed late.
constexpr double kPaceShare = 0.02, kLeastPace_s = 0.3, kMostPace_s = 10.0;
// Until what a job wrote last is seen from here.
constexpr double kSettle_s = 2.0,
                 kSettleComplete_s = std::chrono::duration<double>(kNfsDelay).count();

/// An element of which results are missing.
struct Watched {
  std::vector<int> indices;
  bool own = true;  ///< submitted by this process; else by an earlier one
  ElementState state;
  std::optional<Clock::time_point> ended = {};
};

class Submission {
 public:
  Submission(const std::vector<TaskResult>& known, int total,
             const std::function<std::string(int)>& task, const TaskOptions& options,
             const std::string& key, const std::function<void(int, TaskResult)>& take)
      : task_(task),
        options_(options),
        executor_(*options.executor),
        take_(take),
        folder_(executor_.folder / options.stage) {
    folder_.open(options.stage, count_of(known), key);
    folder_.set_asked(total);
    for (int i = 0; i < total; ++i)
      if (known[i].state == TaskState::cancelled) open_.insert(i);
    adopt();
    own_done_.emplace(folder_.file("done", "0.0.0"), key, JournalLock::sole_writer);
    own_failed_.emplace(folder_.file("failed", "0.0.0"), key, JournalLock::sole_writer);
    keep(known);
  }

  void run() {
    if (!waiting_.empty() && !folder_.cost_s()) pilot();
    while (!open_.empty() && !interrupt_requested()) {
      if (!waiting_.empty()) submit_waiting();
      pause();
      look();
      collect("done");
      collect("failed");
      settle();
    }
    if (open_.empty()) folder_.set_finished(count_of(kept_));
    if (interrupt_requested())
      for (const auto& [round, job] : jobs_) cancel_job(job);
  }

 private:
  void notice(const std::string& text) const {
    if (options_.notice) options_.notice(text);
  }

  /// Hands over what workers have finished.
  void collect(const char* kind) {
    const bool done = std::string_view(kind) == "done";
    for (auto& [index, bytes] : folder_.fresh(kind)) {
      kept_.insert(index);
      lost_in_a_row_ = 0;
      if (open_.erase(index) == 0) continue;
      waiting_.erase(index);
      take_(index, done ? TaskResult{TaskState::done, std::move(bytes), "", false}
                        : TaskResult{TaskState::failed, "", std::move(bytes), false});
    }
  }

  /// Elements of an earlier submission that still wait or run go on; its failures are tried again.
  void adopt() {
    for (int number = 1; number <= folder_.rounds(); ++number) {
      const Round round = folder_.round(number);
      if (round.job.empty()) continue;
      for (int c = 0; c < count_of(round.chunks); ++c)
        watched_[{number, c}] = {open_of(round.chunks[c]), false, {}, {}};
      jobs_[number] = round.job;
    }
    look();
    collect("done");  // after Slurm was asked: what has ended has written all that it will
    std::erase_if(watched_, [&](const auto& entry) {
      const auto& [element, watched] = entry;
      const bool finished = open_of(watched.indices).empty();
      if (!finished && watched.ended) folder_.give_up(element);
      return finished || watched.ended;
    });

    std::set<int> under_way;
    for (const auto& [element, watched] : watched_)
      under_way.insert(watched.indices.begin(), watched.indices.end());
    for (const int index : open_)
      if (!under_way.contains(index)) waiting_.insert(index);
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_.path() / "failed")) {
      const std::string name = entry.path().filename();
      const bool alive = std::any_of(watched_.begin(), watched_.end(), [&](const auto& w) {
        return name.starts_with(w.first.name() + ".");
      });
      if (!alive) fs::remove(entry.path());
    }
  }

  /// What a run without an executor has finished, for the workers of lists behind this one.
  void keep(const std::vector<TaskResult>& known) {
    for (int i = 0; i < count_of(known); ++i)
      if (known[i].state == TaskState::done && kept_.insert(i).second)
        own_done_->append(i, known[i].bytes);
  }

  [[nodiscard]] std::vector<int> open_of(const std::vector<int>& indices) const {
    std::vector<int> missing;
    for (const int index : indices)
      if (open_.contains(index)) missing.push_back(index);
    return missing;
  }

  void pilot() {
    const auto begin = Clock::now();
    int ran = 0;
    LocalRun run;
    run.workers = 1;
    run.time_limit_s = std::min(options_.time_limit_s, kPilot_s);
    run.end = [&](int index, const TaskResult& result) {
      ++ran;
      const bool cut = result.state == TaskState::failed && seconds_since(begin) >= kPilot_s;
      if (cut || result.state == TaskState::cancelled) return;
      finish(index, result);
    };
    const std::vector<int> waiting(waiting_.begin(), waiting_.end());
    for (const int index : waiting) {
      if (ran >= kPilotTasks || seconds_since(begin) >= kPilot_s || interrupt_requested()) break;
      run_local({index}, task_, run);
    }
    if (!interrupt_requested()) folder_.set_cost(std::max(1e-4, seconds_since(begin) / ran));
  }

  /// A result of this process's own, kept beside the workers'.
  void finish(int index, const TaskResult& result) {
    Journal& journal = result.state == TaskState::done ? *own_done_ : *own_failed_;
    journal.append(index, result.state == TaskState::done ? result.bytes : result.error);
    kept_.insert(index);
    open_.erase(index);
    waiting_.erase(index);
    take_(index, result);
  }

  void submit_waiting() {
    // one that Slurm did not take has its files there already
    const int number = folder_.rounds() + (refused_ ? 0 : 1);
    const auto chunks =
        chunks_of({waiting_.begin(), waiting_.end()}, *folder_.cost_s(), executor_.chunk_s);
    folder_.write_round(number, chunks);
    const fs::path script = folder_.path() / fmt::format("round_{}.sh", number);
    write_script(script, number);

    const auto job = submitted(
        {"jaculus_" + options_.stage, count_of(chunks), fs::current_path(), fs::absolute(script),
         fs::absolute(folder_.path() / "log").string() + fmt::format("/{}.%a.txt", number),
         executor_.options});
    refused_ = !job;
    if (refused_) return;
    jobs_[number] = *job;
    folder_.write_job(number, *job);
    for (int c = 0; c < count_of(chunks); ++c) watched_[{number, c}] = {chunks[c], true, {}, {}};
    most_elements_ = std::max(most_elements_, count_of(chunks));
    notice(fmt::format("{}: {} tasks in {} elements of Slurm job {}", options_.stage,
                       waiting_.size(), chunks.size(), *job));
    waiting_.clear();
  }

  /// The job's id. Nothing where Slurm, which took an array of this run before, doesn't take one
  /// now (out of reach, a user's quota of jobs): it is asked again. InputError for the first.
  [[nodiscard]] std::optional<std::string> submitted(const Array& array) {
    try {
      return submit_array(array);
    } catch (const InputError& error) {
      if (most_elements_ == 0) throw;
      if (told_.insert(error.what()).second)
        notice(fmt::format("Slurm takes no jobs, trying again: {}", error.what()));
      return std::nullopt;
    }
  }

  void write_script(const fs::path& script, int round) const {
    std::string text = fmt::format("#!/bin/sh\nexport {}={}\nexec", kWorkerVariable,
                                   shell_quoted(fmt::format("{} {}", round, options_.stage)));
    for (const std::string& word : executor_.command) text += " " + shell_quoted(word);
    std::ofstream stream(script);
    stream << text << "\n";
    stream.close();
    if (!stream) throw InputError(fmt::format("{}: can't be written", script.string()));
  }

  void pause() const {
    const double pace = std::clamp(kPaceShare * seconds_since(begin_), kLeastPace_s, kMostPace_s);
    const auto begin = Clock::now();
    while (seconds_since(begin) < pace && !interrupt_requested())
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }

  /// Asks Slurm for the elements that are watched.
  void look() {
    std::set<int> rounds;
    for (const auto& [element, watched] : watched_) rounds.insert(element.round);
    for (const int round : rounds) {
      std::string trouble;
      const auto states = element_states(jobs_[round], &trouble);
      if (!states) {
        if (told_.insert(trouble).second) notice("Slurm doesn't answer, waiting: " + trouble);
        continue;
      }
      for (auto& [element, watched] : watched_)
        if (element.round == round) update(watched, *states, element.chunk);
    }
  }

  void update(Watched& watched, const std::map<int, ElementState>& states, int chunk) {
    const auto found = states.find(chunk);
    if (found != states.end() && !found->second.ended()) {
      watched.ended.reset();  // requeued
      watched.state = found->second;
      const std::string& why = watched.state.reason;
      const bool stuck = why.find("eld") != std::string::npos;  // held, by user, admin or launch
      if (stuck && told_.insert(why).second)
        notice(fmt::format("an element waits and will not start by itself: {}", why));
      return;
    }
    if (found != states.end()) watched.state = found->second;
    if (!watched.ended) watched.ended = Clock::now();
  }

  /// Leaves elements that are finished, and gives back what lost ones have not done.
  void settle() {
    for (auto entry = watched_.begin(); entry != watched_.end();) {
      auto& [element, watched] = *entry;
      const std::vector<int> missing = open_of(watched.indices);
      const double patience = watched.state.state == "COMPLETED" ? kSettleComplete_s : kSettle_s;
      const bool over = watched.ended && seconds_since(*watched.ended) >= patience;
      if (!missing.empty() && over) lose(element, watched, missing);
      entry = missing.empty() || over ? watched_.erase(entry) : std::next(entry);
    }
  }

  void lose(const Element& element, const Watched& watched, const std::vector<int>& missing) {
    const std::string state =
        watched.ended && watched.state.ended() ? watched.state.state : "no longer known to Slurm";
    const std::string words = folder_.last_words(element);
    const std::string how =
        fmt::format("{}{}{}", state, watched.state.node.empty() ? "" : " on " + watched.state.node,
                    words.empty() ? "" : ": " + words);
    notice(fmt::format("element {} of {} was lost ({}); {} of its {} tasks run again",
                       element.name(), options_.stage, how, missing.size(),
                       watched.indices.size()));

    folder_.give_up(element);
    for (const int index : missing) waiting_.insert(index);
    if (watched.own && state != "PREEMPTED") blame(element, missing, how);
  }

  void blame(const Element& element, const std::vector<int>& missing, const std::string& how) {
    std::vector<int> under_way = open_of(folder_.begun(element));
    if (under_way.empty()) under_way = missing;  // it never got that far
    for (const int index : under_way)
      if (++losses_[index] >= kMostLosses)
        fail(index, fmt::format("its job was lost {} times, at last {}", kMostLosses, how));

    if (++lost_in_a_row_ < kMostLosses * most_elements_) return;
    const std::vector<int> waiting(waiting_.begin(), waiting_.end());
    for (const int index : waiting)
      fail(index, fmt::format("{} jobs in a row were lost without a result, at last {}",
                              lost_in_a_row_, how));
  }

  void fail(int index, const std::string& why) {
    finish(index, {TaskState::failed, "", why, false});
  }

  const std::function<std::string(int)>& task_;
  const TaskOptions& options_;
  const Executor& executor_;
  const std::function<void(int, TaskResult)>& take_;
  StageFolder folder_;
  std::set<int> open_;     ///< without a result
  std::set<int> waiting_;  ///< of these, in no element
  std::set<int> kept_;     ///< in a journal of the folder
  std::map<Element, Watched> watched_;
  std::map<int, std::string> jobs_;  ///< by round
  std::map<int, int> losses_;
  int lost_in_a_row_ = 0, most_elements_ = 0;
  bool refused_ = false;  ///< the last array
  std::set<std::string> told_;
  std::optional<Journal> own_done_, own_failed_;  ///< of this process
  Clock::time_point begin_ = Clock::now();
};

}  // namespace

std::vector<std::vector<int>> chunks_of(const std::vector<int>& indices, double cost_s,
                                        double chunk_s) {
  const double total_s = cost_s * static_cast<double>(indices.size());
  const double size_s =
      std::clamp(total_s / kEnoughElements, std::min(kLeastChunk_s, chunk_s), chunk_s);
  const std::size_t least = (indices.size() + kMostElements - 1) / kMostElements;
  const std::size_t size =
      std::max({std::size_t{1}, least, static_cast<std::size_t>(std::lround(size_s / cost_s))});

  std::vector<std::vector<int>> chunks;
  for (std::size_t first = 0; first < indices.size(); first += size) {
    const std::size_t last = std::min(first + size, indices.size());
    chunks.emplace_back(indices.begin() + static_cast<std::ptrdiff_t>(first),
                        indices.begin() + static_cast<std::ptrdiff_t>(last));
  }
  return chunks;
}

void submit(const std::vector<TaskResult>& known, int total,
            const std::function<std::string(int)>& task, const TaskOptions& options,
            const std::string& key, const std::function<void(int, TaskResult)>& take) {
  Submission(known, total, task, options, key, take).run();
}

}  // namespace jaculus::detail
