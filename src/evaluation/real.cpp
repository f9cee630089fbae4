#include "jaculus/evaluation/real.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "evaluation/run_diagnosis.h"
#include "jaculus/core/error.h"

namespace jaculus::evaluation {
namespace {

namespace fs = std::filesystem;

constexpr double kEventTime = 0.1;  ///< how near an event's middle has to be told [s]
constexpr double kEventPeak = 0.3;  ///< how near its peak, relative [-]

bool holds(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

bool at_joint(const NamedEffect& effect, const std::string& joint) {
  return joint.empty() || effect.joints.empty() || holds(effect.joints, joint);
}

KnownEffectScore score_effect(const KnownEffect& known, const Prediction& prediction) {
  KnownEffectScore score;
  score.known = known;

  for (const NamedEffect& effect : prediction.effects) {
    if (!holds(known.any_of, effect.name) || !at_joint(effect, known.joint)) continue;
    if (!score.named_as.empty() && effect.probability <= score.probability) continue;
    score.named_as = effect.name;
    score.probability = effect.probability;
    const auto value = effect.parameters.find(known.parameter);
    if (value == effect.parameters.end()) continue;
    score.estimate = value->second;
    const auto interval = effect.ci95.find(known.parameter);
    if (interval != effect.ci95.end()) score.ci95 = interval->second;
  }

  score.within = std::abs(score.estimate - known.value) <= known.within * std::abs(known.value);
  return score;
}

bool same_event(const KnownEvent& known, const SaidEvent& said) {
  const double apart = std::abs(0.5 * (said.from + said.to) - 0.5 * (known.from + known.to));
  return said.trial == known.trial && said.joint == known.joint && apart <= kEventTime &&
         std::abs(said.peak - known.peak) <= kEventPeak * std::abs(known.peak);
}

std::string shown_name(const fs::path& dataset) {
  const fs::path folder = fs::weakly_canonical(dataset);
  return (folder.parent_path().filename() / folder.filename()).string();
}

void write(const fs::path& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  if (!stream) throw InputError(fmt::format("{}: can't be written", file.string()));
}

}  // namespace

RealScore score_real(const std::string& name, const std::optional<KnownCause>& known,
                     const Prediction& prediction) {
  RealScore score;
  score.name = name;
  score.known = known;
  score.prediction = prediction;
  if (!known) return score;

  for (const KnownEffect& effect : known->effects)
    score.effects.push_back(score_effect(effect, prediction));

  for (const NamedEffect& effect : prediction.effects) {
    const bool is_known =
        std::any_of(known->effects.begin(), known->effects.end(), [&](const KnownEffect& k) {
          return holds(k.any_of, effect.name) && at_joint(effect, k.joint);
        });
    if (holds(known->absent, effect.name))
      score.absent_named.push_back(effect.name);
    else if (!is_known && !holds(known->listed, effect.name))
      score.extra.push_back(effect.name);
  }

  for (const KnownEvent& event : known->events) {
    if (std::any_of(prediction.events.begin(), prediction.events.end(),
                    [&](const SaidEvent& said) { return same_event(event, said); }))
      ++score.events_found;
  }
  for (const SaidEvent& said : prediction.events) {
    if (std::none_of(known->events.begin(), known->events.end(),
                     [&](const KnownEvent& event) { return same_event(event, said); }))
      ++score.events_false;
  }

  return score;
}

std::vector<RealScore> score_real_datasets(const std::vector<fs::path>& datasets,
                                           const RealOptions& options) {
  std::vector<std::optional<KnownCause>> known;
  for (const fs::path& dataset : datasets) {
    std::error_code code;
    if (!fs::exists(dataset / "dataset.yaml", code))
      throw InputError(
          fmt::format("{}: no dataset.yaml; allowed: a folder of a dataset", dataset.string()));
    known.push_back(known_cause_of(dataset));
  }

  std::vector<RealScore> scores;
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    const std::string name = shown_name(datasets[i]);
    if (options.notice) options.notice(name);
    const Prediction prediction = run_diagnosis({.binary = options.binary,
                                                 .dataset = datasets[i],
                                                 .keep = options.out / name,
                                                 .flags = {},
                                                 .seed = 1,
                                                 .time_limit_s = options.time_limit_s});
    scores.push_back(score_real(name, known[i], prediction));
  }

  write(options.out / "real.json", real_json(scores));
  write(options.out / "real.txt", real_text(scores));
  return scores;
}

}  // namespace jaculus::evaluation
