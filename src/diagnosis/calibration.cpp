#include "diagnosis/calibration.h"

#include <algorithm>
#include <cmath>
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

const std::map<std::string, Reliability>& reliabilities() {
  static const std::map<std::string, Reliability> table = {{"effect", {0.95, 0.5, 0.1, 0.4}},
                                                           {"several", {0.75, 0.5, 0.1, 0.4}},
                                                           {"ambiguous", {0.7, 0.5, 0.1, 0.4}},
                                                           {"none", {0.8, 0.4, 0.0, 0.6}},
                                                           {"unexplained", {0.75, 0.0, 0.2, 0.8}}};
  return table;
}

/// Whether a row of the ranking, "a" or "a + b", is made of effects that are stated.
bool is_stated(const Diagnosis& out, const Ranked& row) {
  if (row.effect == "none" || row.effect == "unexplained") return row.effect == out.verdict;
  for (std::size_t from = 0; from < row.effect.size();) {
    const std::size_t to = std::min(row.effect.find(" + ", from), row.effect.size());
    const std::string part = row.effect.substr(from, to - from);
    if (std::none_of(out.effects.begin(), out.effects.end(), [&](const FoundEffect& e) { return e.name == part; }))
      return false;
    from = to + 3;
  }
  return !out.effects.empty();
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

}  // namespace

void calibrate(Diagnosis& out) {
  const auto found = reliabilities().find(out.verdict);
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
  for (FoundEffect& effect : out.effects) effect.probability *= right;
  std::stable_sort(out.ranking.begin(), out.ranking.end(),
                   [](const Ranked& a, const Ranked& b) { return a.probability > b.probability; });
}

}  // namespace jaculus
