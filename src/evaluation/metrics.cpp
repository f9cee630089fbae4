#include "evaluation/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "evaluation/case_score.h"
#include "evaluation/estimates.h"

namespace jaculus::evaluation {
namespace {

using diagnosis::Verdict;
using Picks = std::vector<std::size_t>;

Picks pick(const std::vector<CaseTruth>& truths,
           const std::function<bool(const CaseTruth&)>& wanted) {
  Picks picks;
  for (std::size_t i = 0; i < truths.size(); ++i) {
    if (wanted(truths[i])) picks.push_back(i);
  }
  return picks;
}

std::function<bool(const CaseTruth&)> kind_is(const std::string& kind, double least = 0.0) {
  return [kind, least](const CaseTruth& truth) {
    return truth.kind == kind && truth.strength_in_noise_floors >= least && !is_parted(truth);
  };
}

ScoreEstimate share(const Picks& picks, const std::function<bool(std::size_t)>& holds) {
  int held = 0;
  for (const std::size_t i : picks) held += holds(i) ? 1 : 0;
  return proportion(held, count_of(picks));
}

/// Mean of what is not NaN.
ScoreEstimate mean_of(const Picks& picks, const std::function<double(std::size_t)>& value) {
  std::vector<double> values;
  for (const std::size_t i : picks) {
    if (!std::isnan(value(i))) values.push_back(value(i));
  }
  return mean(values);
}

/// Mixed cases of which one part, 0 the named one and 1 what is beside it, has a plain gap alone.
std::function<bool(const CaseTruth&)> mixed_with_plain(std::size_t part) {
  return [part](const CaseTruth& truth) {
    return truth.kind == "mixed" && truth.strengths.size() > part &&
           truth.strengths[part] >= kPlainGap;
  };
}

const char* strength_class(double strength) {
  return strength < 1.0    ? "under 1"
         : strength < 3.0  ? "1 to 3"
         : strength < 10.0 ? "3 to 10"
                           : "10 or more";
}

void add_answers(const std::vector<CaseTruth>& truths, const std::vector<Prediction>& predictions,
                 Metrics& metrics) {
  const auto verdict_is = [&](std::optional<Verdict> verdict) {
    return [&predictions, verdict](std::size_t i) { return predictions[i].verdict == verdict; };
  };

  const auto credit = [&](std::size_t i) { return metrics.scores[i].credit; };
  const auto top1 = [&](std::size_t i) { return metrics.scores[i].top1; };
  const Picks all = pick(truths, [](const CaseTruth&) { return true; });
  const Picks plain = pick(truths, kind_is("single", kPlainGap)),
              singles = pick(truths, kind_is("single"));
  const Picks pairs = pick(truths, kind_is("pair", kPlainGap)),
              none = pick(truths, kind_is("none"));
  const Picks outside = pick(truths, kind_is("outside", kPlainGap));
  metrics.by["credit of singles, plain gap"] = mean_of(plain, credit);
  metrics.by["credit of singles, any gap"] = mean_of(singles, credit);
  metrics.by["first place of singles, plain gap"] = share(plain, top1);
  metrics.by["first place of singles, any gap"] = share(singles, top1);
  metrics.by["credit of pairs, plain gap"] = mean_of(pairs, credit);
  metrics.by["pairs named in full, plain gap"] =
      share(pairs, [&](std::size_t i) { return metrics.scores[i].right; });
  metrics.by["false alarms where there is nothing"] =
      share(none, [&](std::size_t i) { return is_alarm(predictions[i]); });
  metrics.by["called unexplained where there is nothing"] =
      share(none, verdict_is(Verdict::unexplained));
  metrics.by["outside effects called unexplained, plain gap"] =
      share(outside, verdict_is(Verdict::unexplained));
  metrics.by["outside effects blamed on the catalogue, plain gap"] =
      share(outside, [&](std::size_t i) { return is_alarm(predictions[i]); });
  const auto remainder = [&](std::size_t i) { return metrics.scores[i].remainder; };
  metrics.by["mixed: named part named, plain gap"] =
      mean_of(pick(truths, mixed_with_plain(0)), credit);
  metrics.by["mixed: remainder said, plain gap"] =
      share(pick(truths, mixed_with_plain(1)), remainder);
  const Picks complete = pick(truths, [](const CaseTruth& truth) {
    return truth.kind != "outside" && truth.kind != "mixed" && !is_parted(truth);
  });
  metrics.by["remainder said where there is none"] = share(complete, remainder);
  metrics.by["legs that part called unexplained"] =
      share(pick(truths, is_parted), verdict_is(Verdict::unexplained));
  metrics.by["wrong and confident"] = share(all, [&](std::size_t i) {
    return !metrics.scores[i].right && metrics.scores[i].confidence > 0.8;
  });
  metrics.by["insufficient"] = share(all, verdict_is(Verdict::insufficient));
  metrics.by["no answer"] = share(all, verdict_is(std::nullopt));
  metrics.by["right over all cases"] = mean_of(all, credit);
}

void add_quality(const std::vector<CaseTruth>& truths, const std::vector<Prediction>& predictions,
                 Metrics& metrics) {
  const Picks all = pick(truths, [](const CaseTruth&) { return true; });
  const Picks plain = pick(truths, kind_is("single", kPlainGap));
  const Picks placed = pick(truths, [](const CaseTruth& t) {
    return !t.component.empty() && t.strength_in_noise_floors >= kPlainGap;
  });
  metrics.by["component right, plain gap"] =
      share(placed, [&](std::size_t i) { return metrics.scores[i].component_right; });
  std::vector<double> errors, ratios;

  int covered = 0, judged = 0;
  Picks with_ratio;
  for (const std::size_t i : plain) {
    const CaseScore& score = metrics.scores[i];
    if (!std::isnan(score.parameter_error)) errors.push_back(score.parameter_error);
    covered += score.parameters_covered;
    judged += score.parameters_judged;
    if (std::isnan(score.shrink_ratio)) continue;
    ratios.push_back(score.shrink_ratio);
    with_ratio.push_back(i);
  }

  metrics.by["parameter error, median"] = median(errors);
  metrics.by["parameters covered by their intervals"] = proportion(covered, judged);
  metrics.by["gap after over the possible one, median"] = median(ratios);
  metrics.by["energy explained over the possible, plain gap"] =
      mean_of(plain, [&](std::size_t i) { return metrics.scores[i].energy_ratio; });
  metrics.by["gap after within 1.3 of the possible one"] =
      share(with_ratio, [&](std::size_t i) { return metrics.scores[i].shrink_ratio <= 1.3; });
  const auto log_score = [&](std::size_t i) { return metrics.scores[i].log_score; };
  metrics.by["log score"] = mean_of(all, log_score);
  metrics.by["log score of singles, plain gap"] = mean_of(plain, log_score);
  metrics.by["seconds a case"] =
      mean_of(all, [&](std::size_t i) { return predictions[i].seconds; });
}

void add_tables(const std::vector<CaseTruth>& truths, Metrics& metrics) {
  std::map<std::string, std::vector<double>> by_effect, by_strength;
  for (std::size_t i = 0; i < truths.size(); ++i) {
    const CaseTruth& truth = truths[i];
    const CaseScore& score = metrics.scores[i];
    const std::string label = truth_label(truth);
    ++metrics.confusion[truth.kind == "pair" ? "pair" : label][score.stated];
    by_effect[label].push_back(score.credit);
    const std::string strength = strength_class(truth.strength_in_noise_floors);
    if (truth.kind != "none") by_strength[truth.kind + ", gap " + strength].push_back(score.credit);
  }
  for (const auto& [key, credits] : by_effect) metrics.credit_by_effect[key] = mean(credits);
  for (const auto& [key, credits] : by_strength) metrics.credit_by_strength[key] = mean(credits);
}

void add_reliability(const std::vector<Prediction>& predictions, Metrics& metrics) {
  static const std::vector<double> edges = {0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 1.0};
  double distance = 0.0;

  int total = 0;
  for (std::size_t b = 0; b + 1 < edges.size(); ++b) {
    int right = 0, count = 0;
    double stated = 0.0;
    for (std::size_t i = 0; i < predictions.size(); ++i) {
      const double p = metrics.scores[i].confidence;
      const bool abstains =
          !predictions[i].verdict || predictions[i].verdict == Verdict::insufficient;
      const bool last = b + 2 == edges.size();
      if (abstains || p < edges[b] || (last ? p > edges[b + 1] : p >= edges[b + 1])) continue;
      ++count;
      stated += p;
      if (metrics.scores[i].right) ++right;
    }
    const double mean_stated = count > 0 ? stated / count : kNaN;
    metrics.reliability.push_back(
        {{edges[b], edges[b + 1]}, mean_stated, proportion(right, count)});
    if (count > 0) distance += count * std::abs(mean_stated - static_cast<double>(right) / count);
    total += count;
  }

  if (total > 0) metrics.calibration_error = distance / total;
}

}  // namespace

Metrics compute_metrics(const std::string& predictor, const std::vector<CaseTruth>& truths,
                        const std::vector<Prediction>& predictions) {
  Metrics metrics;
  metrics.predictor = predictor;
  for (std::size_t i = 0; i < truths.size(); ++i)
    metrics.scores.push_back(score_case(truths[i], predictions[i]));
  add_answers(truths, predictions, metrics);
  add_quality(truths, predictions, metrics);
  add_tables(truths, metrics);
  add_reliability(predictions, metrics);
  return metrics;
}

const std::vector<Goal>& goals() {
  static const std::vector<Goal> list = {
      {"credit of singles, plain gap", true, 0.95},
      {"false alarms where there is nothing", false, 0.03},
      {"mixed: named part named, plain gap", true, 0.85},
      {"mixed: remainder said, plain gap", true, 0.85},
      {"wrong and confident", false, 0.02},
      {"parameters covered by their intervals", true, 0.93},
      {"outside effects called unexplained, plain gap", true, 0.85}};
  return list;
}

void give_confidence(const std::vector<CaseTruth>& truths, std::vector<Prediction>& predictions) {
  int hits = 0;
  std::vector<bool> hit(truths.size());
  for (std::size_t i = 0; i < truths.size(); ++i) {
    hit[i] = !predictions[i].effects.empty() &&
             names_truth(truths[i], predictions[i].effects.front().name);
    if (hit[i]) ++hits;
  }
  for (std::size_t i = 0; i < truths.size(); ++i) {
    Prediction& prediction = predictions[i];
    if (prediction.effects.empty()) continue;
    const int others = count_of(truths) - 1;
    const double p = (hits - (hit[i] ? 1 : 0) + 1.0) / (others + 2.0);
    const double rest =
        (1.0 - p) / std::max<double>(1.0, static_cast<double>(prediction.ranking.size()) - 1.0);
    for (auto& [name, probability] : prediction.ranking)
      probability = name == prediction.effects.front().name ? p : rest;
    prediction.effects.front().probability = p;
  }
}

}  // namespace jaculus::evaluation
