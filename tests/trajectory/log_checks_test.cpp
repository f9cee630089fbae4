// Logs that contradict themselves.

#include "jaculus/trajectory/log_checks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace jaculus::trajectory {
namespace {

/// A swing of 1 Hz at 200 Hz, angle and rate times a factor each, with noise and a gap.
Dataset swing(double by_angle, double by_rate, double noise = 1e-3) {
  constexpr int kSamples = 400;
  Stream stream{"joints",
                200.0,
                Vector::LinSpaced(kSamples, 0.0, (kSamples - 1) / 200.0),
                {"swing", "swing_velocity", "swing_torque"},
                {"rad", "rad/s", "N m"},
                Matrix::Zero(3, kSamples)};
  std::mt19937 generator(1);
  std::normal_distribution<double> normal(0.0, noise);
  for (int k = 0; k < kSamples; ++k) {
    const double phase = 2.0 * M_PI * stream.time[k];
    stream.values(0, k) = by_angle * (std::sin(phase) + normal(generator));
    stream.values(1, k) = by_rate * (2.0 * M_PI * std::cos(phase) + 10.0 * normal(generator));
  }
  stream.values(0, 100) = kNaN;
  Dataset dataset;
  dataset.trials = {{"trial_01", {stream}}};
  return dataset;
}

TEST(LogChecks, FindNothingInALogThatAgrees) {
  EXPECT_TRUE(rate_contradictions(swing(1.0, 1.0)).empty());
  // A rate that reads a fifth high is an effect, not another unit.
  EXPECT_TRUE(rate_contradictions(swing(1.0, 1.2)).empty());
  EXPECT_TRUE(rate_notes(swing(1.0, 1.0)).empty());
}

TEST(LogChecks, NameSignsAndUnits) {
  struct Case {
    double by_angle, by_rate, slope;
    const char* says;
  };
  for (const Case& c : {Case{-1.0, 1.0, -1.0, "the other sign"},
                        Case{180.0 / M_PI, 1.0, 180.0 / M_PI, "degrees beside rad/s"},
                        Case{1.0, 180.0 / M_PI, M_PI / 180.0, "radians beside deg/s"},
                        Case{1.0, 6.0, 1.0 / 6.0, ""}}) {
    const auto found = rate_contradictions(swing(c.by_angle, c.by_rate));
    ASSERT_EQ(found.size(), 1u) << c.slope;
    EXPECT_EQ(found[0].channel, "swing");
    EXPECT_NEAR(found[0].slope, c.slope, 0.03 * std::abs(c.slope));
    EXPECT_NE(to_text(found[0]).find(c.says), std::string::npos) << to_text(found[0]);
  }
}

TEST(LogChecks, NameTheTrialsThatHaveAnotherUnit) {
  Dataset dataset = swing(1.0, 1.0);
  for (const char* name : {"trial_02", "trial_03"}) {
    dataset.trials.push_back(swing(180.0 / M_PI, 1.0).trials.front());
    dataset.trials.back().name = name;
  }
  const auto found = rate_contradictions(dataset);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].trials, (std::vector<std::string>{"trial_02", "trial_03"}));
  EXPECT_NE(to_text(found[0]).find("trial_02, trial_03"), std::string::npos);
}

TEST(LogChecks, SayNothingOfNoise) {
  // At rest a rate of noise says nothing of an angle of noise.
  Dataset still = swing(1.0, 1.0);
  std::mt19937 generator(2);
  std::normal_distribution<double> normal;
  Matrix& values = still.trials[0].streams[0].values;
  values = Matrix::NullaryExpr(values.rows(), values.cols(),
                               [&](Eigen::Index, Eigen::Index) { return normal(generator); });
  EXPECT_TRUE(rate_contradictions(still).empty());
}

TEST(LogChecks, SayWhereStampsHaveAnotherRateThanIsStated) {
  Dataset dataset = swing(1.0, 1.0);
  dataset.trials[0].streams[0].rate_hz = 100.0;
  const auto notes = rate_notes(dataset);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0], "joints: stated at 100 Hz, its stamps are at 200 Hz (trial_01)");
}

}  // namespace
}  // namespace jaculus::trajectory
