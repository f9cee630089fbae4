// What is left of leaps, described by simulation: forces on the body and at feet that no list has.

#include "diagnosis/motion_patterns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "diagnosis/build_problem.h"
#include "diagnosis/effects_by_name.h"
#include "diagnosis/logged_trials.h"
#include "diagnosis/remainder/hypothesis.h"
#include "diagnosis/remainder/pattern_file.h"
#include "diagnosis/remainder/place_patterns.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/diagnosis/summary.h"
#include "jaculus/effects/user_effect.h"
#include "jaculus/model/robot.h"
#include "support/temporary_folder.h"

namespace jaculus::diagnosis {
namespace {

using test::TemporaryFolder;

/// Trials of a shipped experiment with an effect, a user's where a file is given.
trajectory::Dataset trials_of(const std::string& experiment, const std::string& text,
                              const std::vector<std::string>& effects, int seed) {
  const TemporaryFolder folder;
  simulation::Experiment played =
      simulation::read_experiment(source_folder() / "problems" / experiment);
  played.trials = 4;
  played.seed = seed;
  const model::PlanarModel robot = simulation::dataset_robot(played.setup).planar;
  effects::EffectChoice choice;
  if (!text.empty()) choice.files = {folder.write("effect.yaml", text).string()};
  choice.effects = effects;
  return simulate_trials(played, effects::choose_effects(choice, robot), robot).dataset;
}

trajectory::Dataset leaps(const std::string& text, const std::vector<std::string>& effects,
                          int seed) {
  return trials_of("leap_trials.yaml", text, effects, seed);
}

/// About the robot of the files, its tolerances granted or not.
std::vector<RemainderPlace> described(const trajectory::Dataset& dataset, int tolerances) {
  DiagnoseOptions options;
  options.settings.tolerances_granted = tolerances;
  options.effects = {effects::find_effect("payload")};
  Diagnosis found;
  found.problem = build_problem({dataset}, options).problem;
  found.none.p = found.problem->hypotheses.nominal();
  return patterns_of_motion(found);
}

constexpr const char* kTether =
    "format: jaculus-effect/1\nname: tether\ncaption: a cable behind the robot\n"
    "at: {body: base}\nparameters:\n"
    "  stiffness: {unit: N/m, nominal: 0, bounds: [0, 1000], scale: 50}\n"
    "constants:\n  slack: {unit: m, value: 0.03}\n"
    "values:\n  taut: {unit: m, value: \"max(0, x - slack)\"}\n"
    "force: {x: \"-stiffness*taut\", z: \"0*stiffness*taut\"}\n";

TEST(MotionPatterns, ACableFromTheWorldIsAForceOnTheBodyThatGrowsWithTheWay) {
  const std::vector<RemainderPlace> places =
      described(leaps(kTether, {"tether:stiffness=150"}, 3), 0);
  ASSERT_FALSE(places.empty());
  EXPECT_EQ(places.front().place, "body");
  EXPECT_EQ(places.front().joint, "x");
  EXPECT_TRUE(places.front().by_simulation);
  const Dependence& led = places.front().follows.front();
  EXPECT_EQ(led.regressor, Regressor::position) << to_text(led.regressor);
  EXPECT_GT(led.share, 0.5);

  // The hypothesis is a file that this robot can have.
  Remainder remainder;
  remainder.places = places;
  const model::PlanarModel robot =
      model::read_robot(model::find_robot("minitaur_tail", source_folder())).planar;
  const std::vector<std::string> files = hypotheses_of(remainder, robot);
  ASSERT_FALSE(files.empty());
  EXPECT_NO_THROW(effects::parse_user_effect(files.front(), "hypothesis").require(robot));
}

TEST(MotionPatterns, NothingIsSaidOfLeapsThatTheModelMade) {
  for (const int seed : {1, 2, 3})
    EXPECT_TRUE(described(leaps("", {}, seed), 1).empty()) << "seed " << seed;
}

/// Among a few effects.
Diagnosis diagnosed_leaps(const trajectory::Dataset& dataset) {
  const DiagnoseOptions options =
      test::among({"leg_coulomb_friction", "wind", "payload", "controller_gains"});
  return diagnose({dataset}, options);
}

// A cable is no effect of the catalogue, yet some of these explain a part of what it does.
TEST(PatternSearch, ACableIsNoEffectOfTheCatalogue) {
  const Diagnosis found = diagnosed_leaps(leaps(kTether, {"tether:stiffness=500"}, 3));
  EXPECT_EQ(found.verdict, Verdict::unexplained) << to_text(found.verdict);
  EXPECT_TRUE(found.effects.empty());
  ASSERT_FALSE(found.remainder.places.empty());
  const RemainderPlace& place = found.remainder.places.front();
  EXPECT_EQ(place.place, "body");
  EXPECT_EQ(place.joint, "x");
  ASSERT_FALSE(place.follows.empty());
  EXPECT_EQ(place.follows.front().regressor, Regressor::position);
  EXPECT_LT(place.follows.front().coefficients.front(), 0.0);  // pulls back
  EXPECT_GT(place.follows.front().share, 0.8);
  for (const Ranked& row : found.ranking) EXPECT_EQ(row.effect.find("found_"), std::string::npos);
  EXPECT_NE(summary_of(found).which.find("the body, along x"), std::string::npos);
}

/// What a dead band takes from each command, of a share of the largest torque.
constexpr const char* kDeadBand =
    "format: jaculus-effect/1\nname: dead_band\ncaption: drivers that do nothing at small torques\n"
    "at: {group: other}\nparameters:\n"
    "  level: {unit: \"-\", nominal: 0, bounds: [0, 1], scale: 0.01}\n"
    "torque: \"-max(-level*tau_limit, min(level*tau_limit, tau))\"\n";

// What all drivers of an arm do is one force at every joint: 0.003 of their limit of 12 N m, where
// commands are 0.1 to 0.35 N m.
TEST(PatternSearch, ADeadBandOfAllDriversIsOneForce) {
  const Diagnosis found =
      diagnose({trials_of("double_pendulum_trials.yaml", kDeadBand, {"dead_band:level=0.003"}, 3)},
               test::among({"joint_viscous_friction", "link_mass", "torque_constant"}));
  EXPECT_EQ(found.verdict, Verdict::unexplained) << to_text(found.verdict);
  ASSERT_FALSE(found.remainder.places.empty());
  const RemainderPlace& place = found.remainder.places.front();
  EXPECT_EQ(place.joint, "every_joint");
  ASSERT_FALSE(place.follows.empty());
  EXPECT_EQ(place.follows.front().regressor, Regressor::motor_torque);
  EXPECT_NE(place.follows.front().form.find("a dead band"), std::string::npos);
  EXPECT_NEAR(place.follows.front().coefficients.front(), 1.0, 0.2);  // all of it
}

// Two of them leave nothing more, and forces of other forms are tried for that.
TEST(PatternSearch, EffectsOfTheCatalogueStayThese) {
  const Diagnosis found = diagnosed_leaps(
      leaps("", {"leg_coulomb_friction:torque=0.3", "controller_gains:proportional_scale=0.6"}, 3));
  EXPECT_EQ(found.verdict, Verdict::several) << to_text(found.verdict);
  std::vector<std::string> names;
  for (const FoundEffect& effect : found.effects) names.push_back(effect.name);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"controller_gains", "leg_coulomb_friction"}));
  EXPECT_TRUE(found.remainder.places.empty());
}

TEST(PlacePatterns, AreEffectsThatEveryRobotCanHave) {
  for (const char* name : {"minitaur", "minitaur_tail", "quadruped25", "pendulum", "slider"}) {
    const model::PlanarModel robot =
        model::read_robot(model::find_robot(name, source_folder())).planar;
    const auto moving = [](Eigen::Index n) {
      return UsualMotions{Vector::Zero(n), Vector::Ones(n), Vector::Ones(n)};
    };
    const UsualMotion usual{moving(robot.size()), moving(std::ssize(robot.motors))};
    const auto patterns = place_patterns(robot, usual, {0.1, 0.1, 0.02});
    ASSERT_FALSE(patterns.empty()) << name;
    bool body = false, feet = false, waves = false;
    for (const PlacePattern& pattern : patterns) {
      // Found twenty times as large as expected, too: a loss is all there is at most.
      for (const double found : {1.0, 20.0}) {
        std::vector<double> scales;
        for (const PatternParameter& own : pattern.parameters) scales.push_back(found * own.scale);
        for (const bool free_shape : {false, true})
          EXPECT_NO_THROW(
              effects::parse_user_effect(pattern_file(pattern, scales, free_shape), pattern.name)
                  .require(robot))
              << name << '\n'
              << pattern_file(pattern, scales, free_shape);
      }
      body = body || pattern.place == "body";
      feet = feet || pattern.place == "feet";
      waves = waves || (pattern.at == robot.motors.front().joint && pattern.shape &&
                        pattern.shape->name == "period");
    }
    EXPECT_EQ(body, robot.coordinate_index("x") >= 0) << name;
    EXPECT_EQ(feet, !robot.feet.empty()) << name;
    EXPECT_TRUE(waves) << name;
  }
}

}  // namespace
}  // namespace jaculus::diagnosis
