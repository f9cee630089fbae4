#include "evaluation/sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evaluation/estimates.h"
#include "evaluation/mark.h"

namespace jaculus::evaluation {
namespace {

using Picks = std::vector<std::size_t>;

Picks pick(const std::vector<SealedTruth>& truths, const std::function<bool(const SealedTruth&)>& wanted) {
  Picks picks;
  for (std::size_t i = 0; i < truths.size(); ++i) {
    if (wanted(truths[i])) picks.push_back(i);
  }
  return picks;
}

std::function<bool(const SealedTruth&)> kind_is(const std::string& kind, double least = 0.0) {
  return
      [kind, least](const SealedTruth& truth) { return truth.kind == kind && truth.strength_in_noise_floors >= least; };
}

ScoreEstimate share(const Picks& picks, const std::function<bool(std::size_t)>& holds) {
  return proportion(static_cast<int>(std::count_if(picks.begin(), picks.end(), holds)), static_cast<int>(picks.size()));
}

/// Mean of what is not NaN.
ScoreEstimate mean_of(const Picks& picks, const std::function<double(std::size_t)>& value) {
  std::vector<double> values;
  for (const std::size_t i : picks) {
    if (!std::isnan(value(i))) values.push_back(value(i));
  }
  return mean(values);
}

const char* strength_class(double strength) {
  return strength < 1.0 ? "under 1" : strength < 3.0 ? "1 to 3" : strength < 10.0 ? "3 to 10" : "10 or more";
}

void add_answers(const std::vector<SealedTruth>& truths, const std::vector<CaseAnswer>& answers, ScoreSheet& sheet) {
  const auto verdict_is = [&](const std::string& verdict) {
    return [&answers, verdict](std::size_t i) { return answers[i].verdict == verdict; };
  };
  const auto credit = [&](std::size_t i) { return sheet.marks[i].credit; };
  const auto top1 = [&](std::size_t i) { return sheet.marks[i].top1; };
  const Picks all = pick(truths, [](const SealedTruth&) { return true; });
  const Picks plain = pick(truths, kind_is("single", kPlainGap)), singles = pick(truths, kind_is("single"));
  const Picks pairs = pick(truths, kind_is("pair", kPlainGap)), none = pick(truths, kind_is("none"));
  const Picks outside = pick(truths, kind_is("outside", kPlainGap));
  sheet.by["credit of singles, plain gap"] = mean_of(plain, credit);
  sheet.by["credit of singles, any gap"] = mean_of(singles, credit);
  sheet.by["first place of singles, plain gap"] = share(plain, top1);
  sheet.by["first place of singles, any gap"] = share(singles, top1);
  sheet.by["credit of pairs, plain gap"] = mean_of(pairs, credit);
  sheet.by["pairs named in full, plain gap"] = share(pairs, [&](std::size_t i) { return sheet.marks[i].right; });
  sheet.by["false alarms where there is nothing"] = share(none, [&](std::size_t i) { return is_alarm(answers[i]); });
  sheet.by["called unexplained where there is nothing"] = share(none, verdict_is("unexplained"));
  sheet.by["outside effects called unexplained, plain gap"] = share(outside, verdict_is("unexplained"));
  sheet.by["outside effects blamed on the catalogue, plain gap"] =
      share(outside, [&](std::size_t i) { return is_alarm(answers[i]); });
  sheet.by["wrong and confident"] =
      share(all, [&](std::size_t i) { return !sheet.marks[i].right && sheet.marks[i].confidence > 0.8; });
  sheet.by["insufficient"] = share(all, verdict_is("insufficient"));
  sheet.by["no answer"] = share(all, verdict_is("failed"));
  sheet.by["right over all cases"] = mean_of(all, credit);
}

void add_quality(const std::vector<SealedTruth>& truths, const std::vector<CaseAnswer>& answers, ScoreSheet& sheet) {
  const Picks all = pick(truths, [](const SealedTruth&) { return true; });
  const Picks plain = pick(truths, kind_is("single", kPlainGap));
  const Picks placed = pick(
      truths, [](const SealedTruth& t) { return !t.component.empty() && t.strength_in_noise_floors >= kPlainGap; });
  sheet.by["component right, plain gap"] = share(placed, [&](std::size_t i) { return sheet.marks[i].component_right; });
  std::vector<double> errors, ratios;
  int covered = 0, judged = 0;
  Picks with_ratio;
  for (const std::size_t i : plain) {
    const CaseMark& mark = sheet.marks[i];
    if (!std::isnan(mark.parameter_error)) errors.push_back(mark.parameter_error);
    covered += mark.parameters_covered;
    judged += mark.parameters_judged;
    if (std::isnan(mark.shrink_ratio)) continue;
    ratios.push_back(mark.shrink_ratio);
    with_ratio.push_back(i);
  }
  sheet.by["parameter error, median"] = median(errors);
  sheet.by["parameters covered by their intervals"] = proportion(covered, judged);
  sheet.by["gap after over the possible one, median"] = median(ratios);
  sheet.by["gap after within 1.3 of the possible one"] =
      share(with_ratio, [&](std::size_t i) { return sheet.marks[i].shrink_ratio <= 1.3; });
  const auto log_score = [&](std::size_t i) { return sheet.marks[i].log_score; };
  sheet.by["log score"] = mean_of(all, log_score);
  sheet.by["log score of singles, plain gap"] = mean_of(plain, log_score);
  sheet.by["seconds a case"] = mean_of(all, [&](std::size_t i) { return answers[i].seconds; });
}

void add_tables(const std::vector<SealedTruth>& truths, ScoreSheet& sheet) {
  std::map<std::string, std::vector<double>> by_effect, by_strength;
  for (std::size_t i = 0; i < truths.size(); ++i) {
    const SealedTruth& truth = truths[i];
    const CaseMark& mark = sheet.marks[i];
    const std::string label = truth_label(truth);
    ++sheet.confusion[truth.kind == "pair" ? "pair" : label][mark.stated];
    by_effect[label].push_back(mark.credit);
    const std::string strength = strength_class(truth.strength_in_noise_floors);
    if (truth.kind != "none") by_strength[truth.kind + ", gap " + strength].push_back(mark.credit);
  }
  for (const auto& [key, credits] : by_effect) sheet.credit_by_effect[key] = mean(credits);
  for (const auto& [key, credits] : by_strength) sheet.credit_by_strength[key] = mean(credits);
}

void add_reliability(const std::vector<CaseAnswer>& answers, ScoreSheet& sheet) {
  static const std::vector<double> edges = {0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 1.0};
  double distance = 0.0;
  int total = 0;
  for (std::size_t b = 0; b + 1 < edges.size(); ++b) {
    int right = 0, count = 0;
    double stated = 0.0;
    for (std::size_t i = 0; i < answers.size(); ++i) {
      const double p = sheet.marks[i].confidence;
      const bool abstains = answers[i].verdict == "insufficient" || answers[i].verdict == "failed";
      const bool last = b + 2 == edges.size();
      if (abstains || p < edges[b] || (last ? p > edges[b + 1] : p >= edges[b + 1])) continue;
      ++count;
      stated += p;
      if (sheet.marks[i].right) ++right;
    }
    const double mean_stated = count > 0 ? stated / count : kNaN;
    sheet.reliability.push_back({{edges[b], edges[b + 1]}, mean_stated, proportion(right, count)});
    if (count > 0) distance += count * std::abs(mean_stated - static_cast<double>(right) / count);
    total += count;
  }
  if (total > 0) sheet.calibration_error = distance / total;
}

}  // namespace

ScoreSheet make_sheet(const std::string& answerer, const std::vector<SealedTruth>& truths,
                      const std::vector<CaseAnswer>& answers) {
  ScoreSheet sheet;
  sheet.answerer = answerer;
  for (std::size_t i = 0; i < truths.size(); ++i) sheet.marks.push_back(mark_answer(truths[i], answers[i]));
  add_answers(truths, answers, sheet);
  add_quality(truths, answers, sheet);
  add_tables(truths, sheet);
  add_reliability(answers, sheet);
  return sheet;
}

const std::vector<Goal>& goals() {
  static const std::vector<Goal> list = {{"credit of singles, plain gap", true, 0.95},
                                         {"false alarms where there is nothing", false, 0.02},
                                         {"outside effects called unexplained, plain gap", true, 0.85},
                                         {"wrong and confident", false, 0.02},
                                         {"parameter error, median", false, 0.15},
                                         {"gap after over the possible one, median", false, 1.3}};
  return list;
}

void give_confidence(const std::vector<SealedTruth>& truths, std::vector<CaseAnswer>& answers) {
  int hits = 0;
  std::vector<bool> hit(truths.size());
  for (std::size_t i = 0; i < truths.size(); ++i) {
    hit[i] = !answers[i].effects.empty() && names_truth(truths[i], answers[i].effects.front().name);
    if (hit[i]) ++hits;
  }
  for (std::size_t i = 0; i < truths.size(); ++i) {
    CaseAnswer& answer = answers[i];
    if (answer.effects.empty()) continue;
    const int others = static_cast<int>(truths.size()) - 1;
    const double p = (hits - (hit[i] ? 1 : 0) + 1.0) / (others + 2.0);
    const double rest = (1.0 - p) / std::max<double>(1.0, static_cast<double>(answer.ranking.size()) - 1.0);
    for (auto& [name, probability] : answer.ranking) probability = name == answer.effects.front().name ? p : rest;
    answer.effects.front().probability = p;
  }
}

}  // namespace jaculus::evaluation
