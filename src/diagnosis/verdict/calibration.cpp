#include "diagnosis/verdict/calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace jaculus::diagnosis {
namespace {

constexpr const char* kCounted =
    "four blinded batches of cluttered cases: by e4856cb, 1127cf9 and 255c93e (40 each), by "
    "38cb657 "
    "(60)";

bool names(const std::vector<std::string>& members, const std::string& effect) {
  return std::find(members.begin(), members.end(), effect) != members.end();
}

/// Whether a row of the ranking is what the verdict reports.
bool is_reported(const Ranked& row, Verdict verdict, const std::vector<FoundEffect>& effects) {
  if (row.members.empty()) return row.effect == to_text(verdict);
  return std::all_of(row.members.begin(), row.members.end(), [&](const std::string& member) {
    return std::any_of(effects.begin(), effects.end(),
                       [&](const FoundEffect& e) { return e.name == member; });
  });
}

/// Weights of the rows that are not reported, before they are brought to the sum that is left.
std::vector<double> rest_weights(const std::vector<Ranked>& ranking,
                                 const std::vector<bool>& reported,
                                 const Reliability& reliability) {
  std::vector<double> weights(ranking.size(), 0.0);
  std::vector<int> others;
  for (int i = 0; i < count_of(ranking); ++i) {
    if (reported[i]) continue;
    if (ranking[i].effect == to_text(Verdict::unexplained))
      weights[i] = reliability.unexplained;
    else if (ranking[i].effect == to_text(Verdict::none))
      weights[i] = reliability.none;
    else
      others.push_back(i);
  }

  std::stable_sort(others.begin(), others.end(),
                   [&](int a, int b) { return ranking[a].log_evidence > ranking[b].log_evidence; });
  double share = 0.5;
  for (const int i : others) {
    weights[i] = share * reliability.others;
    share *= 0.5;
  }
  return weights;
}

/// What is stated for the reported rows, of which the posterior claims `claimed`. That of none
/// knows which effects are too small to be told; held-out data may say more, but not less.
double stated_for(const Reliability& counted, double claimed) {
  return counted.by_posterior() ? std::max(claimed, counted.stated()) : counted.stated();
}

/// Probability of the reported rows that an effect is part of.
double share_of(const std::vector<Ranked>& ranking, const std::vector<bool>& reported,
                const std::string& effect) {
  double share = 0.0;
  for (std::size_t i = 0; i < ranking.size(); ++i)
    if (reported[i] && names(ranking[i].members, effect)) share += ranking[i].probability;
  return share;
}

}  // namespace

const std::vector<Reliability>& reliabilities() {
  static const std::vector<Reliability> table = {
      {Verdict::effect, {.doubted = true}, 11, 15, 0.4, 0.1, 0.5, kCounted},
      {Verdict::effect, {}, 34, 36, 0.4, 0.1, 0.5, kCounted},
      {Verdict::several, {}, 6, 13, 0.5, 0.1, 0.4, kCounted, 24, 30},
      {Verdict::partial, {}, 2, 6, 0.5, 0.1, 0.4, kCounted, 2, 8},
      {Verdict::ambiguous, {}, 11, 14, 0.5, 0.1, 0.4, kCounted},
      {Verdict::none, {}, 38, 62, 0.4, 0.0, 0.6, kCounted},
      // Of those with a push, counted while the verdict beside it was `none`.
      {Verdict::unexplained, {.event = true}, 11, 15, 0.0, 0.4, 0.6, kCounted},
      {Verdict::unexplained, {}, 6, 16, 0.0, 0.2, 0.8, kCounted}};
  return table;
}

std::vector<std::string> doubts(Verdict verdict, const HeldOut& gap,
                                const std::vector<FoundEffect>& effects,
                                const std::vector<Ranked>& ranking, const Settings& settings) {
  std::vector<std::string> found;
  if (verdict != Verdict::effect || effects.empty()) return found;
  if (!gap.valid) found.emplace_back("its prediction of held-out data could not be judged");
  if (gap.valid && gap.before < settings.plain_gap)
    found.push_back(fmt::format("the gap is small: {:.2g} noise floors", gap.before));
  if (gap.valid && gap.after > settings.plain_gap)
    found.push_back(fmt::format("{:.2g} noise floors of the gap are left", gap.after));

  for (const Ranked& row : ranking) {
    const bool other = !row.members.empty() && !names(row.members, effects.front().name);
    if (other && row.held_out_error < settings.rival_nearly_as_well * gap.after)
      found.push_back(fmt::format("{} predicts held-out data nearly as well", row.effect));
  }
  return found;
}

Calibrated calibrate(Verdict verdict, const Circumstances& beside, std::vector<FoundEffect> effects,
                     std::vector<Ranked> ranking) {
  const std::vector<Reliability>& table = reliabilities();
  const auto counted = std::find_if(table.begin(), table.end(), [&](const Reliability& r) {
    return r.verdict == verdict && (!r.beside.event || beside.event) &&
           (!r.beside.doubted || beside.doubted);
  });
  std::vector<bool> reported;
  double claimed = 0.0;
  int rows = 0;
  for (const Ranked& row : ranking) {
    reported.push_back(is_reported(row, verdict, effects));
    if (!reported.back()) continue;
    claimed += row.probability;
    ++rows;
  }
  if (counted == table.end() || rows == 0) return {std::move(effects), std::move(ranking)};

  const std::vector<double> rest = rest_weights(ranking, reported, *counted);
  const double all_rest = std::accumulate(rest.begin(), rest.end(), 0.0);
  const double right = all_rest > 0.0 ? stated_for(*counted, claimed) : 1.0;
  for (std::size_t i = 0; i < ranking.size(); ++i) {
    double& p = ranking[i].probability;
    // A verdict that held-out data decided against the posterior has no part of it to share by.
    const double part = claimed > 0.0 ? p / claimed : 1.0 / rows;
    p = reported[i] ? right * part : (1.0 - right) * rest[i] / all_rest;
  }
  for (FoundEffect& effect : effects)
    effect.probability =
        counted->named > 0 ? counted->stated_of_each() : share_of(ranking, reported, effect.name);

  std::stable_sort(ranking.begin(), ranking.end(),
                   [](const Ranked& a, const Ranked& b) { return a.probability > b.probability; });
  return {std::move(effects), std::move(ranking)};
}

}  // namespace jaculus::diagnosis
