// Noise of every shape has the variance that it is told to have, and the shape.

#include "testbed/sensor_noise.h"

#include <gtest/gtest.h>

#include <cmath>

namespace jaculus::testbed {
namespace {

constexpr int kSamples = 200000;
constexpr double kStep = 1e-3;

Vector noise(double sd, const NoiseShape& shape) {
  std::mt19937_64 random(7);
  Vector values = Vector::Zero(kSamples);
  add_noise(values, sd, kStep, shape, random);
  return values;
}

double variance(const Vector& v) { return (v.array() - v.mean()).square().mean(); }

double correlation(const Vector& v, int lag) {
  const Eigen::Index n = v.size() - lag;
  return v.head(n).dot(v.tail(n)) / static_cast<double>(n) / variance(v);
}

TEST(SensorNoise, HasItsVarianceWhateverItsShape) {
  // Standard errors of a variance: sqrt(2/n) for white noise, wider by the correlation
  // (sqrt(T/dt) = 4.5) or the tails (kurtosis 9 at 5 degrees of freedom: twice).
  EXPECT_NEAR(variance(noise(2.0, {})), 4.0, 4.0 * 0.015);
  EXPECT_NEAR(variance(noise(2.0, {.coloured = 0.5, .correlation_time = 0.02})), 4.0, 4.0 * 0.05);
  EXPECT_NEAR(variance(noise(2.0, {.tails = 5.0})), 4.0, 4.0 * 0.05);
}

TEST(SensorNoise, IsCorrelatedByItsShareAndTime) {
  const Vector v = noise(1.0, {.coloured = 0.5, .correlation_time = 0.02});

  EXPECT_NEAR(correlation(v, 1), 0.5 * std::exp(-kStep / 0.02), 0.02);
  EXPECT_NEAR(correlation(v, 20), 0.5 * std::exp(-1.0), 0.03);
  EXPECT_NEAR(correlation(noise(1.0, {}), 1), 0.0, 0.01);
}

TEST(SensorNoise, HasTailsWhereAsked) {
  const auto beyond_four = [](const Vector& v) { return (v.array().abs() > 4.0).count(); };

  EXPECT_LT(beyond_four(noise(1.0, {})), 30) << "13 are expected of a normal";
  EXPECT_GT(beyond_four(noise(1.0, {.tails = 5.0})), 300);
}

TEST(SensorNoise, ALowPassLagsByItsTimeConstantAndAConverterRounds) {
  Vector step = Vector::Ones(1000);
  step[0] = 0.0;
  low_pass(step, 0.05, kStep);
  EXPECT_NEAR(step[50], 1.0 - std::exp(-1.0), 1e-12);

  Vector values(3);
  values << 0.24, 0.26, -0.9;
  quantise(values, 0.5);
  EXPECT_EQ(values, Vector((Vector(3) << 0.0, 0.5, -1.0).finished()));
}

}  // namespace
}  // namespace jaculus::testbed
