#include "evaluation/goals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace jaculus::evaluation {
namespace {

struct Goal {
  const char* key;  ///< of Metrics::by
  Bounds aim;
};

const std::vector<Goal>& goals_of_measures() {
  static const std::vector<Goal> list = {
      {"credit of singles, plain gap", {0.95, kInfinity}},
      {"false alarms where there is nothing", {-kInfinity, 0.03}},
      {"mixed: named part named, plain gap", {0.85, kInfinity}},
      {"mixed: remainder said, plain gap", {0.85, kInfinity}},
      {"descriptions: place right, plain gap", {0.9, kInfinity}},
      {"descriptions: family right, plain gap", {0.75, kInfinity}},
      {"descriptions where nothing is left", {-kInfinity, 0.05}},
      {"wrong and confident", {-kInfinity, 0.02}},
      {"calibration error", {-kInfinity, 0.05}},
      {"parameters covered by their intervals", {0.93, 0.97}}};
  return list;
}

GoalResult judged(const std::string& what, const Bounds& aim, bool above, const ScoreEstimate& e) {
  GoalResult goal{what, aim, above, e, {}};
  if (e.count == 0) return goal;
  // An end that isn't known (one case alone) shows nothing: comparisons with it are false.
  const bool low =
      std::isinf(aim.lower) || e.ci95.lower > aim.lower || (!above && e.ci95.lower == aim.lower);
  goal.met = low && (std::isinf(aim.upper) || e.ci95.upper <= aim.upper);
  return goal;
}

int place(const GoalResult& goal) { return !goal.met ? 1 : *goal.met ? 2 : 0; }

}  // namespace

std::vector<GoalResult> goal_results(const Score& score) {
  const Metrics& own = score.metrics.front();
  std::vector<GoalResult> results;
  for (const Goal& goal : goals_of_measures())
    results.push_back(judged(goal.key, goal.aim, false, own.by.at(goal.key)));

  for (const Comparison& c : score.comparisons) {
    results.push_back(
        judged("log score over " + c.predictor, {0.0, kInfinity}, true, c.log_score_gain));
  }
  if (score.comparisons.empty())
    results.push_back(judged("log score over every baseline", {0.0, kInfinity}, true, {}));

  std::stable_sort(results.begin(), results.end(),
                   [](const GoalResult& a, const GoalResult& b) { return place(a) < place(b); });
  return results;
}

std::string aim_text(const GoalResult& goal) {
  if (goal.above) return fmt::format("above {}", goal.aim.lower);
  if (std::isinf(goal.aim.upper)) return fmt::format("at least {}", goal.aim.lower);
  if (std::isinf(goal.aim.lower)) return fmt::format("at most {}", goal.aim.upper);
  return fmt::format("{} to {}", goal.aim.lower, goal.aim.upper);
}

}  // namespace jaculus::evaluation
