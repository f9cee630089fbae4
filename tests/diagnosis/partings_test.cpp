// Left and right that part: from where on, and by how much the body leaves the plane.

#include "diagnosis/data/partings.h"

#include <gtest/gtest.h>

#include <cmath>

namespace jaculus::diagnosis {
namespace {

/// A trial at 1 kHz of 0.1 s whose sides differ by `apart`.
template <class Function>
trajectory::Trial trial_of(Function&& apart) {
  trajectory::Stream stream;
  stream.name = trajectory::kJointStream;
  stream.time = Vector::LinSpaced(101, 0.0, 0.1);
  stream.channels = {"leg", "leg_apart"};
  stream.units = {"rad", "rad"};
  stream.values = Matrix::Zero(2, 101);
  for (Eigen::Index k = 0; k < 101; ++k) stream.values(1, k) = apart(stream.time[k]);
  trajectory::Trial trial;
  trial.name = "trial_01";
  trial.streams.push_back(stream);
  return trial;
}

TEST(Partings, BeginWhereTheDifferenceBeganToRise) {
  // Zeros of both encoders differ by 0.03; from 0.05 s on the sides part by 2 rad/s.
  const auto apart = [](double t) { return 0.03 - (t < 0.0505 ? 0.0 : 2.0 * (t - 0.05)); };
  const auto found = first_parting(trial_of(apart), -0.1, 0.09, 0.02);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->joint, "leg");
  EXPECT_EQ(found->trial, "trial_01");
  EXPECT_EQ(found->unit, "rad");
  EXPECT_NEAR(found->from, 0.05, 1e-9);
  EXPECT_NEAR(found->most, 0.08, 1e-9);

  // Later than where it is asked for, smaller than the limit, or all along: no parting.
  EXPECT_FALSE(first_parting(trial_of(apart), -0.1, 0.055, 0.02).has_value());
  EXPECT_FALSE(first_parting(trial_of(apart), -0.1, 0.1, 0.2).has_value());
  EXPECT_FALSE(first_parting(trial_of([](double) { return 0.5; }), 0.0, 0.1, 0.02).has_value());
}

TEST(Partings, AreNoSingleSampleAndNoGap) {
  const auto spike = [](double t) { return std::abs(t - 0.05) < 1e-6 ? 1.0 : 0.0; };
  EXPECT_FALSE(first_parting(trial_of(spike), 0.0, 0.1, 0.02).has_value());
  const auto gap = [](double t) { return t > 0.03 && t < 0.06 ? kNaN : 0.0; };
  EXPECT_FALSE(first_parting(trial_of(gap), 0.0, 0.1, 0.02).has_value());
}

TEST(Partings, SayByHowMuchTheBodyLeavesThePlane) {
  trajectory::Dataset dataset;
  for (const double end : {0.010, 0.014}) {
    trajectory::Stream stream;
    stream.name = trajectory::kMocapStream;
    stream.time = Vector::LinSpaced(11, 0.0, 0.1);
    stream.channels = {"roll", "x"};
    stream.units = {"rad", "m"};
    stream.values = Matrix::Zero(2, 11);
    stream.values.row(0) = (0.2 + end / 0.1 * stream.time.array()).transpose();
    dataset.trials.push_back({"trial", {stream}});
  }
  // 12 mrad, and 4 between the two; at half the time half of it.
  const std::string note = out_of_plane(dataset, "leap", 0.0, 0.1);
  EXPECT_NE(note.find("leap: the body leaves the plane by roll 0.69 deg (0.16 from trial to trial) "
                      "at 0.1 s"),
            std::string::npos)
      << note;
  EXPECT_NE(out_of_plane(dataset, "leap", 0.0, 0.05).find("roll 0.34 deg"), std::string::npos);
  EXPECT_TRUE(out_of_plane(trajectory::Dataset{}, "leap", 0.0, 0.1).empty());
}

}  // namespace
}  // namespace jaculus::diagnosis
