// Verdicts about what is left beside pushes and forces of stated forms.

#include "diagnosis/verdict/told_events.h"

#include <gtest/gtest.h>

namespace jaculus::diagnosis {
namespace {

enum : int { kFriction, kWind, kPush, kOtherPush, kCable, kWave };

/// Two effects, two pushes and two patterns as candidates.
struct Candidates {
  std::vector<effects::Effect> effects{6};
  Problem problem;

  Candidates() {
    const char* names[] = {"friction", "wind", "push@x", "push@elbow", "cable", "wave"};
    for (int c = 0; c < 6; ++c) {
      effects[c].event = c == kPush || c == kOtherPush;
      effects[c].pattern = c >= kCable;
      problem.hypotheses.candidates.push_back(
          {names[c], effects::Component::body, {}, &effects[c]});
    }
  }
};

Proposal proposed(Naming naming, std::vector<Established> effects) {
  return {naming, std::move(effects), {}, {}};
}

TEST(ToldEvents, APushThatEveryTrialHadIsBeyondTolerance) {
  const Candidates c;
  const PartedProposal told = parted(c.problem, proposed(Naming::sure, {{kPush, {}, 1.0}}));
  EXPECT_EQ(told.events.size(), 1U);
  EXPECT_TRUE(told.effects.empty());
  EXPECT_EQ(about_effects(Verdict::effect, told), Verdict::unexplained);
  EXPECT_EQ(about_effects(Verdict::partial, told), Verdict::unexplained);
  EXPECT_EQ(about_effects(Verdict::unexplained, told), Verdict::unexplained);
}

TEST(ToldEvents, AnEffectBesideAPushIsPartOfTheAnswer) {
  const Candidates c;
  const PartedProposal told =
      parted(c.problem, proposed(Naming::sure, {{kPush, {}, 1.0}, {kFriction, {}, 0.9}}));
  ASSERT_EQ(told.effects.size(), 1U);
  EXPECT_EQ(told.effects.front().effect, kFriction);
  EXPECT_EQ(about_effects(Verdict::several, told), Verdict::partial);
  EXPECT_EQ(about_effects(Verdict::partial, told), Verdict::partial);
}

TEST(ToldEvents, AnEffectWithRivalsBesideAPushIsAmbiguous) {
  const Candidates c;
  const PartedProposal told =
      parted(c.problem, proposed(Naming::sure, {{kPush, {}, 1.0}, {kFriction, {kWind}, 0.9}}));
  EXPECT_EQ(told.naming, Naming::rivals);
  EXPECT_EQ(about_effects(Verdict::several, told), Verdict::ambiguous);
}

TEST(ToldEvents, RivalsOfWhichAllArePushesAreAPush) {
  const Candidates c;
  const PartedProposal pushes =
      parted(c.problem, proposed(Naming::rivals, {{kPush, {kOtherPush}, 1.0}}));
  EXPECT_EQ(pushes.naming, Naming::sure);
  ASSERT_EQ(pushes.events.size(), 1U);
  EXPECT_EQ(pushes.events.front().others, std::vector<int>{kOtherPush});

  // Whether it was a push is then open.
  const PartedProposal either =
      parted(c.problem, proposed(Naming::rivals, {{kPush, {kWind}, 1.0}}));
  EXPECT_TRUE(either.events.empty());
  EXPECT_EQ(about_effects(Verdict::ambiguous, either), Verdict::ambiguous);
}

TEST(ToldEvents, RankingPutsRowsTogetherThatDifferInPushesAlone) {
  const Candidates c;
  const std::vector<Ranked> ranking = {
      {"push@x", 20.0, 0.9, 0.5, {"push@x"}, {{"push@x.peak", "N", 10.0, {9.0, 11.0}}}},
      {"friction + push@x", 19.0, 0.9, 0.2, {"friction", "push@x"}, {}},
      {"none", 0.0, 3.0, 0.2, {}, {}},
      {"unexplained", 0.0, kNaN, 0.1, {}, {}}};
  const std::vector<Ranked> about = ranked_by_effects(c.problem, ranking);
  ASSERT_EQ(about.size(), 3U);
  EXPECT_EQ(about[0].effect, "unexplained");
  EXPECT_DOUBLE_EQ(about[0].probability, 0.6);
  EXPECT_DOUBLE_EQ(about[0].held_out_error, 0.9);
  EXPECT_TRUE(about[0].parameters.empty());
  EXPECT_EQ(about[1].effect, "friction");
  EXPECT_EQ(about[2].effect, "none");
}

TEST(ToldPatterns, AloneAreNoEffectButWhatIsLeft) {
  const Candidates c;
  const PartedProposal alone = parted(c.problem, proposed(Naming::sure, {{kCable, {}, 1.0}}));
  EXPECT_TRUE(alone.effects.empty());
  EXPECT_EQ(alone.patterns.size(), 1U);
  EXPECT_EQ(about_effects(Verdict::effect, alone), Verdict::unexplained);
  // Of what form it is may be open: it is no effect all the same.
  const PartedProposal either =
      parted(c.problem, proposed(Naming::rivals, {{kCable, {kWave}, 1.0}}));
  EXPECT_EQ(about_effects(Verdict::ambiguous, either), Verdict::unexplained);
  const PartedProposal effect =
      parted(c.problem, proposed(Naming::rivals, {{kCable, {kWind}, 1.0}}));
  EXPECT_EQ(about_effects(Verdict::ambiguous, effect), Verdict::ambiguous);
  ASSERT_EQ(effect.effects.size(), 1U);
  EXPECT_EQ(effect.effects.front().effect, kWind);
  EXPECT_TRUE(effect.effects.front().others.empty());
  const PartedProposal push = parted(c.problem, proposed(Naming::rivals, {{kCable, {kPush}, 1.0}}));
  EXPECT_EQ(push.patterns.size(), 1U);
  EXPECT_TRUE(push.effects.empty());
}

TEST(ToldPatterns, BesideAnEffectMakeItPartOfTheAnswer) {
  const Candidates c;
  const PartedProposal told =
      parted(c.problem, proposed(Naming::sure, {{kCable, {}, 1.0}, {kFriction, {}, 0.9}}));
  ASSERT_EQ(told.effects.size(), 1U);
  EXPECT_EQ(about_effects(Verdict::several, told), Verdict::partial);
  EXPECT_EQ(about_effects(Verdict::none, told), Verdict::none);
}

TEST(ToldPatterns, RankingCountsOneAloneAsUnexplained) {
  const Candidates c;
  const std::vector<Ranked> ranking = {
      {"cable", 20.0, 0.9, 0.6, {"cable"}, {}},
      {"cable + friction", 19.0, 0.9, 0.2, {"cable", "friction"}, {}},
      {"friction", 9.0, 2.0, 0.1, {"friction"}, {}},
      {"unexplained", 0.0, kNaN, 0.1, {}, {}}};
  const std::vector<Ranked> about = ranked_by_effects(c.problem, ranking);
  ASSERT_EQ(about.size(), 2U);
  EXPECT_EQ(about[0].effect, "unexplained");
  EXPECT_DOUBLE_EQ(about[0].probability, 0.7);
  EXPECT_EQ(about[1].effect, "friction");
  EXPECT_DOUBLE_EQ(about[1].probability, 0.3);
}

}  // namespace
}  // namespace jaculus::diagnosis
