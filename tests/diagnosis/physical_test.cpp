// Held-out errors in units and tolerances: known errors come back in mm, horizons are judged as if
// the data ended there, bad tolerances are refused.

#include "jaculus/diagnosis/physical.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diagnosis/read_tolerances.h"
#include "diagnosis/toy.h"
#include "jaculus/diagnosis/diagnose.h"
#include "jaculus/diagnosis/diagnosis_json.h"
#include "support/input_error.h"

namespace jaculus::diagnosis {
namespace {

using test::toy_problem;
using test::toy_truth;
using test::ToyData;

/// Of the toy's sin(6 s), s = t/0.5: its root mean square over (from, to] as sampled [1].
double rms_of_second(double from, double to) {
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < 111; ++i) {
    const double t = -0.05 + 0.005 * i;
    if (t < from - 1e-9 || t > to + 1e-9) continue;
    sum += std::pow(std::sin(12.0 * t), 2);
    ++count;
  }
  return std::sqrt(sum / count);
}

const HorizonGap& at(const Diagnosis& d, const std::string& channel, std::size_t horizon) {
  return d.gap.channels.at(channel).horizons.at(horizon);
}

TEST(PhysicalGap, IsTheErrorInTheChannelsUnit) {
  const Diagnosis d = diagnose_problem(*toy_problem(toy_truth(0.0, 0.02)));
  ASSERT_TRUE(d.gap.valid);
  const HorizonGap& whole = at(d, "mocap.a", 0);
  // Nuisances of the first quarter (clock, offset) take a part of 0.02 sin(6 s) before.
  EXPECT_NEAR(whole.before, 0.02 * rms_of_second(0.125, 0.5), 0.25 * whole.before);
  EXPECT_NEAR(whole.after, 1e-3, 3e-4);  // the sensors' noise
  EXPECT_NEAR(whole.floor, 1e-3, 3e-4);
  EXPECT_NEAR(whole.reach, 0.5, 1e-9);

  const std::vector<PhysicalGap> shown = physical_gaps(d.gap, {}, {});
  ASSERT_EQ(shown.size(), 2u);
  EXPECT_EQ(shown[0].name, "a");
  EXPECT_EQ(shown[0].unit, "mm");
  EXPECT_DOUBLE_EQ(shown[0].judged.before, 1e3 * whole.before);
  EXPECT_FALSE(shown[0].met);
}

TEST(PhysicalGap, AHorizonIsJudgedAsIfDataEndedThere) {
  DiagnoseOptions options;
  options.accuracy.horizon = 0.3;
  const Diagnosis d = diagnose_problem(*toy_problem(toy_truth(0.0, 0.02)), options);
  ASSERT_EQ(d.gap.channels.at("mocap.a").horizons.size(), 2u);
  const HorizonGap& cut = at(d, "mocap.a", 1);
  EXPECT_NEAR(cut.reach, 0.3, 0.0051);  // the last sample before it
  EXPECT_DOUBLE_EQ(cut.horizon, 0.3);

  // The same data without what comes after 0.3 s, nominal model: the same error.
  auto ended = toy_problem(toy_truth(0.0, 0.02));
  for (int s = 0; s < count_of(ended->observations.datasets[0].segments); ++s) {
    ended->observations.datasets[0].segments[s].prefix_end = 0.25 * 0.3;
    ended->observations = without_tails(ended->observations, {{0, s, 0.3 - 1e-9}});
  }
  const Diagnosis short_data = diagnose_problem(*ended);
  ASSERT_TRUE(short_data.gap.valid);
  EXPECT_NEAR(at(short_data, "mocap.a", 0).before, cut.before, 0.1 * cut.before);
}

TEST(PhysicalGap, AHorizonThatNothingReachesIsSaid) {
  DiagnoseOptions options;
  options.accuracy.horizon = 3.0;
  const Diagnosis d = diagnose_problem(*toy_problem(toy_truth(0.0, 0.02)), options);
  const bool said = std::any_of(d.notes.begin(), d.notes.end(), [](const std::string& note) {
    return note.find("up to 3 s were asked for") != std::string::npos;
  });
  EXPECT_TRUE(said);
  EXPECT_NEAR(at(d, "mocap.a", 1).reach, 0.5, 1e-9);
  EXPECT_DOUBLE_EQ(at(d, "mocap.a", 1).after, at(d, "mocap.a", 0).after);
}

TEST(Tolerance, IsMetByTheAugmentedModelAlone) {
  DiagnoseOptions options;
  options.accuracy.tolerances = {"a=5mm", "b=0.1 mm"};
  const Diagnosis d = diagnose_problem(*toy_problem(toy_truth(0.0, 0.02)), options);
  const std::vector<PhysicalGap> rows = physical_gaps(d.gap, d.tolerances, d.horizon);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_DOUBLE_EQ(*rows[0].tolerance, 5.0);
  EXPECT_EQ(rows[0].met, true);
  EXPECT_EQ(rows[0].met_before, false);
  EXPECT_EQ(rows[1].met, false);

  const std::string text = diagnosis_text(d), json = diagnosis_json(d);
  EXPECT_TRUE(test::holds(text, "tolerance a 5 mm: met by the augmented model (")) << text;
  EXPECT_TRUE(test::holds(text, "no model could meet it")) << text;
  EXPECT_TRUE(test::holds(json, "\"met\": true")) << json;
}

TEST(Tolerance, OfWhatWasNotJudgedIsLeftOpen) {
  ToyData data;
  data.segments = 1;  // nothing can be held out
  DiagnoseOptions options;
  options.accuracy.tolerances = {"mocap.a=5 mm"};
  const Diagnosis d = diagnose_problem(*toy_problem(toy_truth(0.0, 0.02), data), options);
  const std::vector<PhysicalGap> rows = physical_gaps(d.gap, d.tolerances, d.horizon);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_FALSE(rows[0].met);
  EXPECT_TRUE(test::holds(diagnosis_text(d), "can't be judged")) << diagnosis_text(d);
}

TEST(Tolerance, IsRefusedWithWhatIsAllowed) {
  const auto problem = toy_problem(toy_truth(0.0, 0.0));
  const auto message = [&](const std::vector<std::string>& texts) {
    return test::input_error_of(
        [&] { static_cast<void>(read_tolerances(texts, problem->observations)); });
  };
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"c=5mm"}, "no channel 'c' is judged here"},
      {{"c=5mm"}, "allowed: a (mm), b (mm)"},
      {{"a=5 deg"}, "is in rad; allowed: a number in m"},
      {{"a=5"}, "has no unit"},
      {{"a=-5 mm"}, "allowed: more than 0 mm"},
      {{"a=wide"}, "is not a number"},
      {{"a"}, "allowed: CHANNEL=QUANTITY"},
      {{"a=5mm", "mocap.a=6mm"}, "mocap.a has a tolerance already"}};
  for (const auto& [texts, expected] : cases)
    EXPECT_TRUE(test::holds(message(texts), expected)) << message(texts);
  EXPECT_DOUBLE_EQ(read_tolerances({"a=5mm", "b=1 cm"}, problem->observations).at("mocap.b").value,
                   0.01);
  EXPECT_EQ(read_tolerances({"b=0.01 SI"}, problem->observations).at("mocap.b").value, 0.01);
}

TEST(ShownUnit, IsMillimetresAndDegrees) {
  EXPECT_EQ(shown_unit("m").unit, "mm");
  EXPECT_DOUBLE_EQ(180.0 * shown_unit("rad").size, std::numbers::pi);
  EXPECT_EQ(shown_unit("rad/s").unit, "rad/s");
  EXPECT_EQ(shown_unit("N m").size, 1.0);
}

TEST(PhysicalGap, TellsStreamsAndDatasetsOfOneChannelApart) {
  const auto channel = [](const char* dataset, const char* name) {
    return ChannelShrink{2.0, 1.0, dataset, name, "m", {}};
  };
  const auto names = [](const std::map<std::string, ChannelShrink>& channels) {
    HeldOut gap;
    gap.channels = channels;
    std::vector<std::string> list;
    for (const PhysicalGap& row : physical_gaps(gap, {}, {})) list.push_back(row.name);
    return list;
  };
  EXPECT_EQ(names({{"a.mocap.x", channel("a", "x")},
                   {"b.mocap.x", channel("b", "x")},
                   {"b.mocap.z", channel("b", "z")}}),
            (std::vector<std::string>{"a.x", "b.x", "z"}));
  EXPECT_EQ(names({{"imu.x", channel("", "x")}, {"mocap.x", channel("", "x")}}),
            (std::vector<std::string>{"imu.x", "mocap.x"}));
}

}  // namespace
}  // namespace jaculus::diagnosis
