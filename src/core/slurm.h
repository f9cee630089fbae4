#pragma once
// Slurm by its own programs: sbatch, squeue, scancel of the PATH.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace jaculus::detail {

struct Array {
  std::string name;
  int elements = 0;
  std::filesystem::path directory;   ///< where its command runs
  std::filesystem::path script;      ///< that each element runs
  std::string output;                ///< file of its messages, with %a for the element
  std::vector<std::string> options;  ///< of the user, the last word
};

/// Submits and returns the job's id. InputError with what sbatch says.
std::string submit_array(const Array& array);

struct ElementState {
  std::string state;   ///< Slurm's word: PENDING, RUNNING, COMPLETED, NODE_FAIL ...
  std::string reason;  ///< why it waits or ended so; "None" where there is none
  std::string node;    ///< empty: none yet
  [[nodiscard]] bool ended() const;
};

/// States of an array's elements; those that Slurm has forgotten are left out. Nothing where Slurm
/// doesn't answer, and then `trouble` says what it printed.
std::optional<std::map<int, ElementState>> element_states(const std::string& job,
                                                          std::string* trouble = nullptr);

/// Ends what of the job still waits or runs; says nothing where that fails.
void cancel_job(const std::string& job);

/// A word as sh reads it back.
std::string shell_quoted(const std::string& word);

}  // namespace jaculus::detail
