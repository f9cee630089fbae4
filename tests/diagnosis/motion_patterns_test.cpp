// What is left of leaps, described by simulation: forces on the body and at feet that no list has.

#include "diagnosis/motion_patterns.h"

#include <gtest/gtest.h>

#include <fstream>

#include "diagnosis/build_problem.h"
#include "diagnosis/logged_trials.h"
#include "diagnosis/remainder/hypothesis.h"
#include "diagnosis/remainder/place_patterns.h"
#include "jaculus/effects/user_effect.h"
#include "jaculus/model/robot.h"
#include "support/temporary_folder.h"

namespace jaculus::diagnosis {
namespace {

using test::TemporaryFolder;

/// Leaps of the shipped experiment, with a user's effect where a file is given.
trajectory::Dataset leaps(const std::string& text, const std::string& effect, int seed) {
  const TemporaryFolder folder;
  simulation::Experiment played =
      simulation::read_experiment(source_folder() / "problems" / "leap_trials.yaml");
  played.trials = 4;
  played.seed = seed;
  const model::PlanarModel robot = simulation::dataset_robot(played.setup).planar;
  effects::EffectChoice choice;
  if (!text.empty()) {
    choice.files = {folder.write("effect.yaml", text).string()};
    choice.effects = {effect};
  }
  return simulate_trials(played, effects::choose_effects(choice, robot), robot).dataset;
}

/// About the robot of the files, its tolerances granted or not.
std::vector<RemainderPlace> described(const trajectory::Dataset& dataset, int tolerances) {
  DiagnoseOptions options;
  options.settings.tolerances_granted = tolerances;
  options.effects = {effects::find_effect("payload")};
  Diagnosis found;
  found.problem = build_problem({dataset}, options).problem;
  found.none.p = found.problem->hypotheses.nominal();
  return patterns_of_motion({dataset}, options, found);
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
      described(leaps(kTether, "tether:stiffness=150", 3), 0);
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
    EXPECT_TRUE(described(leaps("", "", seed), 1).empty()) << "seed " << seed;
}

TEST(PlacePatterns, AreEffectsThatEveryRobotCanHave) {
  for (const char* name : {"minitaur", "minitaur_tail", "quadruped25", "pendulum", "slider"}) {
    const model::PlanarModel robot =
        model::read_robot(model::find_robot(name, source_folder())).planar;
    const Vector ones = Vector::Ones(robot.size());
    const auto patterns =
        place_patterns(robot, {Vector::Zero(robot.size()), ones, ones}, 0.1, 0.1, 0.02);
    ASSERT_FALSE(patterns.empty()) << name;
    bool body = false, feet = false;
    for (const PlacePattern& pattern : patterns) {
      std::vector<double> scales;
      for (const PatternParameter& own : pattern.parameters) scales.push_back(own.scale);
      for (const bool free_period : {false, true})
        EXPECT_NO_THROW(
            effects::parse_user_effect(pattern_file(pattern, scales, free_period), pattern.name)
                .require(robot))
            << name << '\n'
            << pattern_file(pattern, scales, free_period);
      body = body || pattern.place == "body";
      feet = feet || pattern.place == "feet";
    }
    EXPECT_EQ(body, robot.coordinate_index("x") >= 0) << name;
    EXPECT_EQ(feet, !robot.feet.empty()) << name;
  }
}

}  // namespace
}  // namespace jaculus::diagnosis
