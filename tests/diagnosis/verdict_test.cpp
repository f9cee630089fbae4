// The table of rules, rule by rule; probabilities as stated.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>

#include "diagnosis/verdict/calibration.h"
#include "diagnosis/verdict/rules.h"
#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "support/temporary_folder.h"

namespace jaculus::diagnosis {
namespace {

/// One effect that takes a plain gap.
VerdictEvidence plain() {
  VerdictEvidence e;
  e.naming = Naming::sure;
  e.effects = 1;
  e.gap.valid = true;
  e.gap.before = e.gap.adjusted = 10.0;
  e.gap.after = 1.1;
  e.gap.log_gain = 100.0;
  e.gap.shrink = 0.99;
  return e;
}

std::string rule_of(const VerdictEvidence& e) { return decide(e, {}).name; }

TEST(VerdictRules, OneTrialStatesNothingWhateverItFits) {
  VerdictEvidence e = plain();
  e.one_trial = true;
  EXPECT_EQ(decide(e, {}).verdict, Verdict::insufficient);
  EXPECT_EQ(rule_of(e), "one trial");
}

TEST(VerdictRules, NoneWhereItIsProbable) {
  VerdictEvidence e = plain();
  e.naming = Naming::nothing;
  e.none = 0.9;
  e.gap.after = e.gap.before;
  EXPECT_EQ(rule_of(e), "none probable");
  EXPECT_EQ(decide(e, {}).verdict, Verdict::none);
}

TEST(VerdictRules, NoneWhereASmallGapIsHardlyPredictedBetter) {
  VerdictEvidence e = plain();
  e.gap.before = e.gap.adjusted = 1.2;
  e.gap.after = 1.17;  // 2.5 % of a small gap
  e.gap.shrink.reset();
  EXPECT_EQ(rule_of(e), "small gap");
  e.naming = Naming::nothing;
  e.unexplained = 0.9;
  EXPECT_EQ(decide(e, {}).verdict, Verdict::none);
  e = plain();
  e.gap.before = e.gap.adjusted = 1.4;
  e.gap.after = 1.0;
  e.gap.log_gain = 19.0;
  EXPECT_EQ(rule_of(e), "small gap");
  e.gap.log_gain = 21.0;
  EXPECT_EQ(rule_of(e), "one effect");
}

TEST(VerdictRules, NoneWhereTheGapIsWithinTheBuildersTolerances) {
  VerdictEvidence e = plain();
  e.naming = Naming::nothing;
  e.unexplained = 0.9;
  e.gap.adjusted = 1.2;
  EXPECT_EQ(rule_of(e), "small gap");
  e.gap.adjusted = 3.0;
  EXPECT_EQ(rule_of(e), "unknown structure");
}

TEST(VerdictRules, TolerancesDontStandInForEffectsThatAreFarMoreProbable) {
  // A robot whose tolerances were fitted predicts as well, at a price that held-out data don't ask.
  for (const double adjusted : {1.2, 3.0}) {
    VerdictEvidence e = plain();
    e.gap.adjusted = adjusted;
    e.gap.after = 1.03 * adjusted;
    const std::string weak = adjusted < 1.5 ? "small gap" : "no better prediction";
    e.log_odds = 4.9;
    EXPECT_EQ(rule_of(e), weak);
    e.log_odds = 5.1;
    EXPECT_EQ(rule_of(e), "one effect");
    // What predicts worse is not stated however probable it is.
    e.gap.after = 1.2 * adjusted;
    EXPECT_EQ(rule_of(e), weak);
  }
}

TEST(VerdictRules, UnexplainedWhereStructureIsUnknown) {
  VerdictEvidence e = plain();
  e.naming = Naming::nothing;
  e.unexplained = 0.9;
  EXPECT_EQ(rule_of(e), "unknown structure");
  EXPECT_EQ(decide(e, {}).verdict, Verdict::unexplained);
}

TEST(VerdictRules, SayOfTheNearestWhatItLeaves) {
  HeldOut gap = plain().gap;
  const Settings settings;
  EXPECT_NE(nearest_text("sensor_latency", gap, settings).find("leaves 1.10 noise floors"),
            std::string::npos);
  gap.after = settings.plain_gap;
  const std::string structure = "which leaves structure beyond noise: sensor_latency";
  EXPECT_NE(nearest_text("sensor_latency", gap, settings).find(structure), std::string::npos);
  gap.after = 1.1;
  gap.valid = false;
  EXPECT_NE(nearest_text("sensor_latency", gap, settings).find(structure), std::string::npos);
}

TEST(VerdictRules, UnexplainedWhereHeldOutDataAreNotPredictedBetter) {
  VerdictEvidence e = plain();
  e.gap.before = e.gap.adjusted = 4.0;
  e.gap.after = 3.9;
  EXPECT_EQ(rule_of(e), "no better prediction");
  e = plain();
  e.gap.log_gain = 2.0;
  EXPECT_EQ(rule_of(e), "no better prediction");
}

TEST(VerdictRules, PartialWhereForcesRemainThatAreWorthStating) {
  VerdictEvidence e = plain();
  e.gap.before = e.gap.adjusted = 20.0;
  e.gap.after = 3.5;  // 3 % of the energy
  EXPECT_EQ(rule_of(e), "one effect");
  e.lacking = 0.9;
  EXPECT_EQ(rule_of(e), "more is there");
  EXPECT_EQ(decide(e, {}).verdict, Verdict::partial);
  e.gap.after = 2.5;  // more than 1 %
  EXPECT_EQ(rule_of(e), "more is there");
  e.gap.after = 2.0;  // less
  EXPECT_EQ(rule_of(e), "one effect");

  // The same of a gap that is mostly tolerances: 6 % of what they leave.
  e.gap.adjusted = 7.0;
  EXPECT_EQ(rule_of(e), "more is there");
  e.gap.after = 1.4;  // no gap by itself
  EXPECT_EQ(rule_of(e), "one effect");
  e.gap.before = e.gap.adjusted = 8.5;
  e.gap.after = 1.45;  // 1.6 %, but no plain gap
  EXPECT_EQ(rule_of(e), "one effect");
  e.gap.after = 1.5;  // 1.8 % of one
  EXPECT_EQ(rule_of(e), "more is there");
}

TEST(VerdictRules, WhatIsEstablishedIsNotClearedBecauseMoreRemains) {
  VerdictEvidence e = plain();
  e.gap.before = e.gap.adjusted = 50.0;
  e.gap.after = 30.0;  // 36 % of the energy
  e.lacking = 1.0;
  EXPECT_TRUE(names_effects(decide(e, {}).verdict));
}

TEST(VerdictRules, UnexplainedWhereMoreIsLeftThanExplained) {
  VerdictEvidence e = plain();
  e.gap.before = e.gap.adjusted = 50.0;
  e.gap.after = 40.0;  // 64 % of the energy
  e.lacking = 1.0;
  EXPECT_EQ(rule_of(e), "less than is left");
  EXPECT_EQ(decide(e, {}).verdict, Verdict::unexplained);

  // What tolerances explain before is not the effect's.
  e.gap.before = 500.0;
  EXPECT_EQ(rule_of(e), "less than is left");
}

TEST(VerdictRules, GapsThatCouldNotBeJudgedRefuseNothing) {
  VerdictEvidence e = plain();
  e.gap = {};
  EXPECT_EQ(rule_of(e), "one effect");
}

TEST(VerdictRules, NamesOneSeveralOrRivals) {
  VerdictEvidence e = plain();
  EXPECT_EQ(decide(e, {}).verdict, Verdict::effect);
  e.effects = 2;
  EXPECT_EQ(decide(e, {}).verdict, Verdict::several);
  e.naming = Naming::rivals;
  EXPECT_EQ(decide(e, {}).verdict, Verdict::ambiguous);
}

TEST(VerdictRules, HaveNamesOfTheirOwnAndSettingsMoveThem) {
  std::set<std::string> names;
  for (const VerdictRule& rule : verdict_rules()) names.insert(rule.name);
  EXPECT_EQ(names.size(), verdict_rules().size());

  VerdictEvidence e = plain();
  e.gap.after = 2.5;  // 5 % of the energy
  e.lacking = 0.9;
  EXPECT_EQ(rule_of(e), "more is there");
  Settings mild;
  mild.plain_remainder_share = 0.1;
  EXPECT_STREQ(decide(e, mild).name, "one effect");
}

TEST(Verdict, ReadsBackFromItsText) {
  for (const Verdict v : {Verdict::insufficient, Verdict::none, Verdict::unexplained,
                          Verdict::effect, Verdict::several, Verdict::partial, Verdict::ambiguous})
    EXPECT_EQ(verdict_from(to_text(v), "test"), v);
  EXPECT_THROW(verdict_from("maybe", "test"), InputError);
}

/// What is to be calibrated.
struct Stated {
  std::vector<FoundEffect> effects;
  HeldOut gap;
  std::vector<Ranked> ranking;
};

Stated stated(const std::vector<std::string>& effects) {
  Stated out;
  for (const std::string& name : effects) out.effects.push_back({name, "", 1.0, {}, {}});
  out.gap.valid = true;
  out.gap.before = out.gap.adjusted = 4.0;
  out.gap.after = 1.0;
  out.ranking = {{"a + b", 50.0, 1.0, 0.9, {"a", "b"}},
                 {"a", 45.0, 1.0, 0.1, {"a"}},
                 {"c", 3.0, 2.0, 0.0, {"c"}},
                 {"unexplained", 40.0, kNaN, 0.0, {}},
                 {"none", 0.0, 4.0, 0.0, {}}};
  return out;
}

double probability(const std::vector<Ranked>& ranking, const std::string& name) {
  for (const Ranked& row : ranking)
    if (row.effect == name) return row.probability;
  return kNaN;
}

TEST(Calibration, GivesEveryVerdictItsShareAndSumsToOne) {
  for (const auto& [verdict, effects] :
       {std::pair<Verdict, std::vector<std::string>>{Verdict::effect, {"a"}},
        {Verdict::several, {"a", "b"}},
        {Verdict::none, {}},
        {Verdict::unexplained, {}}}) {
    SCOPED_TRACE(to_text(verdict));
    const Stated s = stated(effects);
    const Calibrated c = calibrate(verdict, {}, s.effects, s.ranking);
    double sum = 0.0;
    for (const Ranked& row : c.ranking) sum += row.probability;
    EXPECT_NEAR(sum, 1.0, 1e-12);
    for (std::size_t i = 1; i < c.ranking.size(); ++i)
      EXPECT_GE(c.ranking[i - 1].probability, c.ranking[i].probability);
    // nothing is impossible
    for (const Ranked& row : c.ranking) EXPECT_GT(row.probability, 0.0) << row.effect;
    for (const FoundEffect& e : c.effects) {
      EXPECT_LT(e.probability, 1.0);
      if (verdict == Verdict::effect) {
        EXPECT_NEAR(e.probability, probability(c.ranking, "a"), 1e-12);
      }
    }
  }
}

TEST(Calibration, SaysWhatSpeaksAgainstAnEffect) {
  const Stated clear = stated({"a"});
  Stated rivalled = clear, small = clear, left = clear, unjudged = clear;
  unjudged.gap.valid = false;
  rivalled.ranking[2].held_out_error = 1.05;  // c leaves hardly more
  small.gap.before = small.gap.adjusted = 1.4;
  left.gap.after = 1.8;
  EXPECT_TRUE(doubts(Verdict::effect, clear.gap, clear.effects, clear.ranking, {}).empty());

  for (const Stated* s : {&rivalled, &small, &left, &unjudged}) {
    EXPECT_EQ(doubts(Verdict::effect, s->gap, s->effects, s->ranking, {}).size(), 1u);
  }
  const auto said = doubts(Verdict::effect, rivalled.gap, rivalled.effects, rivalled.ranking, {});
  EXPECT_NE(said.front().find("c predicts"), std::string::npos) << said.front();
}

TEST(Calibration, IsLessSureOfAnEffectThatSomethingSpeaksAgainst) {
  const Stated s = stated({"a"});
  const auto sure_of = [&](bool doubted) {
    return calibrate(Verdict::effect, {.doubted = doubted}, s.effects, s.ranking)
        .effects[0]
        .probability;
  };
  EXPECT_GT(sure_of(false), 0.9);
  EXPECT_LT(sure_of(true), 0.8);
}

TEST(Calibration, LetsAVerdictOfHeldOutDataOverruleThePosterior) {
  const Stated s = stated({});
  const Calibrated c = calibrate(Verdict::none, {}, s.effects, s.ranking);
  EXPECT_EQ(c.ranking.front().effect, "none");
  EXPECT_GT(probability(c.ranking, "none"), probability(c.ranking, "a + b"));
  EXPECT_GT(probability(c.ranking, "a + b"), probability(c.ranking, "a"));
  EXPECT_GT(probability(c.ranking, "a"), probability(c.ranking, "c"));
}

TEST(Calibration, TakesThePosteriorsWordWhereItIsSurerOfNone) {
  Stated s = stated({});
  for (Ranked& row : s.ranking) row.probability = row.effect == "none" ? 0.9 : 0.025;
  EXPECT_NEAR(probability(calibrate(Verdict::none, {}, s.effects, s.ranking).ranking, "none"), 0.9,
              1e-12);
}

TEST(Calibration, IsSurerOfNoEffectWhereAPushIsTold) {
  const Stated s = stated({});
  const auto unexplained = [&](bool beside_event) {
    return probability(
        calibrate(Verdict::unexplained, {.event = beside_event}, s.effects, s.ranking).ranking,
        "unexplained");
  };
  EXPECT_GT(unexplained(true), unexplained(false));
}

TEST(Calibration, StatesAnEffectBesideOthersByHowOftenSuchEffectsWereRight) {
  const Stated s = stated({"a", "b"});
  const Calibrated c = calibrate(Verdict::several, {}, s.effects, s.ranking);
  ASSERT_EQ(c.effects.size(), 2u);
  EXPECT_EQ(c.effects[0].probability, c.effects[1].probability);
  EXPECT_GT(c.effects[0].probability, probability(c.ranking, "a + b"));
  EXPECT_LT(c.effects[0].probability, 0.8);
}

TEST(Calibration, LeavesWhatCouldNotBeJudged) {
  const Stated s = stated({});
  EXPECT_EQ(
      probability(calibrate(Verdict::insufficient, {}, s.effects, s.ranking).ranking, "a + b"),
      0.9);
}

TEST(Calibration, StatesNoMoreThanTheUpperEndOfWhatWasCounted) {
  for (const Reliability& r : reliabilities()) {
    const double n = r.cases, p = r.right / n, z = 1.96;
    const double centre = (p + z * z / (2 * n)) / (1 + z * z / n);
    const double half = z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
    EXPECT_LE(r.stated(), centre + half + 1e-9) << to_text(r.verdict);
    EXPECT_GE(r.stated(), centre - half - 1e-9) << to_text(r.verdict);
    EXPECT_NEAR(r.unexplained + r.none + r.others, 1.0, 1e-12) << to_text(r.verdict);
  }
}

TEST(Calibration, IsThatOfTheDocs) {
  // "| effect | 34 of 36 | 0.92 |", with the same of each effect behind a comma.
  const std::string docs = test::bytes_of(source_folder() / "docs" / "diagnosis.md");
  for (const Reliability& r : reliabilities()) {
    const bool each = r.named > 0;
    EXPECT_NE(docs.find(fmt::format("{} of {}{} | {}{:.2f}{} |", r.right, r.cases,
                                    each ? fmt::format(", {} of {}", r.named_right, r.named) : "",
                                    r.by_posterior() ? "the posterior, or " : "", r.stated(),
                                    each ? fmt::format(", {:.2f}", r.stated_of_each()) : "")),
              std::string::npos)
        << to_text(r.verdict) << " " << r.stated();
  }
}

TEST(Calibration, LooksAtWhatIsSpecialFirst) {
  const std::vector<Reliability>& table = reliabilities();
  for (auto row = table.begin(); row != table.end(); ++row)
    for (auto before = table.begin(); before != row; ++before)
      EXPECT_FALSE(before->verdict == row->verdict && !before->beside.event &&
                   !before->beside.doubted)
          << to_text(row->verdict) << " is never reached";
}

}  // namespace
}  // namespace jaculus::diagnosis
