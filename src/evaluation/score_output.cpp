// score.json and the table on the terminal.

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "evaluation/mark.h"
#include "evaluation/sheet.h"

namespace jaculus {
namespace {

using nlohmann::json;

json number(double value) { return std::isfinite(value) ? json(value) : json(); }

json to_json(const ScoreEstimate& e) {
  return {{"value", number(e.value)}, {"ci95", {number(e.ci95.lower), number(e.ci95.upper)}}, {"cases", e.count}};
}

json to_json(const std::map<std::string, ScoreEstimate>& table) {
  json object = json::object();
  for (const auto& [key, e] : table) object[key] = to_json(e);
  return object;
}

bool met(const evaluation::Goal& goal, const ScoreEstimate& e) {
  return goal.at_least ? e.value >= goal.target : e.value <= goal.target;
}

json goals_json(const ScoreSheet& sheet) {
  json list = json::array();
  for (const evaluation::Goal& goal : evaluation::goals()) {
    const ScoreEstimate& e = sheet.by.at(goal.key);
    list.push_back({{"what", goal.key},
                    {goal.at_least ? "at_least" : "at_most", goal.target},
                    {"reached", to_json(e)},
                    {"met", e.count == 0 ? json() : json(met(goal, e))}});
  }
  return list;
}

json sheet_json(const ScoreSheet& sheet) {
  json bins = json::array();
  for (const ReliabilityBin& bin : sheet.reliability) {
    bins.push_back({{"from", bin.probability.lower},
                    {"to", bin.probability.upper},
                    {"stated", number(bin.stated)},
                    {"right", to_json(bin.right)}});
  }
  return {{"answerer", sheet.answerer},
          {"figures", to_json(sheet.by)},
          {"credit_by_effect", to_json(sheet.credit_by_effect)},
          {"credit_by_strength", to_json(sheet.credit_by_strength)},
          {"confusion", sheet.confusion},
          {"reliability", bins},
          {"calibration_error", number(sheet.calibration_error)}};
}

json case_json(const SealedTruth& truth, const Score& score, std::size_t i) {
  const CaseMark& mark = score.sheets.front().marks[i];
  json entry = {{"case", truth.case_id},
                {"kind", truth.kind},
                {"truth", evaluation::truth_label(truth)},
                {"equivalent", truth.equivalent},
                {"strength_noise_floors", number(truth.strength_in_noise_floors)},
                {"parted", truth.parted},
                {"stated", mark.stated},
                {"confidence", mark.confidence},
                {"right", mark.right},
                {"credit", mark.credit},
                {"log_score", mark.log_score},
                {"component_right", mark.component_right},
                {"parameter_error", number(mark.parameter_error)},
                {"shrink_ratio", number(mark.shrink_ratio)}};
  for (std::size_t s = 1; s < score.sheets.size(); ++s)
    entry["baselines"][score.sheets[s].answerer] = score.sheets[s].marks[i].stated;
  return entry;
}

std::string shown(const ScoreEstimate& e) {
  if (e.count == 0) return "no case";
  return fmt::format("{:7.3f}  [{:.3f}, {:.3f}]  {:4d} cases", e.value, e.ci95.lower, e.ci95.upper, e.count);
}

std::string table_text(const std::string& title, const std::map<std::string, ScoreEstimate>& table) {
  std::string text = title + "\n";
  for (const auto& [key, e] : table) text += fmt::format("  {:<52} {}\n", key, shown(e));
  return text;
}

std::string confusion_text(const ScoreSheet& sheet) {
  std::string text = "truth -> answers\n";
  for (const auto& [truth, stated] : sheet.confusion) {
    text += fmt::format("  {:<28}", truth);
    for (const auto& [answer, count] : stated) text += fmt::format(" {} {},", count, answer);
    text.back() = '\n';
  }
  return text;
}

std::string reliability_text(const ScoreSheet& sheet) {
  std::string text = "stated probability -> share that was right\n";
  for (const ReliabilityBin& bin : sheet.reliability) {
    if (bin.right.count == 0) continue;
    text += fmt::format("  {:.2f} to {:.2f}, mean {:.3f}  {}\n", bin.probability.lower, bin.probability.upper,
                        bin.stated, shown(bin.right));
  }
  return text + fmt::format("  mean distance {:.3f}\n", sheet.calibration_error);
}

/// Draws that were left out, by what they held.
std::string parted_text(const std::vector<SealedTruth>& truths) {
  std::map<std::string, int> counts;
  int all = 0;
  for (const SealedTruth& truth : truths)
    for (const std::string& draw : truth.parted) ++counts[draw], ++all;
  if (all == 0) return "";
  std::string text =
      fmt::format("\n{} draws were left out: left and right legs part, which no model in the plane holds\n", all);
  for (const auto& [draw, count] : counts) text += fmt::format("  {:<72} {}\n", draw, count);
  return text;
}

}  // namespace

std::string score_json(const Score& score) {
  json sheets = json::array(), comparisons = json::array(), cases = json::array();
  for (const ScoreSheet& sheet : score.sheets) sheets.push_back(sheet_json(sheet));
  for (const Comparison& c : score.comparisons) {
    comparisons.push_back({{"baseline", c.answerer},
                           {"log_score_gain", to_json(c.log_score_gain)},
                           {"accuracy_gain", to_json(c.accuracy_gain)}});
  }
  for (std::size_t i = 0; i < score.truths.size(); ++i) cases.push_back(case_json(score.truths[i], score, i));
  const json root = {
      {"format", "jaculus-score/1"}, {"provenance", score.provenance}, {"goals", goals_json(score.sheets.front())},
      {"answerers", sheets},         {"comparisons", comparisons},     {"cases", cases}};
  return root.dump(2) + "\n";
}

std::string score_text(const Score& score) {
  const ScoreSheet& sheet = score.sheets.front();
  std::string text = fmt::format("{} cases; a gap is plain from {} noise floors on; intervals are at 95 %\n",
                                 score.truths.size(), evaluation::kPlainGap);
  if (!score.provenance.empty()) text += score.provenance + "\n";
  text += parted_text(score.truths);
  text += "\ngoals\n";
  for (const evaluation::Goal& goal : evaluation::goals()) {
    const ScoreEstimate& e = sheet.by.at(goal.key);
    text +=
        fmt::format("  {:<52} {}  {} {}: {}\n", goal.key, shown(e), goal.at_least ? "at least" : "at most", goal.target,
                    e.count == 0   ? "not judged"
                    : met(goal, e) ? "met"
                                   : "missed");
  }
  text += "\n" + table_text("diagnosis", sheet.by);
  text += "\n" + table_text("credit by strength [noise floors]", sheet.credit_by_strength);
  text += "\n" + table_text("credit by truth", sheet.credit_by_effect);
  text += "\n" + confusion_text(sheet) + "\n" + reliability_text(sheet);
  for (std::size_t s = 1; s < score.sheets.size(); ++s) {
    const ScoreSheet& other = score.sheets[s];
    const Comparison& c = score.comparisons[s - 1];
    text += fmt::format("\nbaseline: {}\n", other.answerer);
    for (const char* key : {"first place of singles, plain gap", "right over all cases", "log score"})
      text += fmt::format("  {:<52} {}\n", key, shown(other.by.at(key)));
    text += fmt::format("  {:<52} {}\n", "diagnosis better in log score by", shown(c.log_score_gain));
    text += fmt::format("  {:<52} {}\n", "diagnosis better in credit by", shown(c.accuracy_gain));
  }
  return text;
}

}  // namespace jaculus
