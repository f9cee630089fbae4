// --executor: where the repeated work of a command runs.

#include "jaculus/core/executor.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "cli/command.h"
#include "jaculus/core/error.h"

namespace jaculus::cli {
namespace {

namespace fs = std::filesystem;

const char* const kSlurm = "slurm";

/// This process's command line, by the program's own path, going on with what is there.
std::vector<std::string> worker_command() {
  std::vector<std::string> words;
  std::ifstream stream("/proc/self/cmdline", std::ios::binary);
  for (std::string word; std::getline(stream, word, '\0');) words.push_back(word);
  words.at(0) = fs::read_symlink("/proc/self/exe").string();
  if (std::find(words.begin(), words.end(), "--resume") == words.end())
    words.emplace_back("--resume");
  return words;
}

}  // namespace

void add_executor(CLI::App& command, Common& common) {
  command
      .add_option(
          "--executor", common.executor,
          "where the work runs: here, or as an array of jobs of Slurm, for which --out is a "
          "folder that all its machines share")
      ->check(one_of({"local", kSlurm}));
  command.add_option("--slurm-options", common.slurm_options,
                     "further options of sbatch, as in \"--partition=short --time=2:00:00\"");
  command
      .add_option("--chunk-time", common.chunk_s,
                  "largest work of one element of the array [s], 300 unless given")
      ->check(CLI::Range(1e-3, 1e6));
}

fs::path jobs_folder(const fs::path& out) { return out.empty() ? out : out / "jobs"; }

std::shared_ptr<const Executor> make_executor(const Common& common, const fs::path& folder) {
  if (common.executor != kSlurm) {
    for (const auto& [flag, given] : {std::pair("--slurm-options", !common.slurm_options.empty()),
                                      std::pair("--chunk-time", common.chunk_s.has_value())}) {
      if (given)
        throw InputError(fmt::format("{}: given without --executor slurm; allowed: with it", flag));
    }
    return nullptr;
  }
  if (folder.empty()) {
    throw InputError(
        "--executor slurm: given without --out; allowed: with a folder that all machines share");
  }
  Executor executor{fs::absolute(folder), worker_command(), split_options(common.slurm_options)};
  if (common.chunk_s) executor.chunk_s = *common.chunk_s;
  return std::make_shared<const Executor>(executor);
}

}  // namespace jaculus::cli
