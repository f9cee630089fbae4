#pragma once
// Tasks on a cluster. An array of jobs runs the very command line that was given, as workers: each
// does everything up to the list of tasks that it is for (TaskOptions::stage), takes its chunk of
// indices, writes what it finishes into a journal of its own and ends. The process that submitted
// follows these journals, submits again what a lost node took with it, and goes on as if it had run
// all tasks itself. Nothing is shared but a folder, and no file has two writers, so that no lock is
// needed:
//
//   FOLDER/STAGE/stage.json      what the list is, and the cost of its first tasks
//   FOLDER/STAGE/round_1.json    chunks of the first array
//   FOLDER/STAGE/round_1.sh      what it runs; round_1.id: Slurm's id of it
//   FOLDER/STAGE/begun/1.7.0     round 1, chunk 7, not requeued: indices that were begun
//   FOLDER/STAGE/done/1.7.0      journal of results
//   FOLDER/STAGE/failed/1.7.0    journal of reasons
//   FOLDER/STAGE/lost/1.7        that its tasks were given to another element
//   FOLDER/STAGE/log/1.7.txt     what the worker printed

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace jaculus {

/// Slurm, through its own sbatch, squeue and scancel.
struct Executor {
  std::filesystem::path folder;           ///< on a disk that all machines share
  std::vector<std::string> command = {};  ///< what a worker runs; it must get to the same lists
  std::vector<std::string> options = {};  ///< further options of sbatch
  double chunk_s = 300.0;                 ///< work of one element of the array [s]
};

/// Thrown by run_tasks in a worker once its chunk is finished, for the program to end on. It is no
/// std::exception, so that nothing on the way takes it for a fault.
struct WorkerDone {
  bool complete = false;  ///< false: interrupted
};

/// The stage that this process is a worker of; empty: it is none. A command with several lists may
/// pass over those that come before.
std::string worker_stage();

/// Splits a line of options as a shell does, with ' and ", but without expansions. InputError on a
/// quote that is not closed.
std::vector<std::string> split_options(const std::string& line);

/// Removes what the executor keeps, once the command's results are written.
void remove_jobs(const Executor& executor);

/// One list of tasks as its folder tells it.
struct JobsStatus {
  std::string stage;
  int tasks = 0;  ///< that are asked for
  int done = 0;
  std::map<std::string, std::vector<int>> failed;  ///< indices by reason
  /// elements of arrays by what Slurm says of them: state, and the reason where it waits
  std::map<std::string, int> elements;
  int running = 0;           ///< begun and not finished, in elements that run
  double elapsed_s = 0.0;    ///< from the first submission to now, or to the last result [s]
  double remaining_s = 0.0;  ///< at the pace so far; NaN before the first result [s]
};

/// Every list of tasks below `folder` (as Executor::folder), in order of submission. InputError
/// where none is there.
std::vector<JobsStatus> jobs_status(const std::filesystem::path& folder);

}  // namespace jaculus
