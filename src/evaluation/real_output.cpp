// real.json, and the table on the terminal.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "jaculus/core/angle.h"
#include "jaculus/core/json.h"
#include "jaculus/evaluation/real.h"

namespace jaculus::evaluation {
namespace {

using Json = nlohmann::ordered_json;

std::string shown_verdict(const Prediction& prediction) {
  return prediction.verdict ? diagnosis::to_text(*prediction.verdict) : "no answer";
}

Json effect_json(const KnownEffectScore& e) {
  return {{"any_of", e.known.any_of},
          {"joint", e.known.joint},
          {"value", json_number(e.known.value)},
          {"unit", e.known.unit},
          {"named_as", e.named_as},
          {"probability", json_number(e.probability)},
          {"estimate", json_number(e.estimate)},
          {"ci95", {json_number(e.ci95.lower), json_number(e.ci95.upper)}},
          {"within", e.within}};
}

Json gap_json(const ChannelGap& gap) {
  return {
      {"unit", gap.unit}, {"before", json_number(gap.before)}, {"after", json_number(gap.after)}};
}

Json json_of(const RealScore& score) {
  Json effects = Json::array(), channels = Json::object();
  for (const KnownEffectScore& e : score.effects) effects.push_back(effect_json(e));
  for (const auto& [name, gap] : score.prediction.channels) channels[name] = gap_json(gap);

  return {{"name", score.name},
          {"known", score.known.has_value()},
          {"verdict", shown_verdict(score.prediction)},
          {"message", score.prediction.message},
          {"effects", effects},
          {"absent_named", score.absent_named},
          {"extra", score.extra},
          {"events",
           {{"known", score.known ? score.known->events.size() : 0},
            {"found", score.events_found},
            {"false", score.events_false}}},
          {"gap", channels},
          {"seconds", json_number(score.prediction.seconds)}};
}

/// Angles as people read them; everything else in its own unit.
std::string shown_gap(const std::string& name, const ChannelGap& gap) {
  const bool angle = gap.unit == "rad", rate = gap.unit == "rad/s", length = gap.unit == "m";
  const double factor = angle || rate ? kDegrees : length ? 1e3 : 1.0;
  const std::string unit = angle ? "deg" : rate ? "deg/s" : length ? "mm" : gap.unit;
  return fmt::format("    {:<28} {:>9.3g} -> {:<9.3g} {}\n", name, factor * gap.before,
                     factor * gap.after, unit);
}

std::string shown_effect(const KnownEffectScore& e) {
  const KnownEffect& k = e.known;
  std::string text = fmt::format("    known: {}{}{}\n", fmt::join(k.any_of, " or "),
                                 k.joint.empty() ? "" : " at " + k.joint,
                                 std::isnan(k.value) ? (k.remark.empty() ? "" : ", " + k.remark)
                                                     : fmt::format(", {:.4g} {}", k.value, k.unit));
  if (e.named_as.empty()) return text + "      not named\n";

  text += fmt::format("      named {} at {:.2f}", e.named_as, e.probability);
  if (!std::isnan(e.estimate)) {
    text += fmt::format(", {:.4g} [{:.4g}, {:.4g}] {}: {}", e.estimate, e.ci95.lower, e.ci95.upper,
                        k.unit, e.within ? "near enough" : "too far");
  }
  return text + "\n";
}

std::string text_of(const RealScore& score) {
  std::string text =
      fmt::format("{}: {}{}\n", score.name, shown_verdict(score.prediction),
                  score.prediction.message.empty() ? "" : ", " + score.prediction.message);
  if (!score.known) text += "    known: nothing for certain\n";
  for (const KnownEffectScore& e : score.effects) text += shown_effect(e);
  if (score.known && !score.known->events.empty()) {
    text += fmt::format("    events: {} of {} found, {} false\n", score.events_found,
                        score.known->events.size(), score.events_false);
  }
  if (!score.absent_named.empty())
    text += fmt::format("    wrong: {}\n", fmt::join(score.absent_named, ", "));
  if (!score.extra.empty())
    text += fmt::format("    beyond what is known: {}\n", fmt::join(score.extra, ", "));
  if (!score.prediction.channels.empty()) text += "    gap on held-out time, rms before -> after\n";
  for (const auto& [name, gap] : score.prediction.channels) text += shown_gap(name, gap);
  text += fmt::format("    {:.0f} s\n", score.prediction.seconds);
  return text;
}

}  // namespace

std::string real_json(const std::vector<RealScore>& scores) {
  Json json = {{"format", "jaculus-real/1"}, {"datasets", Json::array()}};
  for (const RealScore& score : scores) json["datasets"].push_back(json_of(score));
  return json.dump(1) + "\n";
}

std::string real_text(const std::vector<RealScore>& scores) {
  int known = 0, named = 0, within = 0, valued = 0, wrong = 0, extra = 0;
  std::string text;
  for (const RealScore& score : scores) {
    text += text_of(score);
    wrong += count_of(score.absent_named);
    extra += count_of(score.extra);
    for (const KnownEffectScore& e : score.effects) {
      ++known;
      if (!e.named_as.empty()) ++named;
      if (std::isnan(e.known.value)) continue;
      ++valued;
      if (e.within) ++within;
    }
  }

  return text + fmt::format(
                    "known effects named: {} of {}; values near enough: {} of {}; named though "
                    "absent: {}; beyond what is known: {}\n",
                    named, known, within, valued, wrong, extra);
}

}  // namespace jaculus::evaluation
