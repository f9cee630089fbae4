#pragma once
// The goals of docs/measures.md, judged by the near end of the interval.
//   at least a, at most b   the interval's lower end is a or more, its upper end b or less
//   a to b                  the whole interval lies within
//   above 0                 the lower end is above

#include <optional>

#include "jaculus/evaluation/score.h"

namespace jaculus::evaluation {

struct GoalResult {
  std::string what;
  Bounds aim;          ///< an infinite end is no aim
  bool above = false;  ///< the lower end of the aim itself does not meet it
  ScoreEstimate reached;
  std::optional<bool> met;  ///< nothing: no case to judge it by
};

/// Of the diagnosis, missed ones first, then those that could not be judged, then those met.
std::vector<GoalResult> goal_results(const Score& score);
std::string aim_text(const GoalResult& goal);  ///< "at least 0.95"

}  // namespace jaculus::evaluation
