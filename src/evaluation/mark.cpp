// One answer against its truth.

#include "evaluation/mark.h"

#include <algorithm>
#include <cmath>

#include "jaculus/effects/select.h"

namespace jaculus {
namespace evaluation {

bool names_truth(const SealedTruth& truth, const std::string& effect) {
  const auto in = [&](const std::vector<std::string>& list) {
    return std::find(list.begin(), list.end(), effect) != list.end();
  };
  return truth.kind != "outside" && (in(truth.effects) || in(truth.equivalent));
}

bool is_alarm(const CaseAnswer& answer) {
  return answer.verdict == "effect" || answer.verdict == "several" || answer.verdict == "ambiguous";
}

std::string truth_label(const SealedTruth& truth) {
  if (truth.kind == "none" || truth.kind == "outside") return truth.kind;
  std::string label;
  for (const std::string& effect : truth.effects) label += (label.empty() ? "" : " + ") + effect;
  return label;
}

}  // namespace evaluation

namespace {

using namespace evaluation;

constexpr double kLeastProbability = 1e-3;

/// As stated for a named effect, brought to a sum of one where more is claimed; else as ranked.
double effect_probability(const CaseAnswer& answer, const std::string& name) {
  double claimed = 0.0, stated = -1.0;
  for (const NamedEffect& e : answer.effects) {
    claimed += e.probability;
    if (e.name == name) stated = e.probability;
  }
  if (stated >= 0.0 && answer.verdict != "several") return stated / std::max(1.0, claimed);
  const auto ranked = answer.ranking.find(name);
  return ranked == answer.ranking.end() ? 0.0 : ranked->second;
}

/// Probability of "none" or "unexplained": as ranked, else what the effects leave, given to the verdict if it is one of the two.
double abstention_probability(const CaseAnswer& answer, const std::string& which) {
  const auto ranked = answer.ranking.find(which);
  if (ranked != answer.ranking.end()) return ranked->second;
  const std::string other = which == "none" ? "unexplained" : "none";
  double taken = 0.0;
  for (const auto& [name, p] : answer.ranking) taken += p;
  if (answer.ranking.empty()) {
    for (const NamedEffect& e : answer.effects) taken += e.probability;
  }
  const double left = std::max(0.0, 1.0 - taken);
  if (answer.ranking.count(other) != 0 || answer.verdict == which) return left;
  return answer.verdict == other ? 0.0 : 0.5 * left;
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

/// Of all ranked sets of two that hold the true two, an equivalent of one counting as it.
double pair_probability(const SealedTruth& truth, const CaseAnswer& answer) {
  double sum = 0.0;
  for (const auto& [ranked, p] : answer.ranking) {
    const std::vector<std::string> parts = parts_of(ranked);
    const auto true_part = [&](const std::string& part) { return names_truth(truth, part); };
    const bool one_is_true = std::any_of(truth.effects.begin(), truth.effects.end(), [&](const std::string& effect) {
      return std::find(parts.begin(), parts.end(), effect) != parts.end();
    });
    if (parts.size() == 2 && one_is_true && std::all_of(parts.begin(), parts.end(), true_part)) sum += p;
  }
  return std::min(sum, 1.0);
}

double truth_probability(const SealedTruth& truth, const CaseAnswer& answer) {
  if (truth.kind == "none") return abstention_probability(answer, "none");
  if (truth.kind == "outside") return abstention_probability(answer, "unexplained");
  if (truth.kind == "pair") return pair_probability(truth, answer);
  double sum = effect_probability(answer, truth.effects.front());
  for (const std::string& name : truth.equivalent) {
    if (name != truth.effects.front()) sum += effect_probability(answer, name);
  }
  return std::min(sum, 1.0);
}

int members_named(const SealedTruth& truth, const CaseAnswer& answer) {
  return static_cast<int>(std::count_if(answer.effects.begin(), answer.effects.end(),
                                        [&](const NamedEffect& e) { return names_truth(truth, e.name); }));
}

double credit_of(const SealedTruth& truth, const CaseAnswer& answer) {
  if (truth.kind == "none") return answer.verdict == "none" ? 1.0 : 0.0;
  if (truth.kind == "outside") return answer.verdict == "unexplained" ? 1.0 : 0.0;
  if (!is_alarm(answer)) return 0.0;
  const int size = static_cast<int>(answer.effects.size());
  const int named = members_named(truth, answer);
  if (named == 0) return 0.0;
  if (truth.kind == "single") return 1.0 / (1 + size - named);
  return static_cast<double>(std::min(named, 2)) / std::max(2, size);
}

const NamedEffect* most_probable(const CaseAnswer& answer) {
  const auto top = std::max_element(answer.effects.begin(), answer.effects.end(),
                                    [](const auto& a, const auto& b) { return a.probability < b.probability; });
  return top == answer.effects.end() ? nullptr : &*top;
}

void state(const SealedTruth& truth, const CaseAnswer& answer, CaseMark& mark) {
  mark.stated = answer.verdict;
  if (!is_alarm(answer)) {
    const bool judged = answer.verdict == "none" || answer.verdict == "unexplained";
    mark.confidence = judged ? abstention_probability(answer, answer.verdict) : 0.0;
    mark.right = mark.top1 = mark.credit == 1.0;
    return;
  }
  const NamedEffect* top = most_probable(answer);
  if (top == nullptr) return;
  const int named = members_named(truth, answer);
  mark.stated = top->name;
  mark.top1 = names_truth(truth, top->name);
  mark.right = named > 0;
  if (answer.verdict == "several") {
    mark.stated.clear();
    mark.confidence = 1.0;
    for (const NamedEffect& e : answer.effects) {
      mark.stated += (mark.stated.empty() ? "" : " + ") + e.name;
      mark.confidence *= e.probability;
    }
    mark.right = truth.kind == "pair" && named == 2 && answer.effects.size() == 2;
    return;
  }
  for (const NamedEffect& e : answer.effects) mark.confidence += e.probability;
  mark.confidence = std::min(mark.confidence, 1.0);
}

/// Estimates of rightly named effects against what was sealed, in the catalogue's own terms.
void judge_parameters(const SealedTruth& truth, const CaseAnswer& answer, CaseMark& mark) {
  for (std::size_t t = 0; t < truth.effects.size() && t < truth.parameters.size(); ++t) {
    const Effect* effect = find_effect(truth.effects[t]);
    if (effect == nullptr) continue;
    const auto named = std::find_if(answer.effects.begin(), answer.effects.end(),
                                    [&](const NamedEffect& e) { return e.name == effect->name; });
    if (named == answer.effects.end()) continue;
    for (std::size_t i = 0; i < effect->parameters.size() && i < truth.parameters[t].size(); ++i) {
      const EffectParameter& p = effect->parameters[i];
      const std::string shown = p.shown_as.empty() ? p.name : p.shown_name;
      const double sealed = truth.parameters[t][i];
      const auto value = named->parameters.find(shown);
      if (std::isnan(sealed) || value == named->parameters.end() || std::isnan(value->second)) continue;
      if (i == 0 && truth.kind == "single" && sealed != p.nominal)
        mark.parameter_error = std::abs(own_value(p, value->second) - sealed) / std::abs(sealed - p.nominal);
      const auto ci = named->ci95.find(shown);
      if (ci == named->ci95.end()) continue;
      ++mark.parameters_judged;
      if (ci->second.contains(shown_value(p, sealed))) ++mark.parameters_covered;
    }
  }
}

bool component_right(const SealedTruth& truth, const CaseAnswer& answer) {
  const auto largest = std::max_element(answer.components.begin(), answer.components.end(),
                                        [](const auto& a, const auto& b) { return a.second < b.second; });
  if (largest == answer.components.end()) return false;
  if (largest->first == truth.component) return true;
  for (const std::string& name : truth.effects) {
    const Effect* effect = find_effect(name);
    if (effect == nullptr) continue;
    for (int c = 0; c < kComponentCount; ++c) {
      const auto component = static_cast<Component>(c);
      if (effect->acts_in(component) && largest->first == component_name(component)) return true;
    }
  }
  return false;
}

}  // namespace

CaseMark mark_answer(const SealedTruth& truth, const CaseAnswer& answer) {
  CaseMark mark;
  mark.credit = credit_of(truth, answer);
  mark.log_score = std::log(std::max(kLeastProbability, truth_probability(truth, answer)));
  state(truth, answer, mark);
  mark.component_right = component_right(truth, answer);
  judge_parameters(truth, answer, mark);
  if (truth.possible_after_gap > 0.0) mark.shrink_ratio = answer.gap_after / truth.possible_after_gap;
  return mark;
}

}  // namespace jaculus
