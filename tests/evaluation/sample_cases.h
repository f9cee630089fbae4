#pragma once
// Truths and predictions small enough to be marked by hand.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "jaculus/evaluation/predictions.h"

namespace jaculus::test {

inline evaluation::CaseTruth single(const std::string& effect,
                                    std::vector<std::string> equivalent = {}) {
  evaluation::CaseTruth truth;
  truth.case_id = "case";
  truth.kind = "single";
  truth.effects = {effect};
  truth.parameters = {{0.01, kNaN}};
  truth.strength_in_noise_floors = 5.0;
  truth.equivalent = std::move(equivalent);
  truth.component = "tail_transmission";
  truth.possible = evaluation::PossibleGap{.after = 1.1};
  return truth;
}

inline evaluation::CaseTruth of_kind(const std::string& kind) {
  evaluation::CaseTruth truth;
  truth.kind = kind;
  truth.strength_in_noise_floors = kind == "none" ? 0.0 : 6.0;
  return truth;
}

/// A verdict with the probabilities of what it names.
inline evaluation::Prediction says(
    std::optional<diagnosis::Verdict> verdict,
    const std::vector<std::pair<std::string, double>>& effects = {}) {
  evaluation::Prediction prediction;
  prediction.verdict = verdict;
  for (const auto& [name, p] : effects) {
    evaluation::NamedEffect effect;
    effect.name = name;
    effect.probability = p;
    prediction.effects.push_back(effect);
    prediction.ranking[name] = p;
  }
  return prediction;
}

/// A case of four trials in which something pushes at the elbow.
inline evaluation::CaseTruth push() {
  evaluation::CaseTruth truth = of_kind("event");
  truth.events = {{"elbow", 0.40, 0.60, -2.0}};
  truth.trials = 4;
  return truth;
}

/// Nothing named, and a push of this middle and peak.
inline evaluation::Prediction tells(double middle, double peak, const std::string& joint = "elbow",
                                    const std::string& trial = "trial_01") {
  evaluation::Prediction prediction = says(diagnosis::Verdict::none);
  prediction.ranking["none"] = 0.9;
  prediction.events = {{trial, joint, middle - 0.05, middle + 0.05, peak}};
  return prediction;
}

}  // namespace jaculus::test
