// score.json and the table on the terminal.

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "evaluation/case_score.h"
#include "evaluation/goals.h"
#include "evaluation/metrics.h"
#include "jaculus/core/json.h"
#include "jaculus/evaluation/score.h"

namespace jaculus::evaluation {
namespace {

using nlohmann::json;

json to_json(const ScoreEstimate& e) {
  return {{"value", json_number(e.value)},
          {"ci95", {json_number(e.ci95.lower), json_number(e.ci95.upper)}},
          {"cases", e.count}};
}

json to_json(const std::map<std::string, ScoreEstimate>& table) {
  json object = json::object();
  for (const auto& [key, e] : table) object[key] = to_json(e);
  return object;
}

json goals_json(const Score& score) {
  json list = json::array();
  for (const GoalResult& goal : goal_results(score)) {
    json entry = {{"what", goal.what},
                  {"aim", aim_text(goal)},
                  {"reached", to_json(goal.reached)},
                  {"met", goal.met ? json(*goal.met) : json()}};
    list.push_back(std::move(entry));
  }
  return list;
}

json metrics_json(const Metrics& metrics) {
  json bins = json::array();
  for (const ReliabilityBin& bin : metrics.reliability) {
    bins.push_back({{"from", bin.probability.lower},
                    {"to", bin.probability.upper},
                    {"stated", json_number(bin.stated)},
                    {"right", to_json(bin.right)}});
  }
  return {{"answerer", metrics.predictor},
          {"figures", to_json(metrics.by)},
          {"credit_by_effect", to_json(metrics.credit_by_effect)},
          {"credit_by_strength", to_json(metrics.credit_by_strength)},
          {"confusion", metrics.confusion},
          {"reliability", bins},
          {"calibration_error", json_number(metrics.calibration_error)}};
}

json case_json(const CaseTruth& truth, const Score& score, std::size_t i) {
  const CaseScore& own = score.metrics.front().scores[i];
  json entry = {{"case", truth.case_id},
                {"kind", truth.kind},
                {"truth", evaluation::truth_label(truth)},
                {"equivalent", truth.equivalent},
                {"strength_noise_floors", json_number(truth.strength_in_noise_floors)},
                {"parted", truth.diverged},
                {"stated", own.stated},
                {"confidence", own.confidence},
                {"right", own.right},
                {"credit", own.credit},
                {"events", truth.events.size()},
                {"events_found", own.events_found},
                {"events_false", own.events_invented},
                {"described", own.described},
                {"place_right", own.place_right},
                {"family_credit", own.family_credit},
                {"log_score", own.log_score},
                {"component_right", own.component_right},
                {"parameter_error", json_number(own.parameter_error)},
                {"shrink_ratio", json_number(own.shrink_ratio)},
                {"told", nullptr},
                {"possible", nullptr}};
  if (truth.possible) {
    entry["told"] = *is_told(truth);
    entry["possible"] = {{"after_gap", json_number(truth.possible->after)},
                         {"tolerances_gap", json_number(truth.possible->tolerances)},
                         {"log_gain", json_number(truth.possible->log_gain)}};
  }
  for (std::size_t s = 1; s < score.metrics.size(); ++s)
    entry["baselines"][score.metrics[s].predictor] = score.metrics[s].scores[i].stated;

  return entry;
}

std::string shown(const ScoreEstimate& e) {
  if (e.count == 0) return "no case";
  return fmt::format("{:7.3f}  [{:.3f}, {:.3f}]  {:4d} cases", e.value, e.ci95.lower, e.ci95.upper,
                     e.count);
}

std::string table_text(const std::string& title,
                       const std::map<std::string, ScoreEstimate>& table) {
  std::string text = title + "\n";
  for (const auto& [key, e] : table) text += fmt::format("  {:<52} {}\n", key, shown(e));
  return text;
}

std::string confusion_text(const Metrics& metrics) {
  std::string text = "truth -> answers\n";
  for (const auto& [truth, stated] : metrics.confusion) {
    text += fmt::format("  {:<28}", truth);
    for (const auto& [prediction, count] : stated)
      text += fmt::format(" {} {},", count, prediction);
    text.back() = '\n';
  }
  return text;
}

std::string reliability_text(const Metrics& metrics) {
  std::string text = "stated probability -> share that was right\n";
  for (const ReliabilityBin& bin : metrics.reliability) {
    if (bin.right.count == 0) continue;
    text += fmt::format("  {:.2f} to {:.2f}, mean {:.3f}  {}\n", bin.probability.lower,
                        bin.probability.upper, bin.stated, shown(bin.right));
  }
  return text + fmt::format("  mean distance {:.3f}\n", metrics.calibration_error);
}

/// Draws that were left out, by what they held.
std::string diverged_text(const std::vector<CaseTruth>& truths) {
  std::map<std::string, int> counts;
  int all = 0;
  for (const CaseTruth& truth : truths)
    for (const std::string& draw : truth.diverged) ++counts[draw], ++all;
  if (all == 0) return "";
  std::string text = fmt::format(
      "\n{} draws were left out: left and right legs diverge, which no model in the plane holds\n",
      all);
  for (const auto& [draw, count] : counts) text += fmt::format("  {:<72} {}\n", draw, count);
  return text;
}

}  // namespace

std::string score_json(const Score& score) {
  json all_metrics = json::array(), comparisons = json::array(), cases = json::array();
  for (const Metrics& metrics : score.metrics) all_metrics.push_back(metrics_json(metrics));
  for (const Comparison& c : score.comparisons) {
    comparisons.push_back({{"baseline", c.predictor},
                           {"log_score_gain", to_json(c.log_score_gain)},
                           {"accuracy_gain", to_json(c.accuracy_gain)}});
  }
  for (std::size_t i = 0; i < score.truths.size(); ++i)
    cases.push_back(case_json(score.truths[i], score, i));
  const json root = {{"format", "jaculus-score/1"},         {"provenance", score.provenance},
                     {"cases_scored", score.truths.size()}, {"cases_sealed", score.sealed},
                     {"goals", goals_json(score)},          {"answerers", all_metrics},
                     {"comparisons", comparisons},          {"cases", cases}};
  return root.dump(2) + "\n";
}

std::string score_text(const Score& score) {
  const Metrics& metrics = score.metrics.front();
  std::string text =
      fmt::format("{} cases; a gap is plain from {} noise floors on; intervals are at 95 %\n",
                  count_of(score.truths) == score.sealed
                      ? fmt::format("{}", score.sealed)
                      : fmt::format("{} of {} sealed", score.truths.size(), score.sealed),
                  evaluation::kPlainGap);
  if (!score.provenance.empty()) text += score.provenance + "\n";
  text += diverged_text(score.truths);
  text += "\ngoals\n";
  for (const GoalResult& goal : goal_results(score)) {
    text += fmt::format("  {:<10}  {:<52} {}  {}\n",
                        !goal.met   ? "not judged"
                        : *goal.met ? "met"
                                    : "missed",
                        goal.what, shown(goal.reached), aim_text(goal));
  }

  text += "\n" + table_text("diagnosis", metrics.by);
  text += "\n" + table_text("credit by strength [noise floors]", metrics.credit_by_strength);
  text += "\n" + table_text("credit by truth", metrics.credit_by_effect);
  text += "\n" + confusion_text(metrics) + "\n" + reliability_text(metrics);

  for (std::size_t s = 1; s < score.metrics.size(); ++s) {
    const Metrics& other = score.metrics[s];
    const Comparison& c = score.comparisons[s - 1];
    text += fmt::format("\nbaseline: {}\n", other.predictor);
    for (const char* key :
         {"first place of singles, plain gap", "right over all cases", "log score"})
      text += fmt::format("  {:<52} {}\n", key, shown(other.by.at(key)));
    text +=
        fmt::format("  {:<52} {}\n", "diagnosis better in log score by", shown(c.log_score_gain));
    text += fmt::format("  {:<52} {}\n", "diagnosis better in credit by", shown(c.accuracy_gain));
  }

  return text;
}

std::string timing_json(const Score& score) {
  json seconds = json::object();
  for (const Metrics& metrics : score.metrics)
    seconds[metrics.predictor] = to_json(metrics.seconds);
  return json{{"seconds_a_case", seconds}}.dump(2) + "\n";
}

}  // namespace jaculus::evaluation
