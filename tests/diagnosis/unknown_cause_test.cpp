// From a cause that no list has to a hypothesis that is judged: simulated, described, written,
// diagnosed again.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>

#include "diagnosis/build_problem.h"
#include "diagnosis/describe_remainder.h"
#include "diagnosis/logged_trials.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/diagnosis/diagnosis_json.h"
#include "jaculus/diagnosis/summary.h"
#include "jaculus/effects/user_effect.h"
#include "support/temporary_folder.h"

namespace jaculus::diagnosis {
namespace {

namespace fs = std::filesystem;
using test::logged;
using test::TemporaryFolder;

constexpr double kPeriod = 0.35;  // [rad]

/// A file of an effect that no catalogue has: torque that repeats with a joint's angle.
std::string cogging_file(const fs::path& folder, const std::string& joint) {
  const fs::path file = folder / "cogging.yaml";
  std::ofstream(file) << "format: jaculus-effect/1\nname: cogging\ncaption: cogging\nat: {joint: "
                      << joint
                      << "}\nparameters:\n"
                         "  size: {unit: N m, nominal: 0, bounds: [-1, 1], scale: 0.1}\n"
                         "  period: {unit: rad, nominal: 0.35, bounds: [0.2, 0.6], scale: 0.02}\n"
                         "torque: \"size*sin(2*pi*q/period)\"\n";
  return file.string();
}

/// A diagnosis by two effects of the library, and those of files.
Diagnosis diagnosed(const trajectory::Dataset& dataset, const std::vector<std::string>& files) {
  DiagnoseOptions options;
  options.settings.largest_model = 1;
  options.catalogue =
      std::make_shared<const effects::Catalogue>(effects::catalogue_for(files, {dataset}));
  for (const effects::Effect& effect : *options.catalogue)
    if (effect.name == "joint_coulomb_friction" || effect.name == "joint_viscous_friction" ||
        !effect.file.empty())
      options.effects.push_back(&effect);
  return diagnose({dataset}, options);
}

TEST(UnknownCause, CoggingIsDescribedWrittenDownAndThenNamed) {
  const TemporaryFolder folder;
  const trajectory::Dataset dataset =
      logged("pendulum_trials.yaml", {cogging_file(folder.path(), "pendulum")},
             {"cogging:size=0.2"}, 4, 3);

  const Diagnosis described = diagnosed(dataset, {});
  EXPECT_EQ(described.verdict, Verdict::unexplained) << to_text(described.verdict);
  ASSERT_EQ(described.remainder.places.size(), 1U);
  const RemainderPlace& place = described.remainder.places.front();
  ASSERT_FALSE(place.follows.empty());
  // Tolerances of a model that lacks the cogging are a little off; that may be said as well.
  for (std::size_t k = 1; k < place.follows.size(); ++k)
    EXPECT_LT(place.follows[k].share, 0.1) << remainder_sentences(described).front();
  EXPECT_EQ(place.follows[0].regressor, Regressor::periodic);
  EXPECT_NEAR(place.follows[0].period, kPeriod, 0.05 * kPeriod);
  EXPECT_GT(place.follows[0].share, 0.5);
  ASSERT_EQ(remainder_sentences(described).size(), 1U);
  EXPECT_NE(remainder_sentences(described)[0].find("repeats with"), std::string::npos);

  write_diagnosis(described, folder.path() / "described");
  const fs::path hypothesis = folder.path() / "described" / "hypothesis.yaml";
  ASSERT_TRUE(fs::is_regular_file(hypothesis));
  const Diagnosis named = diagnosed(dataset, {hypothesis.string()});
  EXPECT_EQ(named.verdict, Verdict::effect) << to_text(named.verdict);
  ASSERT_EQ(named.effects.size(), 1U);
  EXPECT_EQ(named.effects[0].name, "found_pendulum_periodic");
  EXPECT_NEAR(named.effects[0].parameters[2].value, kPeriod, 0.01 * kPeriod);
  EXPECT_LT(named.gap.after, 1.2);
  EXPECT_TRUE(named.remainder.places.front().follows.empty());
}

TEST(UnknownCause, IsDescribedAtTheJointWhereItActs) {
  const TemporaryFolder folder;
  const Diagnosis described =
      diagnosed(logged("double_pendulum_trials.yaml", {cogging_file(folder.path(), "elbow")},
                       {"cogging:size=0.05"}, 4, 3),
                {});
  ASSERT_EQ(described.remainder.places.size(), 2U);
  for (const RemainderPlace& place : described.remainder.places) {
    const bool own = place.joint == "elbow";
    ASSERT_EQ(place.follows.size(), own ? 1U : 0U) << place.joint;
    if (!own) continue;
    EXPECT_EQ(place.follows[0].regressor, Regressor::periodic);
    EXPECT_NEAR(place.follows[0].period, kPeriod, 0.05 * kPeriod);
  }
}

/// What is left of data that the model as its files state it made.
TEST(UnknownCause, NothingIsDescribedWhereNothingIsLeftInNineteenOfTwentyDraws) {
  int described = 0;
  std::string told;
  for (int seed = 1; seed <= 20; ++seed) {
    const trajectory::Dataset dataset = logged("pendulum_trials.yaml", {}, {}, 3, seed);
    DiagnoseOptions options;
    options.effects = {effects::find_effect("joint_coulomb_friction")};
    Diagnosis found;
    found.problem = build_problem({dataset}, options).problem;
    found.none.p = found.problem->hypotheses.nominal();
    describe_remainder({dataset}, options, found);
    ASSERT_EQ(found.remainder.places.size(), 1U);
    if (found.remainder.places.front().follows.empty()) continue;
    ++described;
    told += fmt::format("seed {}: {}\n", seed, remainder_sentences(found).front());
  }
  EXPECT_LE(described, 1) << told;
}

}  // namespace
}  // namespace jaculus::diagnosis
