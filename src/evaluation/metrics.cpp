#include "evaluation/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "evaluation/case_score.h"
#include "evaluation/descriptions.h"
#include "evaluation/estimates.h"

namespace jaculus::evaluation {
namespace {

using diagnosis::Verdict;
using Picks = std::vector<std::size_t>;

constexpr double kRounding = 1e-9;  ///< of a sum of probabilities that makes 0.8

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

/// Whether a verdict was given.
std::function<bool(std::size_t)> verdict_is(const std::vector<Prediction>& predictions,
                                            std::optional<Verdict> verdict) {
  return [&predictions, verdict](std::size_t i) { return predictions[i].verdict == verdict; };
}

void add_names(const std::vector<CaseTruth>& truths, Metrics& metrics) {
  const auto credit = [&](std::size_t i) { return metrics.scores[i].credit; };
  const auto top1 = [&](std::size_t i) { return metrics.scores[i].top1; };
  const Picks plain = pick(truths, kind_is("single", kPlainGap)),
              singles = pick(truths, kind_is("single"));
  const Picks several = pick(truths, [](const CaseTruth& truth) {
    return is_several(truth) && truth.strength_in_noise_floors >= kPlainGap && !is_parted(truth);
  });

  metrics.by["credit of singles, plain gap"] = mean_of(plain, credit);
  metrics.by["credit of singles, any gap"] = mean_of(singles, credit);
  metrics.by["first place of singles, plain gap"] = share(plain, top1);
  metrics.by["first place of singles, any gap"] = share(singles, top1);
  metrics.by["credit of several, plain gap"] = mean_of(several, credit);
  metrics.by["several named in full, plain gap"] =
      share(several, [&](std::size_t i) { return metrics.scores[i].right; });
  const Picks asked = pick(truths, [](const CaseTruth& truth) {
    return kind_is("single", kPlainGap)(truth) && is_told(truth).has_value();
  });
  const Picks told = pick(truths, [](const CaseTruth& truth) {
    return kind_is("single", kPlainGap)(truth) && is_told(truth).value_or(false);
  });
  metrics.by["singles that held-out trials tell, plain gap"] =
      share(asked, [&](std::size_t i) { return *is_told(truths[i]); });
  metrics.by["credit of singles that held-out trials tell, plain gap"] = mean_of(told, credit);
  metrics.by["mixed: named part named, plain gap"] =
      mean_of(pick(truths, mixed_with_plain(0)), credit);
}

void add_abstentions(const std::vector<CaseTruth>& truths,
                     const std::vector<Prediction>& predictions, Metrics& metrics) {
  const auto alarm = [&](std::size_t i) { return is_alarm(predictions[i]); };
  const auto unexplained = verdict_is(predictions, Verdict::unexplained);
  const Picks none = pick(truths, kind_is("none"));
  const Picks outside = pick(truths, kind_is("outside", kPlainGap));
  metrics.by["false alarms where there is nothing"] = share(none, alarm);
  metrics.by["called unexplained where there is nothing"] = share(none, unexplained);
  metrics.by["outside effects called unexplained, plain gap"] = share(outside, unexplained);
  metrics.by["outside effects blamed on the catalogue, plain gap"] = share(outside, alarm);
  metrics.by["legs that part called unexplained"] = share(pick(truths, is_parted), unexplained);
}

void add_remainders(const std::vector<CaseTruth>& truths, Metrics& metrics) {
  const auto remainder = [&](std::size_t i) { return metrics.scores[i].remainder; };
  metrics.by["mixed: remainder said, plain gap"] =
      share(pick(truths, mixed_with_plain(1)), remainder);
  // A push is said as an event, which is no remainder to be judged either way.
  const Picks complete = pick(truths, [](const CaseTruth& truth) {
    return truth.kind != "event" && !has_remainder(truth);
  });
  metrics.by["remainder said where there is none"] = share(complete, remainder);
  metrics.by["remainder said where there is one"] = share(pick(truths, has_remainder), remainder);
}

/// Whether what was drawn has been named in full, so that nothing is left to describe.
bool nothing_left(const CaseTruth& truth, const Prediction& prediction, const CaseScore& score) {
  if (truth.kind == "none") return !is_parted(truth);
  const bool listed = truth.kind == "single" || is_several(truth);
  return listed && !is_parted(truth) && is_alarm(prediction) && score.credit == 1.0;
}

void add_descriptions(const std::vector<CaseTruth>& truths,
                      const std::vector<Prediction>& predictions, Metrics& metrics) {
  const auto place = [&](std::size_t i) { return metrics.scores[i].place_right; };
  const auto family = [&](std::size_t i) { return metrics.scores[i].family_credit; };
  const auto said = [&](std::size_t i) { return metrics.scores[i].described; };
  const auto plain_beside = mixed_with_plain(1);
  const Picks any = pick(truths, [](const CaseTruth& t) { return described_kind(t) != nullptr; });
  const Picks plain = pick(truths, [&](const CaseTruth& t) {
    return described_kind(t) != nullptr && (kind_is("outside", kPlainGap)(t) || plain_beside(t));
  });
  Picks complete;
  for (std::size_t i = 0; i < truths.size(); ++i)
    if (nothing_left(truths[i], predictions[i], metrics.scores[i])) complete.push_back(i);

  metrics.by["descriptions: place right, plain gap"] = share(plain, place);
  metrics.by["descriptions: place right, any gap"] = share(any, place);
  metrics.by["descriptions: family right, plain gap"] = mean_of(plain, family);
  metrics.by["descriptions: family right, any gap"] = mean_of(any, family);
  metrics.by["descriptions: something said, plain gap"] = share(plain, said);
  metrics.by["descriptions where nothing is left"] = share(complete, said);
}

void add_overall(const std::vector<CaseTruth>& truths, const std::vector<Prediction>& predictions,
                 Metrics& metrics) {
  const Picks all = pick(truths, [](const CaseTruth&) { return true; });
  metrics.by["wrong and confident"] = share(all, [&](std::size_t i) {
    return !metrics.scores[i].right && metrics.scores[i].confidence >= kConfident - kRounding;
  });
  metrics.by["insufficient"] = share(all, verdict_is(predictions, Verdict::insufficient));
  metrics.by["no answer"] = share(all, verdict_is(predictions, std::nullopt));
  metrics.by["right over all cases"] =
      mean_of(all, [&](std::size_t i) { return metrics.scores[i].credit; });
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

  Picks with_ratio;
  for (const std::size_t i : plain) {
    const CaseScore& score = metrics.scores[i];
    if (!std::isnan(score.parameter_error)) errors.push_back(score.parameter_error);
    if (std::isnan(score.shrink_ratio)) continue;
    ratios.push_back(score.shrink_ratio);
    with_ratio.push_back(i);
  }

  metrics.by["parameter error, median"] = median(errors);
  int covered = 0, judged = 0;
  for (const CaseScore& score : metrics.scores) {  // whatever kind of case the effect was named in
    covered += score.parameters_covered;
    judged += score.parameters_judged;
  }
  metrics.by["parameters covered by their intervals"] = proportion(covered, judged);
  metrics.by["gap after over the possible one, median"] = median(ratios);
  metrics.by["energy explained over the possible, plain gap"] =
      mean_of(plain, [&](std::size_t i) { return metrics.scores[i].energy_ratio; });
  metrics.by["gap after within 1.3 of the possible one"] =
      share(with_ratio, [&](std::size_t i) { return metrics.scores[i].shrink_ratio <= 1.3; });
  const auto log_score = [&](std::size_t i) { return metrics.scores[i].log_score; };
  metrics.by["log score"] = mean_of(all, log_score);
  metrics.by["log score of singles, plain gap"] = mean_of(plain, log_score);
  metrics.seconds = mean_of(all, [&](std::size_t i) { return predictions[i].seconds; });
}

void add_events(const std::vector<CaseTruth>& truths, Metrics& metrics) {
  metrics.by["events found"] = share(pick(truths, kind_is("event")), [&](std::size_t i) {
    return !truths[i].events.empty() &&
           metrics.scores[i].events_found == count_of(truths[i].events);
  });
  const Picks all = pick(truths, [](const CaseTruth& truth) { return truth.trials > 0; });
  metrics.by["events credit: found and nothing else named"] = mean_of(
      pick(truths, kind_is("event")), [&](std::size_t i) { return metrics.scores[i].credit; });
  metrics.by["false events a trial"] = mean_of(all, [&](std::size_t i) {
    return static_cast<double>(metrics.scores[i].events_invented) / truths[i].trials;
  });
}

void add_tables(const std::vector<CaseTruth>& truths, Metrics& metrics) {
  std::map<std::string, std::vector<double>> by_effect, by_strength;
  for (std::size_t i = 0; i < truths.size(); ++i) {
    const CaseTruth& truth = truths[i];
    const CaseScore& score = metrics.scores[i];
    const std::string label = truth_label(truth);
    ++metrics.confusion[is_several(truth) ? "several" : label][score.stated];
    by_effect[label].push_back(score.credit);
    const std::string strength = strength_class(truth.strength_in_noise_floors);
    if (truth.kind != "none") by_strength[truth.kind + ", gap " + strength].push_back(score.credit);
  }
  for (const auto& [key, credits] : by_effect) metrics.credit_by_effect[key] = mean(credits);
  for (const auto& [key, credits] : by_strength) metrics.credit_by_strength[key] = mean(credits);
}

}  // namespace

Metrics compute_metrics(const std::string& predictor, const std::vector<CaseTruth>& truths,
                        const std::vector<Prediction>& predictions) {
  Metrics metrics;
  metrics.predictor = predictor;
  for (std::size_t i = 0; i < truths.size(); ++i)
    metrics.scores.push_back(score_case(truths[i], predictions[i]));
  add_names(truths, metrics);
  add_abstentions(truths, predictions, metrics);
  add_remainders(truths, metrics);
  add_descriptions(truths, predictions, metrics);
  add_overall(truths, predictions, metrics);
  add_quality(truths, predictions, metrics);
  add_events(truths, metrics);
  add_tables(truths, metrics);
  add_reliability(predictions, metrics);
  return metrics;
}

}  // namespace jaculus::evaluation
