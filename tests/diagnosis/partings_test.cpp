// Left and right that part: from where on, and by how much the body leaves the plane.

#include "diagnosis/data/partings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>
#include <random>

namespace jaculus::diagnosis {
namespace {

/// A robot with one leg, at rest for 50 ms before it is told something.
struct Legged {
  ObservedDataset observed;
  trajectory::Trial trial;

  /// `apart` of the time, at 1 kHz from -0.05 to 0.1 s.
  template <class Function>
  explicit Legged(Function&& apart, model::JointKind kind = model::JointKind::revolute) {
    observed.dataset.folder = "leap";
    observed.window_start = -0.1;
    model::PlanarBody leg;
    leg.name = "leg";
    leg.joint = "leg";
    leg.kind = kind;
    observed.model.bodies.push_back(leg);

    trajectory::Stream stream;
    stream.name = trajectory::kJointStream;
    stream.time = Vector::LinSpaced(151, -0.05, 0.1);
    stream.channels = {"leg", "leg_apart", "stance_apart"};
    stream.units = {"rad", "rad", "m"};
    stream.values = Matrix::Zero(3, 151);
    for (Eigen::Index k = 0; k < 151; ++k) stream.values(1, k) = apart(stream.time[k]);
    stream.values.row(2) = stream.time.transpose();  // of no joint
    trial.name = "trial_01";
    trial.streams.push_back(stream);
  }

  [[nodiscard]] std::optional<Parting> parting(double from, double to, double limit = 0.02) const {
    Settings settings;
    settings.sides_apart = limit;
    return first_parting(sides_of(observed, trial, settings), from, to);
  }
};

/// Zeros of both encoders differ by 0.03; from 0.05 s on the sides part by 2 rad/s.
double parting_at_50_ms(double t) { return 0.03 - (t < 0.0505 ? 0.0 : 2.0 * (t - 0.05)); }

TEST(Partings, BeginWhereTheDifferenceBeganToRise) {
  const Legged robot(parting_at_50_ms);
  const auto found = robot.parting(0.0, 0.0905);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->joint, "leg");
  EXPECT_EQ(found->dataset, "leap");
  EXPECT_EQ(found->trial, "trial_01");
  EXPECT_EQ(found->unit, "rad");
  EXPECT_NEAR(found->from, 0.05, 1e-9);
  EXPECT_NEAR(found->most, 0.08, 1e-9);

  // Later than where it is asked for, smaller than the limit, or all along: no parting.
  EXPECT_FALSE(robot.parting(0.0, 0.055).has_value());
  EXPECT_FALSE(robot.parting(0.0, 0.1, 0.2).has_value());
  EXPECT_FALSE(Legged([](double) { return 0.5; }).parting(0.0, 0.1).has_value());
}

TEST(Partings, AreSoughtAboutNoiseAndCountAsMuchWhereAJointSlides) {
  // Noise of 1 mrad either way, and the sides part by 2 mrad a sample.
  const auto noisy = [](double t) {
    const long k = std::lround(1e3 * t);
    return parting_at_50_ms(t) + (k % 2 == 0 ? 1e-3 : -1e-3);
  };
  const auto found = Legged(noisy).parting(0.0, 0.1);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->from, 0.053, 0.003);

  // What scatters by more than the limit does not part by it.
  const auto loud = [](double t) { return std::lround(1e3 * t) % 4 < 2 ? 0.03 : -0.03; };
  EXPECT_FALSE(Legged(loud).parting(0.0, 0.1).has_value());

  // 20 mrad at a lever of 0.1 m are 2 mm.
  const auto slides = [](double t) { return t > 0.05 ? 0.004 : 0.0; };
  EXPECT_FALSE(Legged(slides).parting(0.0, 0.1).has_value());
  EXPECT_TRUE(Legged(slides, model::JointKind::prismatic).parting(0.0, 0.1).has_value());
}

TEST(Partings, BeginAnewAboveAPlateau) {
  // Noise of 1 mrad, 40 mrad from 0.01 s on, as unlike friction makes them; then a foot lifts.
  const auto both = [](double t) {
    const long k = std::lround(1e3 * t);
    return (k % 2 == 0 ? 1e-3 : -1e-3) + (t < 0.0105 ? 0.0 : 0.04) +
           (t < 0.0805 ? 0.0 : 10.0 * (t - 0.08));
  };
  const Legged robot(both);
  const auto far = robot.parting(0.0, 0.1, 0.155);
  ASSERT_TRUE(far.has_value());
  EXPECT_NEAR(far->from, 0.08, 0.002);

  const auto near = robot.parting(0.0, 0.045);
  ASSERT_TRUE(near.has_value());
  EXPECT_NEAR(near->from, 0.01, 0.002);
  EXPECT_NEAR(near->most, 0.04, 0.003);
}

/// Noise of encoders and a motion, at so many Hz: where sides part that get 0.155 rad apart.
double parted_from(double rate, const std::function<double(double)>& apart) {
  std::mt19937 rng(4);
  std::normal_distribution<double> noise(0.0, 1.4e-3);
  Sides sides;
  sides.limit = 0.155;
  sides.noise = 2.0 * 1.4e-3;
  sides.rise = 0.02;
  for (double t = -0.2; t < 1.0; t += 1.0 / rate) {
    sides.time.push_back(t);
    sides.apart.push_back(apart(t) + noise(rng));
  }
  const auto found = first_parting({sides}, 0.0, 1.0);
  return found ? found->from : kNaN;
}

TEST(Partings, AreCutWhereTheyBeganWhateverTheRateOfTheLog) {
  // Slowly, and as a foot does that leaves the floor, which is at 0.1 s.
  for (const double rate : {250.0, 1000.0, 2000.0}) {
    for (const double slope : {0.3, 0.8, 5.0})
      EXPECT_NEAR(parted_from(rate, [&](double t) { return slope * std::max(0.0, t - 0.1); }), 0.1,
                  0.03)
          << slope << " rad/s at " << rate << " Hz";
    for (const double faster : {5.0, 20.0, 100.0}) {
      const auto lifted = [&](double t) {
        return 0.5 * faster * std::pow(std::max(0.0, t - 0.1), 2);
      };
      const double from = parted_from(rate, lifted);
      EXPECT_LT(std::abs(lifted(from)), 0.01) << faster << " rad/s^2 at " << rate << " Hz";
    }
  }
  // From one side to the other: the zero on the way is no start.
  const auto across = [](double t) {
    return t < 0.1 ? -0.12 : std::min(0.3, -0.12 + 4.0 * (t - 0.1));
  };
  EXPECT_NEAR(parted_from(1000.0, across), 0.1, 0.01);
}

TEST(Partings, AreNoSingleSampleAndNoGap) {
  const auto spike = [](double t) { return std::abs(t - 0.05) < 1e-6 ? 1.0 : 0.0; };
  EXPECT_FALSE(Legged(spike).parting(0.0, 0.1).has_value());
  const auto gap = [](double t) { return t > 0.03 && t < 0.06 ? kNaN : 0.0; };
  EXPECT_FALSE(Legged(gap).parting(0.0, 0.1).has_value());
}

TEST(Partings, OfWindowsAreOneOfTheTrial) {
  EXPECT_FALSE(as_one({}).has_value());
  const auto one =
      as_one({{"d", "t", "knee", 0.6, 0.1, "rad"}, {"d", "t", "hip", 0.2, 0.05, "rad"}});
  ASSERT_TRUE(one.has_value());
  EXPECT_EQ(one->joint, "hip");
  EXPECT_EQ(one->from, 0.2);
  EXPECT_EQ(one->most, 0.1);
}

TEST(Partings, OnlyJointsOfTheModelTellOfThePlane) {
  const Legged robot(parting_at_50_ms);
  EXPECT_TRUE(tells_of_plane(robot.observed.model, "joints", "leg_apart"));
  EXPECT_FALSE(tells_of_plane(robot.observed.model, "joints", "stance_apart"));
  EXPECT_TRUE(tells_of_plane(robot.observed.model, "mocap", "roll"));
  EXPECT_FALSE(tells_of_plane(robot.observed.model, "joints", "roll"));
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
