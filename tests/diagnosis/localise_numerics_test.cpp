// The statistics behind the localisation, on signals whose truth is known.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "diagnosis/localise_departure.h"
#include "diagnosis/localise_shares.h"

namespace jaculus {
namespace {

constexpr int kRows = 400;

Vector noise(int rows, std::mt19937& generator) {
  std::normal_distribution<double> normal;
  Vector v(rows);
  for (double& x : v) x = normal(generator);
  return v;
}

/// Smooth signatures that overlap but differ: column c is a half sine power of its own, ten noise floors high at one prior width.
Matrix signatures(int columns) {
  Matrix S(kRows, columns);
  for (int c = 0; c < columns; ++c)
    for (int k = 0; k < kRows; ++k)
      S(k, c) = 10.0 * std::pow(static_cast<double>(k) / kRows, 1.0 + c) * std::cos(c * k / 60.0);
  return S;
}

ShareSystem system_of(const Matrix& S, const Vector& r) {
  ShareSystem system(static_cast<int>(S.cols()));
  system.add(S, r, Matrix(S.rows(), 0), Vector(0), static_cast<double>(S.rows()));
  return system;
}

std::vector<ShareCandidate> candidates_of(const std::vector<Component>& components, int side = 0) {
  std::vector<ShareCandidate> candidates;
  for (const Component c : components) {
    const int column = static_cast<int>(candidates.size());
    candidates.push_back({{column}, {side}, {{c, {column}}}});
  }
  return candidates;
}

const std::vector<Component> kThree{Component::tail_transmission, Component::actuation, Component::body};

const ComponentShare& share_of(const ShareAnswer& answer, Component c) {
  return answer.components[static_cast<size_t>(c)];
}

TEST(ComponentShares, OneEffectTakesTheGap) {
  std::mt19937 generator(1);
  const Matrix S = signatures(3);
  const ShareAnswer answer =
      component_shares(system_of(S, 1.5 * S.col(1) + noise(kRows, generator)), candidates_of(kThree));
  EXPECT_GT(share_of(answer, Component::actuation).share, 0.95);
  EXPECT_GT(share_of(answer, Component::actuation).ci95.lower, 0.8);
  EXPECT_GT(share_of(answer, Component::actuation).involved, 0.999);
  EXPECT_EQ(share_of(answer, Component::tail_transmission).ci95.lower, 0.0);
  EXPECT_TRUE(share_of(answer, Component::actuation).like.empty());
  EXPECT_LT(answer.unexplained, 0.02);
}

TEST(ComponentShares, TwoEffectsShareByEnergy) {
  std::mt19937 generator(2);
  Matrix S = Matrix::Zero(kRows, 3);
  S.col(0).head(kRows / 2).setConstant(5.0);
  S.col(1).tail(kRows / 2).setConstant(5.0);
  S.col(2) = Vector::LinSpaced(kRows, 0.0, 8.0);
  const Vector r = 1.0 * S.col(0) + 2.0 * S.col(1) + noise(kRows, generator);
  const ShareAnswer answer = component_shares(system_of(S, r), candidates_of(kThree));
  EXPECT_NEAR(share_of(answer, Component::tail_transmission).share, 0.2, 0.02);  // 1 : 4
  EXPECT_NEAR(share_of(answer, Component::actuation).share, 0.8, 0.02);
}

TEST(ComponentShares, SameSignatureLeavesTheIntervalsOpenAndNamesThePair) {
  std::mt19937 generator(3);
  Matrix S = signatures(3);
  S.col(2) = S.col(1);
  const ShareAnswer answer =
      component_shares(system_of(S, 1.5 * S.col(1) + noise(kRows, generator)), candidates_of(kThree));
  for (const Component c : {Component::actuation, Component::body}) {
    EXPECT_NEAR(share_of(answer, c).share, 0.5, 0.05);
    EXPECT_LT(share_of(answer, c).ci95.lower, 0.01);
    EXPECT_GT(share_of(answer, c).ci95.upper, 0.95);
  }
  EXPECT_EQ(share_of(answer, Component::actuation).like, std::vector<Component>{Component::body});
  EXPECT_EQ(share_of(answer, Component::body).like, std::vector<Component>{Component::actuation});
}

TEST(ComponentShares, NoiseAloneMakesNoClaim) {
  const Matrix S = signatures(3);
  int claims = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 generator(seed);
    const ShareAnswer answer =
        component_shares(system_of(S, noise(kRows, generator)), candidates_of(kThree), {3, 0.05, 400, 1});
    for (const ComponentShare& c : answer.components) claims += c.ci95.lower > 0.0 ? 1 : 0;
  }
  EXPECT_LE(claims, 4);  // 2 in 100
}

TEST(ComponentShares, WrongSideAndUnknownShapeStayUnexplained) {
  std::mt19937 generator(4);
  const Matrix S = signatures(3);
  const Vector wrong = -1.5 * S.col(1) + noise(kRows, generator);
  EXPECT_LT(share_of(component_shares(system_of(S, wrong), candidates_of(kThree, 1)), Component::actuation).share,
            0.05);
  Vector outside = noise(kRows, generator);
  for (int k = 0; k < kRows; ++k) outside[k] += 8.0 * ((k / 50) % 2 == 0 ? 1.0 : -1.0);
  const ShareAnswer answer = component_shares(system_of(S, outside), candidates_of(kThree));
  EXPECT_GT(answer.unexplained, 0.8);
  for (const ComponentShare& c : answer.components) EXPECT_EQ(c.ci95.lower, 0.0);
}

TEST(ComponentShares, WhatANuisanceMakesIsNoGap) {
  std::mt19937 generator(5);
  const Matrix S = signatures(3);
  ShareSystem system(3);
  system.add(S, 4.0 * S.col(1) + noise(kRows, generator), S.col(1), Vector::Zero(1), kRows);
  EXPECT_NEAR(system.rr, kRows, 100.0);
  EXPECT_LT(system.G(1, 1), 1e-6 * S.col(1).squaredNorm());
  const ShareAnswer answer = component_shares(system, candidates_of(kThree));
  EXPECT_FALSE(share_of(answer, Component::actuation).visible);
  for (const ComponentShare& c : answer.components) EXPECT_EQ(c.ci95.lower, 0.0);
}

TEST(ComponentShares, ASharedNuisanceGoesOutAsOneOfEachBlockDoes) {
  std::mt19937 generator(6);
  const Matrix S = signatures(3);
  const Vector r = 2.0 * S.col(0) + noise(kRows, generator);
  ShareSystem block(3), shared(3);
  block.add(S, r, S.col(2), Vector::Ones(1), kRows);
  shared.add(S, r, Matrix(kRows, 0), Vector(0), kRows);
  shared.project_out({2});
  EXPECT_NEAR(block.rr, shared.rr, 1e-9 * block.rr);
  EXPECT_LT((block.b - shared.b).head(2).norm(), 1e-9 * block.b.norm());
  EXPECT_LT((block.G - shared.G).topLeftCorner(2, 2).norm(), 1e-9 * block.G.norm());
  EXPECT_NEAR(block.rows, shared.rows, 1e-9);
}

TEST(ComponentShares, AnEffectInTwoComponentsIsSplitByTheirEnergies) {
  std::mt19937 generator(8);
  Matrix S = Matrix::Zero(kRows, 3);
  S.col(0).head(kRows / 2).setConstant(5.0);
  S.col(1).tail(kRows / 2).setConstant(10.0);
  S.col(2) = S.col(0) + S.col(1);
  const std::vector<ShareCandidate> candidates{{{0}, {1}, {{Component::front_legs, {0}}}},
                                               {{1}, {1}, {{Component::rear_legs, {1}}}},
                                               {{2}, {1}, {{Component::front_legs, {0}}, {Component::rear_legs, {1}}}}};
  const ShareAnswer answer = component_shares(system_of(S, S.col(2) + noise(kRows, generator)), candidates);
  EXPECT_NEAR(share_of(answer, Component::front_legs).share, 0.2, 0.03);
  EXPECT_NEAR(share_of(answer, Component::rear_legs).share, 0.8, 0.03);
}

/// A position and a rate that leave at `onset` with an acceleration [unit/s^2]; noise 1.
std::vector<DepartureChannel> leaving(double onset, double acceleration, std::mt19937& generator) {
  std::vector<DepartureChannel> channels(2);
  for (size_t c = 0; c < 2; ++c) {
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
}  // namespace jaculus
