// The three sentences of an answer, on values of which every one is known.

#include "jaculus/diagnosis/summary.h"

#include <gtest/gtest.h>

#include "support/input_error.h"

namespace jaculus::diagnosis {
namespace {

using test::holds;

/// Friction of 0.17 N m explains 73 %, with the link's mass 96 %.
Diagnosis friction() {
  Diagnosis d;
  d.verdict = Verdict::several;
  d.model.candidates = {0, 1};
  d.effects = {{"link_mass", "", 0.9, {{"factor", "-", 1.21, {1.1, 1.3}}}, {"torque_constant"}},
               {"dry_friction", "", 0.9, {{"torque", "N m", 0.17, {0.15, 0.2}}}, {}}};
  d.effects[0].share = EffectShare{0.3, 0.23, 0.26, {kNaN, kNaN}};
  d.effects[1].share = EffectShare{0.73, 0.66, 0.7, {kNaN, kNaN}};
  d.gap.valid = true;
  d.gap.over = "trials";
  d.gap.before = 10.0;
  d.gap.after = std::sqrt(1.0 + 0.04 * 99.0);  // 4 % of the energy is left
  d.gap.channels["joints.arm"] = {10.0,  2.0,   "",
                                  "arm", "rad", {{kInfinity, 0.5, 0.0837758, 0.0122173, 0.001}}};
  d.where.emplace();
  d.where->components = {{effects::Component::actuation, 0.9, {0.8, 1.0}, 1.0, true, {}},
                         {effects::Component::sensing, 0.01, {0.0, 0.1}, 0.1, true, {}}};
  return d;
}

TEST(Summary, LeadsWithWhatExplainsMost) {
  EXPECT_EQ(summary_of(friction()).which,
            "Dry friction (torque 0.17 N m, 0.15 to 0.2) explains 73 % of the held-out gap's "
            "energy, together with link mass (factor 1.21, 1.1 to 1.3) 96 %; these data can't tell "
            "link mass "
            "from torque constant.");
}

// Tolerances take 15 floors to 1.3, the scale these to 1.1: 0 % of the whole.
TEST(Summary, CountsWhatTolerancesLeaveWhereTheyTakeNearlyAll) {
  Diagnosis d = friction();
  d.verdict = Verdict::effect;
  d.effects = {{"sensor_scale", "", 0.9, {{"scale", "-", 0.938, {0.93, 0.946}}}, {}}};
  d.effects[0].share = EffectShare{0.002, 0.002, 0.002, {kNaN, kNaN}, 0.997};
  d.gap.before = 15.0;
  d.gap.adjusted = 1.3;
  d.gap.after = 1.1;
  EXPECT_EQ(summary_of(d).which,
            "Sensor scale (scale 0.938, 0.93 to 0.946) explains 70 % of what the builder's "
            "tolerances leave of the held-out gap, 1.3 noise floors.");

  d.effects[0].share->tolerances = 0.2;
  d.effects[0].share->alone = 0.797;
  EXPECT_EQ(summary_of(d).which,
            "Sensor scale (scale 0.938, 0.93 to 0.946) explains 80 % of the held-out gap's energy, "
            "beside the builder's tolerances (20 %).");
}

TEST(Summary, GivesTheGapInUnits) {
  EXPECT_EQ(summary_of(friction()).how_far,
            "Error falls in arm from 4.8 to 0.7 deg (rms up to 0.5 s after the start, trials that "
            "no fit saw): 96 % of the gap's energy.");
}

TEST(Summary, SaysWhetherThatIsEnough) {
  Diagnosis d = friction();
  d.tolerances["joints.arm"] = {"rad", 0.0174533};
  EXPECT_TRUE(holds(summary_of(d).how_far, "Good enough: arm (0.7 against 1 deg)."));
  d.tolerances["joints.arm"] = {"rad", 0.00174533};
  EXPECT_TRUE(holds(summary_of(d).how_far, "Not good enough: arm (0.7 against 0.1 deg)."));
}

TEST(Summary, NamesPlacesThatHoldSomeOfTheGap) {
  Diagnosis d = friction();
  EXPECT_EQ(summary_of(d).where, "The gap lies in actuation (90 % of its energy).");
  d.verdict = Verdict::partial;
  d.lacking = {{"elbow", 0.08, "N m", 3.0}, {"channel x", 2.0, "noise floors", 3.0}};
  EXPECT_TRUE(holds(summary_of(d).where, "; what remains is 0.08 N m along elbow (rms)."));
  EXPECT_TRUE(holds(summary_of(d).which, "something else, not named, is there too"));
}

TEST(Summary, SaysWhereNamesMoreLikelyDontHold) {
  Diagnosis d = friction();
  EXPECT_FALSE(holds(summary_of(d).which, "a finding"));
  d.verdict = Verdict::partial;
  d.effects[0].probability = d.effects[1].probability = 0.3;
  EXPECT_TRUE(holds(summary_of(d).which,
                    "Each of these names holds with a probability of 30 % only: candidates, not a "
                    "finding."));
}

TEST(Summary, NamesNoEffectWhereNoneIsEstablished) {
  Diagnosis d = friction();
  d.effects.clear();
  d.verdict = Verdict::unexplained;
  EXPECT_EQ(summary_of(d).which, "No effect of the catalogue is established.");
  d.verdict = Verdict::none;
  d.model.candidates.clear();
  EXPECT_TRUE(holds(summary_of(d).where, "Nowhere"));
  EXPECT_TRUE(holds(summary_of(d).how_far, "The nominal model's error is, in arm 4.8 deg"));
  d.verdict = Verdict::insufficient;
  d.reasons = {"one trial: record three or more"};
  EXPECT_EQ(summary_of(d).which, "One trial: record three or more.");
  EXPECT_TRUE(holds(summary_of(Diagnosis{}).how_far, "can't be told"));
}

TEST(Summary, SaysWhatUnknownsOfTheFilesAccountFor) {
  Diagnosis d = friction();
  d.effects.clear();
  d.verdict = Verdict::unexplained;
  d.agreement.unknowns = {{"feedforward", "factor", 0.3, {0.2, 0.4}, true},
                          {"kp_tail", "share of its stated range", 0.9, {0.8, 1.0}},
                          {"clock of fast", "ms later than its stamps", 3.0, {1.0, 5.0}}};
  d.agreement.sets = {{"slow", {{"mocap", "x", "m", 0.01, 0.002, 0.002, 0.003, 0.001}}, {}, true},
                      {"fast", {{"mocap", "x", "m", 0.02, 0.001, 0.001, 0.004, 0.001}}, {}, true}};
  EXPECT_EQ(summary_of(d).which,
            "What the files leave open (feedforward 0.3 times the first guess, 0.2 to 0.4, at its "
            "bound; kp tail 0.9 of its stated range, 0.8 to 1), common to all sets, explains of "
            "the gap's energy 99 % in x. Beside that no effect of the catalogue is established.");

  d.agreement.sets[0].channels.push_back({"mocap", "z", "m", 0.002, 0.004, 0.004, 0.004, 0.001});
  EXPECT_TRUE(holds(summary_of(d).which, "99 % in x, but makes it larger in z. Beside"));
  d.agreement.unknowns.clear();
  EXPECT_EQ(summary_of(d).which, "No effect of the catalogue is established.");
}

}  // namespace
}  // namespace jaculus::diagnosis
