// Real datasets whose cause is known: truth files, and predictions judged by them.

#include "jaculus/evaluation/real.h"

#include <gtest/gtest.h>

#include <fstream>

#include "evaluation/scratch_folder.h"
#include "jaculus/core/error.h"

namespace jaculus::evaluation {
namespace {

constexpr const char* kTruth = R"(effects:
  - {any_of: [joint_coulomb_friction, joint_stribeck_friction], joint: elbow, parameter: torque,
     unit: N m, value: 0.12, within: 0.4}
  - {any_of: [link_mass, torque_constant], joint: elbow, value: "mass x 1.21 or torque x 0.83"}
listed: [joint_rotor_inertia]
absent: [joint_compliance]
events:
  - {trial: trial_01, joint: elbow, from: 1.0, to: 1.4, peak: -0.5}
source: a bench
)";

class KnownCauses : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) {
    const std::filesystem::path file = scratch_.path / name;
    std::ofstream(file) << text;
    return file;
  }

  ScratchFolder scratch_{"jaculus_truth_"};
};

NamedEffect effect(const std::string& name, double torque) {
  NamedEffect named;
  named.name = name;
  named.probability = 0.9;
  named.parameters["torque"] = torque;
  named.ci95["torque"] = {torque - 0.01, torque + 0.01};
  return named;
}

TEST_F(KnownCauses, AreReadWithTheirValuesEventsAndWords) {
  const KnownCause known = read_known_cause(write("a.truth.yaml", kTruth));

  ASSERT_EQ(known.effects.size(), 2U);
  EXPECT_EQ(known.effects[0].any_of.back(), "joint_stribeck_friction");
  EXPECT_DOUBLE_EQ(known.effects[0].value, 0.12);
  EXPECT_TRUE(std::isnan(known.effects[1].value));
  EXPECT_EQ(known.effects[1].remark, "mass x 1.21 or torque x 0.83");
  ASSERT_EQ(known.events.size(), 1U);
  EXPECT_DOUBLE_EQ(known.events[0].peak, -0.5);
}

TEST_F(KnownCauses, MayTakeTheirEffectsFromAnotherFileWithoutItsEvents) {
  write("a.truth.yaml", kTruth);
  const KnownCause known =
      read_known_cause(write("b.truth.yaml", "effects_as_in: a.truth.yaml\nevents: []\n"));

  EXPECT_EQ(known.effects.size(), 2U);
  EXPECT_TRUE(known.events.empty());
}

TEST_F(KnownCauses, WithUnknownKeysAreRefusedByLine) {
  try {
    (void)read_known_cause(write("a.truth.yaml", "effects: []\nevent: []\n"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("a.truth.yaml:2"), std::string::npos) << error.what();
  }
}

TEST_F(KnownCauses, StandBesideTheDatasetsFolder) {
  write("a.truth.yaml", kTruth);
  std::filesystem::create_directories(scratch_.path / "a");
  std::filesystem::create_directories(scratch_.path / "b");

  EXPECT_TRUE(known_cause_of(scratch_.path / "a").has_value());
  EXPECT_TRUE(known_cause_of(scratch_.path / "a/").has_value());
  EXPECT_FALSE(known_cause_of(scratch_.path / "b").has_value());
}

TEST_F(KnownCauses, JudgeNamesValuesAbsentAndExtraOnes) {
  const KnownCause known = read_known_cause(write("a.truth.yaml", kTruth));
  Prediction prediction;
  prediction.verdict = diagnosis::Verdict::several;
  prediction.effects = {effect("joint_stribeck_friction", 0.15), effect("joint_compliance", 1.0),
                        effect("joint_rotor_inertia", 1.0), effect("wind", 1.0)};

  const RealScore score = score_real("set", known, prediction);

  EXPECT_EQ(score.effects[0].named_as, "joint_stribeck_friction");
  EXPECT_TRUE(score.effects[0].within);
  EXPECT_TRUE(score.effects[1].named_as.empty());
  EXPECT_EQ(score.absent_named, std::vector<std::string>{"joint_compliance"});
  EXPECT_EQ(score.extra, std::vector<std::string>{"wind"});

  prediction.effects[0] = effect("joint_stribeck_friction", 0.2);
  EXPECT_FALSE(score_real("set", known, prediction).effects[0].within);

  prediction.effects[0].joints = {"shoulder"};
  EXPECT_TRUE(score_real("set", known, prediction).effects[0].named_as.empty())
      << "friction at another joint is not the known one";
}

TEST_F(KnownCauses, JudgeEventsByTrialJointTimeSignAndPeak) {
  const KnownCause known = read_known_cause(write("a.truth.yaml", kTruth));
  Prediction prediction;
  prediction.events = {{"trial_01", "elbow", 1.02, 1.45, -0.6}};
  EXPECT_EQ(score_real("set", known, prediction).events_found, 1);

  for (const SaidEvent& other : {SaidEvent{"trial_02", "elbow", 1.0, 1.4, -0.5},
                                 SaidEvent{"trial_01", "shoulder", 1.0, 1.4, -0.5},
                                 SaidEvent{"trial_01", "elbow", 1.2, 1.6, -0.5},
                                 SaidEvent{"trial_01", "elbow", 1.0, 1.4, 0.5},
                                 SaidEvent{"trial_01", "elbow", 1.0, 1.4, -0.8}}) {
    prediction.events = {other};
    const RealScore score = score_real("set", known, prediction);
    EXPECT_EQ(score.events_found, 0);
    EXPECT_EQ(score.events_false, 1);
  }
}

}  // namespace
}  // namespace jaculus::evaluation
