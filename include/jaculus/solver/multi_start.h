#pragma once
// The same problem from many starts at once, and what they agree on.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "jaculus/core/tasks.h"
#include "jaculus/solver/result.h"

namespace jaculus::solver {

struct MultiStartOptions {
  std::uint64_t seed = 0;
  /// converged objectives this close, relative, are the same: the earliest start wins [-]
  double tie = 1e-7;
  double near = 5e-3;  ///< what counts as close to the best, relative [-]
  TaskOptions tasks =
      /// workers, journal, progress; `fingerprint` must cover problem and options, the seed is
      /// added
      {};
};

/// One start as it came out.
struct StartOutcome {
  TaskState task = TaskState::cancelled;
  std::string error;  ///< where the task failed
  NlpResult result;   ///< where it is done; its status may be any
};

struct MultiStart {
  std::vector<StartOutcome> starts;  ///< in start order
  /// the converged start of lowest objective, ties to the earliest; -1: none converged
  int best = -1;
  /// the start of least scaled violation, to be diagnosed where none converged; -1: none ran
  int least_bad = -1;
  int converged = 0;
  double converged_share = 0.0;  ///< of all starts [-]
  double near_share = 0.0;       ///< of all starts: converged and within `near` of the best [-]

  /// The result of `best`. std::logic_error where none converged.
  [[nodiscard]] const NlpResult& best_result() const;
};

/// Runs solve(start, seed) for start = 0 ... count - 1, each in a process of its own; start 0 is by
/// custom the given guess, the others draw theirs from their seed. Same seed, same outcome,
/// whatever the number of workers.
MultiStart multi_start(int count,
                       const std::function<NlpResult(int start, std::uint64_t seed)>& solve,
                       const MultiStartOptions& options = {});

/// The starts that converged, by rising objective, `best` first; of those within `tie`, relative,
/// of one before only the earliest.
std::vector<int> optima(const MultiStart& all, double tie);

}  // namespace jaculus::solver
