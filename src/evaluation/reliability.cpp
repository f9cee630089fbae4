// Whether stated probabilities mean what they say, and one for statements that come without.

#include <algorithm>
#include <cmath>
#include <random>

#include "evaluation/case_score.h"
#include "evaluation/estimates.h"
#include "evaluation/metrics.h"

namespace jaculus::evaluation {
namespace {

using diagnosis::Verdict;

const std::vector<double>& bin_edges() {
  static const std::vector<double> edges = {0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 1.0};
  return edges;
}

/// Of a bin: the first holds 0, the last 1.
int bin_of(double probability) {
  const std::vector<double>& edges = bin_edges();
  int bin = 0;
  while (bin + 2 < count_of(edges) && probability >= edges[bin + 1]) ++bin;
  return bin;
}

/// A case that states something.
struct Stated {
  double probability = 0.0;
  bool right = false;
};

struct BinSum {
  double stated = 0.0;
  int right = 0, count = 0;
};

std::vector<BinSum> summed(const std::vector<Stated>& cases) {
  std::vector<BinSum> bins(bin_edges().size() - 1);
  for (const Stated& one : cases) {
    BinSum& bin = bins[bin_of(one.probability)];
    bin.stated += one.probability;
    bin.right += one.right ? 1 : 0;
    ++bin.count;
  }
  return bins;
}

double distance(const std::vector<Stated>& cases) {
  double sum = 0.0;
  for (const BinSum& bin : summed(cases)) sum += std::abs(bin.stated - bin.right);
  return sum / static_cast<double>(cases.size());
}

ScoreEstimate calibration_error(const std::vector<Stated>& cases) {
  if (cases.empty()) return {};
  ScoreEstimate e{distance(cases), {kNaN, kNaN}, count_of(cases)};
  if (cases.size() == 1) return e;

  constexpr int kResamples = 4000;
  std::mt19937_64 random(20260101);
  std::uniform_int_distribution<std::size_t> pick(0, cases.size() - 1);
  std::vector<double> distances;
  for (int k = 0; k < kResamples; ++k) {
    std::vector<Stated> drawn(cases.size());
    for (Stated& one : drawn) one = cases[pick(random)];
    distances.push_back(distance(drawn));
  }
  std::sort(distances.begin(), distances.end());
  e.ci95 = {distances[kResamples / 40], distances[kResamples - 1 - kResamples / 40]};
  return e;
}

/// What a prediction states, for its frequency: an effect (first of those named), "none", or
/// nothing.
std::string statement_of(const Prediction& prediction) {
  if (!prediction.effects.empty()) return prediction.effects.front().name;
  return prediction.verdict == Verdict::none || prediction.verdict == Verdict::unexplained
             ? to_text(*prediction.verdict)
             : "";
}

bool is_right(const CaseTruth& truth, const Prediction& prediction) {
  if (!prediction.effects.empty()) return names_truth(truth, prediction.effects.front());
  return (prediction.verdict == Verdict::none && truth.kind == "none") ||
         (prediction.verdict == Verdict::unexplained && truth.kind == "outside");
}

/// Statements that share a frequency: 0 effects, 1 none, 2 unexplained; -1 states nothing.
int sort_of(const Prediction& prediction) {
  if (!prediction.effects.empty()) return 0;
  if (prediction.verdict == Verdict::none) return 1;
  return prediction.verdict == Verdict::unexplained ? 2 : -1;
}

}  // namespace

void add_reliability(const std::vector<Prediction>& predictions, Metrics& metrics) {
  std::vector<Stated> cases;
  for (std::size_t i = 0; i < predictions.size(); ++i) {
    if (!predictions[i].verdict || predictions[i].verdict == Verdict::insufficient) continue;
    cases.push_back({metrics.scores[i].confidence, metrics.scores[i].right});
  }

  const std::vector<BinSum> bins = summed(cases);
  for (int b = 0; b < count_of(bins); ++b) {
    const double mean = bins[b].count > 0 ? bins[b].stated / bins[b].count : kNaN;
    metrics.reliability.push_back(
        {{bin_edges()[b], bin_edges()[b + 1]}, mean, proportion(bins[b].right, bins[b].count)});
  }

  metrics.by["calibration error"] = calibration_error(cases);
  metrics.calibration_error = metrics.by["calibration error"].value;
}

void give_confidence(const std::vector<CaseTruth>& truths, std::vector<Prediction>& predictions) {
  int right[3] = {0, 0, 0}, count[3] = {0, 0, 0};
  std::vector<bool> hit;
  for (std::size_t i = 0; i < truths.size(); ++i) {
    hit.push_back(is_right(truths[i], predictions[i]));
    const int sort = sort_of(predictions[i]);
    if (sort < 0) continue;
    ++count[sort];
    right[sort] += hit[i] ? 1 : 0;
  }

  for (std::size_t i = 0; i < truths.size(); ++i) {
    Prediction& prediction = predictions[i];
    const int sort = sort_of(prediction);
    if (sort < 0) continue;
    const std::string stated = statement_of(prediction);
    const double p = (right[sort] - (hit[i] ? 1 : 0) + 1.0) / (count[sort] - 1 + 2.0);

    prediction.ranking.try_emplace(stated, p);
    const double rest = (1.0 - p) / std::max(1, count_of(prediction.ranking) - 1);
    for (auto& [name, probability] : prediction.ranking) probability = name == stated ? p : rest;
    if (sort == 0) prediction.effects.front().probability = p;
  }
}

}  // namespace jaculus::evaluation
