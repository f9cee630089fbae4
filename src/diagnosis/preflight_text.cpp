// A preflight for terminals.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/units.h"
#include "jaculus/diagnosis/preflight.h"

namespace jaculus::diagnosis {
namespace {

constexpr std::size_t kPairLines = 30, kNextLines = 5;

/// A Bayes factor's logarithm; beyond a hundred it is no matter how much.
std::string factor_text(double log_factor) {
  if (std::isnan(log_factor)) return "-";
  return log_factor > 100.0 ? "> 100" : fmt::format("{:.1f}", log_factor);
}

/// "one pair", "3 pairs".
std::string counted(double count, const std::string& what) {
  return count == 1.0 ? "one " + what : fmt::format("{:.3g} {}s", count, what);
}

/// Two digits without an exponent; from a thousand on all of them.
std::string rough(double value) {
  if (!std::isfinite(value) || value == 0.0) return fmt::format("{}", value);
  const int digits =
      std::clamp(1 - static_cast<int>(std::floor(std::log10(std::abs(value)))), 0, 6);
  return fmt::format("{:.{}f}", value, digits);
}

std::string least_text(const PlannedEffect& e) {
  if (!e.structural) return "changes nothing that is recorded";
  if (std::isnan(e.least)) return "not within its bounds";
  std::string text = fmt::format("{} {:.3g}{}", e.parameter, e.least, after_number(e.unit));
  text += fmt::format(" ({} prior scales", rough(e.least_scales));
  if (std::isfinite(e.least_of_bounds))
    text += fmt::format(", {} % of its bound", rough(100.0 * e.least_of_bounds));
  return text + ")";
}

std::string effects_table(const Preflight& p) {
  std::string text =
      fmt::format("{:<34} {:>8} {:>6}  {}\n", "effect", "log odds", "gap", "named from");
  for (const PlannedEffect& e : p.effects)
    text += fmt::format("{:<34} {:>8} {:>6.2f}  {}\n", e.name, factor_text(e.log_odds), e.gap,
                        least_text(e));
  return text + fmt::format("log odds against none and gap [noise floors]: at {}\n",
                            counted(p.size, "probing step"));
}

std::vector<const PlannedPair*> pairs_not_told(const Preflight& p) {
  std::vector<const PlannedPair*> out;
  for (const PlannedPair& pair : p.pairs)
    if (!pair.tellable) out.push_back(&pair);
  return out;
}

std::string pair_line(const PlannedPair& pair) {
  std::string text =
      fmt::format("  {} / {}: log Bayes factor {} / {}{}", pair.a, pair.b, factor_text(pair.told_a),
                  factor_text(pair.told_b), pair.structural ? ", the same in exact data" : "");
  if (pair.by.empty()) return text + "\n";
  const TellingChange& best = pair.by.front();
  return text + fmt::format("\n    told by {} {} ({})\n", best.kind, best.name,
                            factor_text(best.log_bayes_factor));
}

std::string pairs_table(const Preflight& p) {
  const std::vector<const PlannedPair*> pairs = pairs_not_told(p);
  if (pairs.empty()) return {};
  std::string text = "not told apart (first at work / second at work; taken: for the other):\n";
  for (std::size_t i = 0; i < std::min(pairs.size(), kPairLines); ++i) text += pair_line(*pairs[i]);
  if (pairs.size() > kPairLines)
    text += fmt::format("  and {} more (preflight.json)\n",
                        counted(static_cast<double>(pairs.size() - kPairLines), "pair"));
  return text;
}

std::string following_table(const Preflight& p) {
  if (p.following.empty()) return {};
  std::string text = fmt::format(
      "information on which effect is at work, of {:.2f} bit: planned {:.2f} bit; with\n",
      p.uncertainty, p.information);
  for (std::size_t i = 0; i < std::min(p.following.size(), kNextLines); ++i)
    text += fmt::format("  {:<60} {:.2f} bit, tells {} more\n", p.following[i].name,
                        p.following[i].information, counted(p.following[i].told, "pair"));
  return text;
}

std::string seen_sentence(const Preflight& p) {
  const auto count = [&](auto&& is) {
    return std::count_if(p.effects.begin(), p.effects.end(), is);
  };
  const auto within = count([](const PlannedEffect& e) { return std::isfinite(e.least); });
  const auto named = count([](const PlannedEffect& e) { return e.named; });
  const auto hidden = count([](const PlannedEffect& e) { return !e.structural; });
  std::string text = fmt::format(
      "{} of {} effects would be named at some size within their bounds, {} as large as stated",
      within, p.effects.size(), named);
  if (hidden > 0)
    text += fmt::format("; {} nothing that is recorded",
                        hidden == 1 ? "one changes" : fmt::format("{} change", hidden));
  return text + ".";
}

std::string told_sentence(const Preflight& p) {
  const std::size_t not_told = pairs_not_told(p).size();
  if (p.pairs.empty()) return "No effect would be named as large as stated, so none is told apart.";
  if (not_told == 0)
    return fmt::format("All {} pairs of these with another effect could be told apart.",
                       p.pairs.size());
  const auto largest =
      std::max_element(p.sets.begin(), p.sets.end(),
                       [](const auto& a, const auto& b) { return a.size() < b.size(); });
  std::vector<std::string> first(
      largest->begin(), largest->begin() + std::min<std::ptrdiff_t>(4, std::ssize(*largest)));
  return fmt::format(
      "{} of {} pairs of these with another effect could not be told apart, most of "
      "them among {}{}.",
      not_told, p.pairs.size(), fmt::join(first, ", "),
      largest->size() > first.size() ? ", ..." : "");
}

std::string next_sentence(const Preflight& p) {
  if (p.following.empty()) return "No other experiment was compared.";
  const FollowingExperiment& best = p.following.front();
  const auto helped = std::count_if(p.pairs.begin(), p.pairs.end(), [](const PlannedPair& pair) {
    return !pair.tellable && !pair.by.empty();
  });
  std::string text = fmt::format(
      "The best experiment to follow is {}: together {:.2f} bit of {:.2f} about which effect is at "
      "work, {:.2f} without it",
      best.name, best.information, p.uncertainty, p.information);
  if (helped > 0)
    text += fmt::format("; a sensor or motion tells {} of the pairs that can't be told", helped);
  return text + ".";
}

}  // namespace

std::vector<std::string> preflight_sentences(const Preflight& p) {
  if (!p.reasons.empty())
    return {fmt::format("Data of this experiment could not be diagnosed: {}.",
                        fmt::join(p.reasons, "; "))};
  return {seen_sentence(p), told_sentence(p), next_sentence(p)};
}

std::string preflight_text(const Preflight& p) {
  std::string text;
  for (const std::string& sentence : preflight_sentences(p)) text += sentence + "\n";
  if (!p.reasons.empty()) return text;
  text += "\n" + effects_table(p);
  if (const std::string pairs = pairs_table(p); !pairs.empty()) text += "\n" + pairs;
  if (const std::string next = following_table(p); !next.empty()) text += "\n" + next;
  for (const std::string& note : p.notes) text += fmt::format("note: {}\n", note);
  return text;
}

}  // namespace jaculus::diagnosis
