// Pulses in missing forces: planted in noise, and not found where there is only noise.

#include "diagnosis/remainder/pulses.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace jaculus::test {
namespace {

using diagnosis::ForceBoxes;
using diagnosis::Pulse;
using diagnosis::unusual_pulses;

constexpr int kTrials = 4, kBoxes = 200;  // of a trial
constexpr double kLength = 0.05;          // [s]

/// Four trials of 10 s; noise of 0.1 and nothing that it follows.
ForceBoxes noise(unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0.0, 0.1);
  ForceBoxes boxes;
  boxes.length = kLength;
  boxes.time.resize(kTrials * kBoxes);
  boxes.force.resize(kTrials * kBoxes);
  for (int k = 0; k < kTrials * kBoxes; ++k) {
    boxes.trial.push_back(k / kBoxes);
    boxes.time[k] = kLength * (k % kBoxes + 0.5);
    boxes.force[k] = normal(generator);
  }
  boxes.follows = boxes.spreads = Matrix::Ones(boxes.time.size(), 1);
  return boxes;
}

/// A rate that goes to and fro, differently in every trial.
Vector rates(const ForceBoxes& boxes) {
  Vector rate(boxes.time.size());
  for (Eigen::Index k = 0; k < rate.size(); ++k)
    rate[k] = 5.0 * std::sin((1.0 + 0.2 * boxes.trial[k]) * boxes.time[k]);
  return rate;
}

void add_pulse(ForceBoxes& boxes, int trial, double middle, double peak, double length = 0.4) {
  for (Eigen::Index k = 0; k < boxes.time.size(); ++k) {
    const double along = (boxes.time[k] - middle) / length + 0.5;
    if (boxes.trial[k] == trial && along > 0.0 && along < 1.0)
      boxes.force[k] += peak * std::sin(std::numbers::pi * along);
  }
}

double middle_of(const ForceBoxes& boxes, const Pulse& pulse) {
  return 0.5 * (boxes.time[pulse.first] + boxes.time[pulse.last]);
}

TEST(Pulses, AreFoundWithTheirSignSizeAndLength) {
  ForceBoxes boxes = noise(1);
  add_pulse(boxes, 0, 3.0, 0.7);
  add_pulse(boxes, 2, 8.0, -0.6);
  const std::vector<Pulse> found = unusual_pulses(boxes, 0.05);
  ASSERT_EQ(found.size(), 2U);
  for (const Pulse& pulse : found) {
    const bool early = boxes.trial[pulse.first] == 0;
    EXPECT_TRUE(early || boxes.trial[pulse.first] == 2);
    EXPECT_NEAR(middle_of(boxes, pulse), early ? 3.0 : 8.0, 0.06);
    EXPECT_NEAR(pulse.peak, early ? 0.7 : -0.6, 0.15);
    EXPECT_NEAR(kLength * (pulse.last - pulse.first + 1), 0.4, 0.11);
    EXPECT_FALSE(pulse.every_trial);
    EXPECT_GT(pulse.probability, 0.95);
  }
}

TEST(Pulses, AreNoRatesThatWereMeasuredWronglyAtOneInstant) {
  ForceBoxes boxes = noise(2);
  boxes.force[300] += 2.0;
  boxes.force[301] -= 2.0;
  EXPECT_TRUE(unusual_pulses(boxes, 0.05).empty());
}

TEST(Pulses, ThatEveryTrialHasAreListedOnce) {
  ForceBoxes boxes = noise(3);
  for (int trial = 0; trial < kTrials; ++trial) add_pulse(boxes, trial, 6.0, 0.8);
  const std::vector<Pulse> found = unusual_pulses(boxes, 0.05);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found.front().every_trial);
  EXPECT_NEAR(middle_of(boxes, found.front()), 6.0, 0.06);
}

TEST(Pulses, ThatEveryTrialHasAreFoundWhereNoTrialTellsThem) {
  int found = 0, alone = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    ForceBoxes boxes = noise(100 + seed);
    add_pulse(boxes, 1, 6.0, 0.15);
    const std::vector<Pulse> of_one = unusual_pulses(boxes, 0.05);
    alone += of_one.empty() ? 0 : 1;
    for (const int trial : {0, 2, 3}) add_pulse(boxes, trial, 6.0, 0.15);
    for (const Pulse& pulse : unusual_pulses(boxes, 0.05)) {
      EXPECT_TRUE(pulse.every_trial);
      EXPECT_NEAR(middle_of(boxes, pulse), 6.0, 0.1);
      EXPECT_NEAR(pulse.peak, 0.15, 0.08);
      ++found;
    }
  }
  EXPECT_GE(found, 16);
  EXPECT_LE(alone, 5);
}

TEST(Pulses, OfOneTrialAreNoneOfEveryTrial) {
  ForceBoxes boxes = noise(4);
  add_pulse(boxes, 1, 6.0, 1.5);
  const std::vector<Pulse> found = unusual_pulses(boxes, 0.05);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_FALSE(found.front().every_trial);
  EXPECT_EQ(boxes.trial[found.front().first], 1);
}

TEST(Pulses, AreNoneWhereTheModelIsWrongAlikeInEveryTrial) {
  // A force that sways by the clock, 0.3 in every trial: the mean over trials holds all of it.
  ForceBoxes boxes = noise(5);
  for (Eigen::Index k = 0; k < boxes.time.size(); ++k)
    boxes.force[k] += 0.3 * std::sin(4.0 * boxes.time[k]);
  EXPECT_TRUE(unusual_pulses(boxes, 0.05).empty());
}

TEST(Pulses, AreSeldomMadeByNoise) {
  int alarms = 0;
  for (unsigned seed = 0; seed < 100; ++seed)
    alarms += unusual_pulses(noise(seed), 0.05).empty() ? 0 : 1;
  // At 5 % or less: 12 of 100 have a probability of 0.4 %.
  EXPECT_LT(alarms, 12);
}

TEST(Pulses, AreToldBesideWhatFastMotionLeaves) {
  // Noise of 0.02 at rest and 0.2 per rad/s: a usual size of 0.6 over all, of a pulse of 0.4 that
  // comes while little moves.
  ForceBoxes boxes = noise(4);
  const Vector rate = rates(boxes);
  boxes.force = (boxes.force.array() * (0.04 + 4.0 * rate.array().square()).sqrt()).matrix();
  boxes.spreads.conservativeResize(Eigen::NoChange, 2);
  boxes.spreads.col(1) = rate.cwiseAbs2();
  add_pulse(boxes, 0, std::numbers::pi, 0.6, 0.3);

  const std::vector<Pulse> found = unusual_pulses(boxes, 0.05);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(middle_of(boxes, found.front()), std::numbers::pi, 0.1);

  boxes.spreads = Matrix::Ones(boxes.time.size(), 1);
  for (const Pulse& pulse : unusual_pulses(boxes, 0.05))
    EXPECT_GT(std::abs(middle_of(boxes, pulse) - std::numbers::pi), 0.1);
}

TEST(Pulses, DoNotFollowTheMotion) {
  ForceBoxes boxes = noise(5);
  const Vector rate = rates(boxes);
  boxes.follows.conservativeResize(Eigen::NoChange, 3);
  boxes.follows.col(1) = rate;
  boxes.follows.col(2) = rate.cwiseSign();
  boxes.force += 0.3 * rate + 0.5 * rate.cwiseSign();
  add_pulse(boxes, 3, 7.0, 0.7);

  const std::vector<Pulse> found = unusual_pulses(boxes, 0.05);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(boxes.trial[found.front().first], 3);
  EXPECT_NEAR(found.front().peak, 0.7, 0.2);
}

TEST(UsualForce, HasTheVarianceThatMadeIt) {
  ForceBoxes boxes = noise(6);
  const Vector rate = rates(boxes);
  const Vector deviation = (0.01 + 0.04 * rate.array().square()).sqrt();
  boxes.force = 10.0 * boxes.force.cwiseProduct(deviation);
  boxes.spreads.conservativeResize(Eigen::NoChange, 2);
  boxes.spreads.col(1) = rate.cwiseAbs2();
  // Student's t with 4 degrees of freedom takes a normal's scale for 0.76 to 0.85 of what it is.
  const Vector found = diagnosis::usual_force(boxes).variance;
  const Vector ratio = found.array() / deviation.array().square();
  EXPECT_GT(ratio.minCoeff(), 0.5);
  EXPECT_LT(ratio.maxCoeff(), 1.0);
}

TEST(Pulses, NeedMoreThanAFewBoxes) {
  ForceBoxes few = noise(7);
  const Eigen::Index count = 30;
  few.time.conservativeResize(count);
  few.force.conservativeResize(count);
  few.trial.resize(count);
  few.follows = few.spreads = Matrix::Ones(count, 1);
  add_pulse(few, 0, 0.7, 3.0);
  EXPECT_TRUE(unusual_pulses(few, 0.05).empty());
}

}  // namespace
}  // namespace jaculus::test
