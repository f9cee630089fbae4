// First departures on signals whose truth is known.

#include "diagnosis/localise/departure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace jaculus::diagnosis {
namespace {

Vector noise(int rows, std::mt19937& generator) {
  std::normal_distribution<double> normal;
  Vector v(rows);
  for (double& x : v) x = normal(generator);
  return v;
}

/// A position and a rate that leave at `onset` with an acceleration [unit/s^2]; noise 1.
std::vector<DepartureChannel> leaving(double onset, double acceleration, std::mt19937& generator) {
  std::vector<DepartureChannel> channels(2);
  for (std::size_t c = 0; c < 2; ++c) {
    channels[c].name = c == 0 ? "position" : "rate";
    channels[c].rate = c == 1;
    channels[c].time = Vector::LinSpaced(201, 0.0, 0.2);
    channels[c].error = Vector::Ones(201);
    channels[c].mean = noise(201, generator);
    for (Eigen::Index k = 0; k < 201; ++k) {
      const double t = std::max(0.0, channels[c].time[k] - onset);
      channels[c].mean[k] += c == 0 ? 0.5 * acceleration * t * t : 0.01 * acceleration * t;
    }
  }
  return channels;
}

TEST(FirstDeparture, OnsetIsFoundWithinItsInterval) {
  int covered = 0;
  double worst = 0.0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    std::mt19937 generator(seed);
    const Departure d = first_departure(leaving(0.080, 2e5, generator));
    ASSERT_TRUE(d.found);
    EXPECT_LT(d.false_alarm, 1e-6);
    EXPECT_GE(d.crossing, d.time);
    covered += d.ci95.contains(0.080) ? 1 : 0;
    worst = std::max(worst, std::abs(d.time - 0.080));
  }
  EXPECT_GE(covered, 88);
  EXPECT_LT(worst, 0.006);
}

TEST(FirstDeparture, NoiseAndASingleOutlierAreNone) {
  int found = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 generator(seed);
    std::vector<DepartureChannel> channels = leaving(1.0, 0.0, generator);
    channels[0].mean[50] += 20.0;
    found += first_departure(channels).found ? 1 : 0;
  }
  EXPECT_LE(found, 2);
}

TEST(FirstDeparture, WhatComesBackIsNoDeparture) {
  std::mt19937 generator(7);
  std::vector<DepartureChannel> channels = leaving(0.150, 4e5, generator);
  for (Eigen::Index k = 20; k < 60; ++k) channels[0].mean[k] += 15.0;
  const Departure d = first_departure(channels);
  ASSERT_TRUE(d.found);
  EXPECT_NEAR(d.time, 0.150, 0.006);
  EXPECT_EQ(d.channels.size(), 2u);
}

}  // namespace
}  // namespace jaculus::diagnosis
