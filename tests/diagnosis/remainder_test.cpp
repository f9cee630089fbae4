// What a missing force follows: named where something is there, and nothing where only noise is.

#include "diagnosis/remainder/remainder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "diagnosis/remainder/hypothesis.h"
#include "jaculus/core/installation.h"
#include "jaculus/effects/user_effect.h"
#include "jaculus/model/robot.h"
#include "support/temporary_folder.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kBox = 0.05;        // [s]
constexpr double kRateNoise = 0.01;  // of a rate that a parabola gives [rad/s]
constexpr double kInertia = 0.15;    // [kg m^2]

/// What a force of one joint may be made of.
struct State {
  double q = 0.0, v = 0.0, torque = 0.0, time = 0.0;
};
using Force = std::function<double(const State&)>;

State state_at(int trial, double t) {
  const double a = 1.3 + 0.2 * trial, b = 3.1 + 0.3 * trial;
  State s;
  s.q = 1.2 * std::sin(a * t) + 0.4 * std::sin(b * t + trial);
  s.v = 1.2 * a * std::cos(a * t) + 0.4 * b * std::cos(b * t + trial);
  s.torque = 0.8 * std::sin(2.3 * t + 1.7 * trial);
  s.time = t;
  return s;
}

/// Boxes of three trials of 4 s of a pendulum that lacks a force, with noise of the rates at their
/// borders.
std::vector<MotionBox> boxes_lacking(const Force& force, int seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  std::vector<MotionBox> boxes;
  for (int trial = 0; trial < 3; ++trial) {
    double noise = kRateNoise * normal(generator);
    for (int k = 0; k < 80; ++k) {
      MotionBox box;
      box.trial = trial;
      box.start = k * kBox;
      box.length = kBox;
      box.q = box.v = box.torque = Matrix(1, kPathSamples + 1);
      Vector forces(kPathSamples + 1);
      for (int i = 0; i <= kPathSamples; ++i) {
        const State s = state_at(trial, box.start + kBox * i / kPathSamples);
        box.q(0, i) = s.q;
        box.v(0, i) = s.v;
        box.torque(0, i) = s.torque;
        forces[i] = force(s);
      }
      const double next = kRateNoise * normal(generator);
      const double missing = path_mean(forces.size(), [&](Eigen::Index i) { return forces[i]; });
      box.force = Vector::Constant(1, missing + kInertia * (next - noise) / kBox);
      noise = next;
      box.mean_rate = box.v.rowwise().mean();
      box.model_acceleration = (box.v.rightCols<1>() - box.v.leftCols<1>()) / kBox;
      boxes.push_back(std::move(box));
    }
  }
  return boxes;
}

RemainderPlace described(const Force& force, int seed) {
  Problem all;
  ObservedDataset observed;
  observed.model = model::read_robot(source_folder() / "models" / "ak80_pendulum").planar;
  observed.measured_input = true;
  observed.dataset.trials = {{"trial_01", {}}, {"trial_02", {}}, {"trial_03", {}}};
  all.observations.datasets.push_back(std::move(observed));
  const std::vector<RemainderPlace> places = described_places(all, {boxes_lacking(force, seed)});
  EXPECT_EQ(places.size(), 1U);
  return places.front();
}

TEST(Remainder, OfNoiseAloneFollowsNothingInNineteenOfTwentyDraws) {
  int named = 0;
  for (int seed = 1; seed <= 20; ++seed)
    named += described([](const State&) { return 0.0; }, seed).follows.empty() ? 0 : 1;
  EXPECT_LE(named, 1);
}

TEST(Remainder, CoggingIsPeriodicWithItsPeriod) {
  const double period = 0.3;
  const RemainderPlace place =
      described([&](const State& s) { return 0.1 * std::sin(2.0 * M_PI * s.q / period + 0.4); }, 1);
  ASSERT_EQ(place.follows.size(), 1U);
  EXPECT_EQ(place.follows[0].regressor, Regressor::periodic);
  EXPECT_NEAR(place.follows[0].period, period, 0.01 * period);
  EXPECT_GT(place.follows[0].ci95.upper, 0.9);
  EXPECT_NEAR(std::hypot(place.follows[0].coefficients[0], place.follows[0].coefficients[1]), 0.1,
              0.01);
}

TEST(Remainder, EachFamilyIsNamed) {
  const std::vector<std::pair<Regressor, Force>> families = {
      {Regressor::sign_of_speed, [](const State& s) { return -0.1 * std::tanh(s.v / 0.02); }},
      {Regressor::speed, [](const State& s) { return -0.05 * s.v; }},
      {Regressor::speed_squared, [](const State& s) { return -0.03 * s.v * std::abs(s.v); }},
      {Regressor::motor_torque, [](const State& s) { return -0.2 * s.torque; }},
      {Regressor::position, [](const State& s) { return -0.1 * (s.q - 0.4); }},
      {Regressor::time, [](const State& s) { return 0.05 * s.time - 0.1; }}};
  for (const auto& [regressor, force] : families) {
    const RemainderPlace place = described(force, 3);
    ASSERT_FALSE(place.follows.empty()) << to_text(regressor);
    EXPECT_EQ(place.follows[0].regressor, regressor) << to_text(place.follows[0].regressor);
    EXPECT_GT(place.follows[0].share, 0.8) << to_text(regressor);
  }
}

TEST(Remainder, TwoThingsAtOnceAreBothNamed) {
  const RemainderPlace place = described(
      [](const State& s) {
        return -0.1 * std::tanh(s.v / 0.02) + 0.1 * std::sin(2.0 * M_PI * s.q / 0.25);
      },
      2);
  ASSERT_EQ(place.follows.size(), 2U);
  for (const Regressor wanted : {Regressor::sign_of_speed, Regressor::periodic})
    EXPECT_TRUE(place.follows[0].regressor == wanted || place.follows[1].regressor == wanted);
}

TEST(Remainder, EveryPatternThatAFormulaReadsIsAnEffectThatCanBeRead) {
  const model::PlanarModel robot =
      model::read_robot(source_folder() / "models" / "double_pendulum").planar;
  const test::TemporaryFolder folder;
  for (const Regressor regressor :
       {Regressor::constant, Regressor::sign_of_speed, Regressor::speed, Regressor::speed_squared,
        Regressor::motor_torque, Regressor::torque_friction, Regressor::weight_friction,
        Regressor::position, Regressor::periodic, Regressor::time, Regressor::other_speed}) {
    Dependence own{regressor, "", kNaN, "", 0.6, {0.4, 0.7}, 1.0, {-0.1, 0.05}};
    if (regressor == Regressor::other_speed) own.of = "shoulder";
    if (regressor == Regressor::periodic) own.period = 0.3;
    Remainder remainder;
    remainder.places.push_back({"elbow", 0.08, "N m", 300, 0.05, {own}});
    const std::vector<std::string> texts = hypotheses_of(remainder, robot);
    ASSERT_EQ(texts.size(), 1U) << to_text(regressor);
    const std::string name = fmt::format("hypothesis_{}.yaml", static_cast<int>(regressor));
    EXPECT_NO_THROW(effects::catalogue_with({folder.write(name, texts[0]).string()}, {robot}))
        << texts[0];
  }
}

}  // namespace
}  // namespace jaculus::diagnosis
