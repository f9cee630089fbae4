#include "diagnosis/calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <numeric>

namespace jaculus {
namespace {

/// Share of a verdict's statements that were right, and how what is left over is spread.
struct Reliability {
  double right = 1.0;
  double unexplained = 0.0, none = 0.0, others = 0.0;  ///< parts of the rest
};

constexpr double kPlain = 1.5;  // noise floors: what a gap should be before, and should not be after
constexpr double kClear = 1.1;  // times what the stated effects leave, which rivals should leave at least

const std::map<std::string, Reliability>& reliabilities() {
  static const std::map<std::string, Reliability> table = {
      {"effect", {0.97, 0.5, 0.1, 0.4}},  {"contested effect", {0.6, 0.3, 0.1, 0.6}},
      {"several", {0.75, 0.5, 0.1, 0.4}}, {"ambiguous", {0.7, 0.5, 0.1, 0.4}},
      {"none", {0.8, 0.4, 0.0, 0.6}},     {"unexplained", {0.75, 0.0, 0.2, 0.8}}};
  return table;
}

/// Whether a row of the ranking is made of effects that are stated.
bool is_stated(const Diagnosis& out, const Ranked& row) {
  if (row.members.empty()) return row.effect == out.verdict;
  return std::all_of(row.members.begin(), row.members.end(), [&](const std::string& member) {
    return std::any_of(out.effects.begin(), out.effects.end(), [&](const FoundEffect& e) { return e.name == member; });
  });
}

/// Reasons to doubt the one effect that is stated: another predicts held-out data nearly as well, the gap was small from the start, or
/// not all of it went.
std::vector<std::string> doubts(const Diagnosis& out) {
  std::vector<std::string> found;
  if (out.verdict != "effect") return found;
  if (!out.gap.valid) found.push_back("its prediction of held-out data could not be judged");
  if (out.gap.valid && out.gap.before < kPlain)
    found.push_back(fmt::format("the gap is small: {:.2g} noise floors", out.gap.before));
  if (out.gap.valid && out.gap.after > kPlain)
    found.push_back(fmt::format("{:.2g} noise floors of the gap are left", out.gap.after));
  const std::string& stated = out.effects.front().name;
  for (const Ranked& row : out.ranking) {
    const bool other = std::find(row.members.begin(), row.members.end(), stated) == row.members.end();
    if (!row.members.empty() && other && row.held_out_error < kClear * out.gap.after)
      found.push_back(fmt::format("{} predicts held-out data nearly as well", row.effect));
  }
  return found;
}

/// Weights of the rows that are not stated, before they are brought to the sum that is left.
std::vector<double> rest_weights(const Diagnosis& out, const std::vector<bool>& stated,
                                 const Reliability& reliability) {
  std::vector<double> weights(out.ranking.size(), 0.0);
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < out.ranking.size(); ++i) {
    if (stated[i]) continue;
    const Ranked& row = out.ranking[i];
    if (row.effect == "unexplained")
      weights[i] = reliability.unexplained;
    else if (row.effect == "none")
      weights[i] = reliability.none;
    else
      others.push_back(i);
  }
  std::stable_sort(others.begin(), others.end(), [&](std::size_t a, std::size_t b) {
    return out.ranking[a].log_evidence > out.ranking[b].log_evidence;
  });
  double share = 0.5;
  for (const std::size_t i : others) {
    weights[i] = share * reliability.others;
    share *= 0.5;
  }
  return weights;
}

/// Probability of the stated rows that an effect is part of.
double share_of(const Diagnosis& out, const std::vector<bool>& stated, const std::string& effect) {
  double share = 0.0;
  for (std::size_t i = 0; i < out.ranking.size(); ++i) {
    const std::vector<std::string>& members = out.ranking[i].members;
    if (stated[i] && std::find(members.begin(), members.end(), effect) != members.end())
      share += out.ranking[i].probability;
  }
  return share;
}

}  // namespace

void calibrate(Diagnosis& out) {
  const std::vector<std::string> doubted = doubts(out);
  const auto found = reliabilities().find((doubted.empty() ? "" : "contested ") + out.verdict);
  if (found == reliabilities().end() || out.ranking.empty()) return;
  std::vector<bool> stated;
  double claimed = 0.0;
  int rows = 0;
  for (const Ranked& row : out.ranking) {
    stated.push_back(is_stated(out, row));
    if (!stated.back()) continue;
    claimed += row.probability;
    ++rows;
  }
  if (rows == 0) return;
  out.reasons.insert(out.reasons.end(), doubted.begin(), doubted.end());
  const std::vector<double> rest = rest_weights(out, stated, found->second);
  const double all_rest = std::accumulate(rest.begin(), rest.end(), 0.0);
  const double right = all_rest > 0.0 ? found->second.right : 1.0;
  for (std::size_t i = 0; i < out.ranking.size(); ++i) {
    double& p = out.ranking[i].probability;
    // A verdict that held-out data decided against the posterior has no part of it to share by.
    if (stated[i])
      p = right * (claimed > 0.0 ? p / claimed : 1.0 / rows);
    else
      p = (1.0 - right) * rest[i] / all_rest;
  }
  for (FoundEffect& effect : out.effects) effect.probability = share_of(out, stated, effect.name);
  std::stable_sort(out.ranking.begin(), out.ranking.end(),
                   [](const Ranked& a, const Ranked& b) { return a.probability > b.probability; });
}

}  // namespace jaculus
