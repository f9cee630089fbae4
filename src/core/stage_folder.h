#pragma once
// The folder of one list of tasks on a cluster; executor.h has what is in it.

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "jaculus/core/journal.h"

namespace jaculus::detail {

/// Until what another machine wrote is seen here: NFS caches what a folder holds so long.
inline constexpr std::chrono::seconds kNfsDelay(60);

/// Indices as text and back: "0-24,30".
std::string ranges_text(const std::vector<int>& indices);
std::vector<int> ranges_of(const std::string& text);

/// An element of an array: a chunk of a round.
struct Element {
  int round = 0, chunk = 0;
  [[nodiscard]] std::string name() const;                ///< "1.7"
  [[nodiscard]] std::string worker(int restarts) const;  ///< "1.7.0"; requeued once: "1.7.1"
  auto operator<=>(const Element&) const = default;
};

struct Round {
  std::vector<std::vector<int>> chunks;
  std::string job;  ///< Slurm's id; empty: never submitted
};

class StageFolder {
 public:
  explicit StageFolder(std::filesystem::path path) : path_(std::move(path)) {}

  /// Makes the folder for this list. InputError where it belongs to another one.
  void open(const std::string& stage, int count, const std::string& key);
  /// InputError where the folder is no stage's.
  void read();

  [[nodiscard]] const std::string& stage() const { return stage_; }
  [[nodiscard]] const std::string& key() const { return key_; }
  [[nodiscard]] int count() const { return count_; }

  /// Mean of the first tasks [s], where they have been measured.
  [[nodiscard]] std::optional<double> cost_s() const { return cost_s_; }
  void set_cost(double cost_s);

  /// How many of the tasks, from the first on, are asked for: all, unless a run has a limit.
  [[nodiscard]] int asked() const { return asked_.value_or(count_); }
  void set_asked(int asked);

  /// How many results there are, where all that was asked for is there.
  [[nodiscard]] std::optional<int> finished() const { return finished_; }
  void set_finished(int finished);

  [[nodiscard]] int rounds() const;  ///< the last one's number
  [[nodiscard]] Round round(int number) const;
  void write_round(int number, const std::vector<std::vector<int>>& chunks) const;
  void write_job(int number, const std::string& job) const;

  [[nodiscard]] std::filesystem::path file(const char* folder, const std::string& name) const {
    return path_ / folder / name;
  }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  /// Records of `folder` (done or failed) that came since the last call, of all elements.
  std::map<int, std::string> fresh(const char* folder);
  /// Indices that an element's workers began.
  [[nodiscard]] std::vector<int> begun(const Element& element) const;
  /// Whether an element's worker should end: it was requeued meanwhile, or given up. A node that
  /// Slurm lost sight of may still work.
  [[nodiscard]] bool superseded(const Element& element, int restarts) const;
  void give_up(const Element& element) const;
  /// Files of an element's workers: "1.7.0", "1.7.1" ...
  [[nodiscard]] std::vector<std::string> workers(const char* folder, const Element& element) const;
  /// The last line that an element printed; empty where there is none.
  [[nodiscard]] std::string last_words(const Element& element) const;

 private:
  void write() const;

  std::filesystem::path path_;
  std::string stage_, key_;
  int count_ = 0;
  std::optional<double> cost_s_;
  std::optional<int> asked_;
  std::optional<int> finished_;
  std::map<std::filesystem::path, JournalTail> tails_;
};

/// Stage folders below an executor's folder, by name.
std::vector<std::filesystem::path> stage_folders(const std::filesystem::path& folder);

}  // namespace jaculus::detail
