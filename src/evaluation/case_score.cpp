// One prediction against its truth.

#include "evaluation/case_score.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "evaluation/descriptions.h"
#include "evaluation/events.h"
#include "evaluation/names.h"
#include "jaculus/effects/select.h"

namespace jaculus::evaluation {

using diagnosis::Verdict;

bool names_truth(const CaseTruth& truth, const NamedEffect& effect) {
  const auto in = [&](const std::vector<std::string>& list) {
    return std::any_of(list.begin(), list.end(),
                       [&](const std::string& actual) { return is_named(actual, effect); });
  };
  return truth.kind != "outside" && (in(truth.effects) || in(truth.equivalent));
}

bool is_several(const CaseTruth& truth) { return truth.kind == "several" || truth.kind == "pair"; }

bool is_alarm(const Prediction& prediction) {
  return prediction.verdict && diagnosis::names_effects(*prediction.verdict);
}

bool is_parted(const CaseTruth& truth) {
  constexpr double kApart = 0.02;  // [rad]
  const bool otherwise = truth.kind == "outside" || truth.kind == "mixed" || truth.kind == "event";
  return !otherwise && truth.legs_apart > kApart;
}

std::optional<bool> is_told(const CaseTruth& truth) {
  if (!truth.possible) return {};
  constexpr double kLessError = 0.95, kLogGain = 10.0;
  const PossibleGap& gap = *truth.possible;
  return gap.after <= kLessError * gap.tolerances && gap.log_gain >= kLogGain;
}

bool has_remainder(const CaseTruth& truth) {
  return truth.kind == "outside" || truth.kind == "mixed" || is_parted(truth);
}

std::string truth_label(const CaseTruth& truth) {
  if (truth.kind == "none" || truth.kind == "outside" || truth.kind == "event") return truth.kind;
  std::string label;
  for (const std::string& effect : truth.effects) label += (label.empty() ? "" : " + ") + effect;
  return label;
}

namespace {

constexpr double kLeastProbability = 1e-3;

/// Whether the effects that are named are said to act together, each with a probability of its own.
bool names_together(const Prediction& prediction) {
  return prediction.verdict == Verdict::several || prediction.verdict == Verdict::partial;
}

/// Of the true effect and its equivalents: as stated where named, brought to a sum of one where
/// more is claimed, else as ranked. What is named at another joint isn't ranked for this one.
double class_probability(const CaseTruth& truth, const Prediction& prediction) {
  double claimed = 0.0, sum = 0.0;
  for (const NamedEffect& e : prediction.effects) claimed += e.probability;

  std::set<std::string> settled;
  for (const NamedEffect& e : prediction.effects) {
    const bool right = names_truth(truth, e);
    if (names_together(prediction) && right) continue;
    settled.insert(e.name);
    if (right) sum += e.probability / std::max(1.0, claimed);
  }
  for (const auto& [ranked, p] : prediction.ranking) {
    NamedEffect effect;
    effect.name = ranked;
    if (settled.count(ranked) == 0 && names_truth(truth, effect)) sum += p;
  }

  return std::min(sum, 1.0);
}

/// Probability of "none" or "unexplained": as ranked, else what the effects leave, given to the
/// verdict if it is one of the two.
double abstention_probability(const Prediction& prediction, Verdict which) {
  const auto ranked = prediction.ranking.find(to_text(which));
  if (ranked != prediction.ranking.end()) return ranked->second;
  const Verdict other = which == Verdict::none ? Verdict::unexplained : Verdict::none;

  double taken = 0.0;
  for (const auto& [name, p] : prediction.ranking) taken += p;
  if (prediction.ranking.empty()) {
    for (const NamedEffect& e : prediction.effects) taken += e.probability;
  }
  const double left = std::max(0.0, 1.0 - taken);
  if (prediction.ranking.count(to_text(other)) != 0 || prediction.verdict == which) return left;
  return prediction.verdict == other ? 0.0 : 0.5 * left;
}

/// Parts of a ranked set, "a + b".
std::vector<std::string> parts_of(const std::string& ranked) {
  std::vector<std::string> parts;
  for (std::size_t from = 0;;) {
    const std::size_t to = ranked.find(" + ", from);
    parts.push_back(ranked.substr(from, to == std::string::npos ? to : to - from));
    if (to == std::string::npos) return parts;
    from = to + 3;
  }
}

/// Of all ranked sets of the true size that hold the true ones, an equivalent counting as one of
/// them.
double set_probability(const CaseTruth& truth, const Prediction& prediction) {
  double sum = 0.0;
  for (const auto& [ranked, p] : prediction.ranking) {
    const std::vector<std::string> parts = parts_of(ranked);
    int literal = 0, right = 0;
    for (const std::string& part : parts) {
      NamedEffect effect;
      effect.name = part;
      right += names_truth(truth, effect) ? 1 : 0;
      literal += std::any_of(truth.effects.begin(), truth.effects.end(),
                             [&](const std::string& actual) { return is_named(actual, effect); })
                     ? 1
                     : 0;
    }
    const int size = count_of(truth.effects);
    if (count_of(parts) == size && right == size && literal >= size - 1) sum += p;
  }
  return std::min(sum, 1.0);
}

/// Whether all pushes of a case are told.
bool events_found(const CaseTruth& truth, const Prediction& prediction) {
  return !truth.events.empty() && count_events(truth, prediction).found == count_of(truth.events);
}

double truth_probability(const CaseTruth& truth, const Prediction& prediction) {
  const bool silent =
      !prediction.verdict || prediction.verdict == Verdict::insufficient;  // no probability at all
  if (silent && prediction.ranking.empty() && prediction.effects.empty()) return 0.0;
  const auto without = [&](Verdict which) { return abstention_probability(prediction, which); };
  if (truth.kind == "none") return without(Verdict::none);
  if (truth.kind == "outside") return without(Verdict::unexplained);
  if (truth.kind == "event") {
    return events_found(truth, prediction)
               ? std::min(1.0, without(Verdict::none) + without(Verdict::unexplained))
               : 0.0;
  }
  if (is_several(truth)) return set_probability(truth, prediction);
  return class_probability(truth, prediction);
}

int members_named(const CaseTruth& truth, const Prediction& prediction) {
  int named = 0;
  for (const NamedEffect& effect : prediction.effects) named += names_truth(truth, effect) ? 1 : 0;
  return named;
}

double credit_of(const CaseTruth& truth, const Prediction& prediction) {
  if (truth.kind == "none") return prediction.verdict == Verdict::none ? 1.0 : 0.0;
  if (truth.kind == "outside") return prediction.verdict == Verdict::unexplained ? 1.0 : 0.0;
  if (truth.kind == "event")
    return events_found(truth, prediction) && !is_alarm(prediction) ? 1.0 : 0.0;
  if (!is_alarm(prediction)) return 0.0;
  const int size = count_of(prediction.effects);
  const int named = members_named(truth, prediction);
  if (named == 0) return 0.0;
  if (truth.kind == "single" || truth.kind == "mixed") return 1.0 / (1 + size - named);
  const int members = count_of(truth.effects);
  return static_cast<double>(std::min(named, members)) / std::max(members, size);
}

const NamedEffect* most_probable(const Prediction& prediction) {
  const auto top =
      std::max_element(prediction.effects.begin(), prediction.effects.end(),
                       [](const auto& a, const auto& b) { return a.probability < b.probability; });
  return top == prediction.effects.end() ? nullptr : &*top;
}

/// Whether all that is named acts, and more does where that is said, else nothing more.
bool holds(const CaseTruth& truth, const Prediction& prediction, int named) {
  const int said = count_of(prediction.effects), acting = count_of(truth.effects);
  if (named != said) return false;
  if (prediction.verdict == Verdict::several) return is_several(truth) && said == acting;
  return has_remainder(truth) || said < acting;
}

void state(const CaseTruth& truth, const Prediction& prediction, CaseScore& score) {
  score.stated = prediction.verdict ? to_text(*prediction.verdict) : "failed";
  if (!is_alarm(prediction)) {
    const bool judged =
        prediction.verdict == Verdict::none || prediction.verdict == Verdict::unexplained;
    score.confidence = judged ? abstention_probability(prediction, *prediction.verdict) : 0.0;
    // Legs that part are nothing that a model in the plane holds: to name nothing is right.
    const bool beyond_plane = is_parted(truth) && prediction.verdict == Verdict::unexplained;
    score.right = score.top1 = score.credit == 1.0 || beyond_plane;
    return;
  }

  const NamedEffect* top = most_probable(prediction);
  if (top == nullptr) return;
  const int named = members_named(truth, prediction);
  score.stated = top->name;
  score.top1 = names_truth(truth, *top);
  score.right = named > 0;
  if (names_together(prediction)) {
    score.stated.clear();
    score.confidence = 1.0;
    for (const NamedEffect& e : prediction.effects) {
      score.stated += (score.stated.empty() ? "" : " + ") + e.name;
      score.confidence *= e.probability;
    }
    if (prediction.verdict == Verdict::partial) score.stated += " + more";
    score.right = holds(truth, prediction, named);
    return;
  }

  for (const NamedEffect& e : prediction.effects) score.confidence += e.probability;
  score.confidence = std::min(score.confidence, 1.0);
}

/// Estimates of rightly named effects against the true parameters, in the catalogue's own terms.
void judge_parameters(const CaseTruth& truth, const Prediction& prediction, CaseScore& score) {
  for (std::size_t t = 0; t < truth.effects.size() && t < truth.parameters.size(); ++t) {
    const effects::Effect* effect = effects::find_effect(placed_name(truth.effects[t]).name);
    if (effect == nullptr) continue;
    const auto named =
        std::find_if(prediction.effects.begin(), prediction.effects.end(),
                     [&](const NamedEffect& e) { return is_named(truth.effects[t], e); });
    if (named == prediction.effects.end()) continue;

    for (std::size_t i = 0; i < effect->parameters.size() && i < truth.parameters[t].size(); ++i) {
      const effects::EffectParameter& p = effect->parameters[i];
      const std::string& shown = p.shown_name();
      const double actual = truth.parameters[t][i];
      const auto value = named->parameters.find(shown);
      if (std::isnan(actual) || value == named->parameters.end() || std::isnan(value->second))
        continue;
      if (i == 0 && truth.kind == "single" && actual != p.nominal)
        score.parameter_error =
            std::abs(effects::own_value(p, value->second) - actual) / std::abs(actual - p.nominal);
      const auto ci = named->ci95.find(shown);
      if (ci == named->ci95.end()) continue;
      ++score.parameters_judged;
      if (ci->second.contains(effects::shown_value(p, actual))) ++score.parameters_covered;
    }
  }
}

bool component_right(const CaseTruth& truth, const Prediction& prediction) {
  const auto largest =
      std::max_element(prediction.components.begin(), prediction.components.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  if (largest == prediction.components.end()) return false;
  if (largest->first == truth.component) return true;
  for (const std::string& name : truth.effects) {
    const effects::Effect* effect = effects::find_effect(placed_name(name).name);
    if (effect == nullptr) continue;
    for (int c = 0; c < effects::kComponentCount; ++c) {
      const auto component = static_cast<effects::Component>(c);
      if (effect->acts_in(component) && largest->first == effects::component_name(component))
        return true;
    }
  }
  return false;
}

/// Of the gap's energy above one floor: what is explained over what the true effects explain.
double energy_ratio(const CaseTruth& truth, const Prediction& prediction) {
  if (!truth.possible) return kNaN;
  const auto above = [](double gap) { return std::max(0.0, gap * gap - 1.0); };
  const double before = above(prediction.gap_before);
  const double possible = before - above(truth.possible->after);
  if (!(before > 0.0) || !(possible > 0.0)) return kNaN;
  return (before - above(prediction.gap_after)) / possible;
}

}  // namespace

CaseScore score_case(const CaseTruth& truth, const Prediction& prediction) {
  CaseScore score;
  score.credit = credit_of(truth, prediction);
  score.log_score = std::log(std::max(kLeastProbability, truth_probability(truth, prediction)));
  state(truth, prediction, score);
  score.component_right = component_right(truth, prediction);
  judge_parameters(truth, prediction, score);
  if (truth.possible && truth.possible->after > 0.0)
    score.shrink_ratio = prediction.gap_after / truth.possible->after;
  score.energy_ratio = energy_ratio(truth, prediction);
  // That left and right part is what is to be said of those that do, and of no others.
  score.remainder = prediction.remainder || (is_parted(truth) && prediction.parted);
  const EventCounts events = count_events(truth, prediction);
  score.events_found = events.found;
  score.events_invented = events.invented;
  score.described = !prediction.described.empty();
  if (const RightDescription* right = described_kind(truth)) {
    score.place_right = place_right(*right, prediction);
    score.family_credit = family_credit(*right, prediction);
  }
  return score;
}

}  // namespace jaculus::evaluation
