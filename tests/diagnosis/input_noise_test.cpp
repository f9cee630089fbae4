// What a logged input's own noise may do to windows.

#include "diagnosis/noise/input_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "diagnosis/data/scatter.h"
#include "jaculus/core/installation.h"
#include "jaculus/model/robot.h"

namespace jaculus::diagnosis {
namespace {

/// Samples at 500 Hz of a torque that swings and has a step, with white noise.
std::vector<double> noisy_torque(double deviation, int samples, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, deviation);
  std::vector<double> x;
  for (int i = 0; i < samples; ++i) {
    const double t = 0.002 * i;
    x.push_back(3.0 * std::sin(9.0 * t) + (t > 1.0 ? 2.0 : 0.0) + normal(random));
  }
  return x;
}

TEST(InputNoise, IsToldByTheLogAlone) {
  // A sum of some 1800 squares, each shared by three differences: 4 % of its root at most.
  for (const double deviation : {0.02, 0.3})
    for (const std::uint64_t seed : {1, 2, 3})
      EXPECT_NEAR(scatter_of(noisy_torque(deviation, 2000, seed)), deviation, 0.08 * deviation);
  EXPECT_LT(scatter_of(noisy_torque(1e-9, 2000, 1)), 1e-3);
  EXPECT_EQ(scatter_of({1.0, 2.0, 1.0}), 0.0);
}

/// Flicker as a sum of relaxing noises whose times double, of one variance each: of the spectral
/// density v/(ln 2 f), by the integral over the logarithm of their times.
std::vector<double> flicker(double h, int samples, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, std::sqrt(h * std::numbers::ln2));
  std::vector<double> x(samples, 0.0);
  for (double time = 0.25; time < 4.0 * samples; time *= 2.0) {
    const double keep = std::exp(-1.0 / time), renew = std::sqrt(1.0 - keep * keep);
    double slow = normal(random);
    for (double& value : x) {
      value += slow;
      slow = keep * slow + renew * normal(random);
    }
  }
  return x;
}

TEST(InputNoise, HasAsMuchFlickerAsTheLogAllowsAtMost) {
  // The least of several octaves lies below what each says, of the longest some thirty means.
  const double h = 0.04;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const double told = most_flicker(scatter_by_octaves(flicker(h, 4000, seed)));
    EXPECT_GT(told, 0.4 * std::sqrt(h));
    EXPECT_LT(told, 1.1 * std::sqrt(h));
  }

  // White noise has none to speak of, however a torque swings below it.
  for (const std::uint64_t seed : {1, 2, 3})
    EXPECT_LT(most_flicker(scatter_by_octaves(noisy_torque(0.3, 2000, seed))), 0.05);
  EXPECT_EQ(most_flicker(scatter_by_octaves({1.0, 2.0, 1.0})), 0.0);
}

TEST(InputNoise, OfAWindowIsWhiteAndFlicker) {
  const Vector white = deviations_of({0.3, 0.0}, 7);
  EXPECT_TRUE(white.isApprox(Vector::Constant(7, 0.3)));

  // Octaves: ln 2 of what is slower, and from half a cosine to the last and a half.
  const Vector both = deviations_of({0.3, 0.2}, 7);
  const double octaves = std::log(2.0) + std::log(13.0);
  EXPECT_NEAR(both.squaredNorm() / 7.0, 0.09 + 0.04 * octaves, 1e-12);
  EXPECT_NEAR(flicker_of_force(0.2 * std::sqrt(octaves), 7), 0.2, 1e-12);
  for (int k = 2; k < 7; ++k) EXPECT_LT(both[k], both[k - 1]);
}

ObservedDataset logged(trajectory::Quantity input, double deviation) {
  ObservedDataset observed;
  observed.model = model::read_robot(source_folder() / "models" / "double_pendulum").planar;
  observed.measured_input = true;
  observed.dataset.controller.kind = trajectory::ControllerKind::measured;
  observed.dataset.controller.input = input;
  const std::vector<double> x = noisy_torque(deviation, 2000, 4);
  trajectory::Stream s{"joints",
                       500.0,
                       Vector::LinSpaced(2000, 0.0, 3.998),
                       {trajectory::channel_name("elbow", input)},
                       {""},
                       Matrix(1, 2000)};
  s.values.row(0) = Eigen::Map<const Vector>(x.data(), 2000).transpose();
  observed.dataset.trials = {{"trial_01", {s}}};
  return observed;
}

TEST(InputNoise, IsAForceOverABoxAtEachJointThatWasLogged) {
  const Settings settings;
  const double samples = 500.0 * settings.force_box;
  const auto torque = input_noise(logged(trajectory::Quantity::torque, 0.2), settings);
  ASSERT_EQ(torque.size(), 1U);
  EXPECT_NEAR(torque.at("elbow").white, 0.2 / std::sqrt(samples), 0.02 / std::sqrt(samples));

  // A current is the torque that it makes.
  const ObservedDataset observed = logged(trajectory::Quantity::current, 0.2);
  const model::PlanarMotor& motor = observed.model.motors[observed.model.motor_index("elbow")];
  const double by_current = motor.torque_constant * motor.gear * motor.efficiency;
  const InputNoise current = input_noise(observed, settings).at("elbow");
  EXPECT_NEAR(current.white, by_current * torque.at("elbow").white, 1e-9 * by_current);
  EXPECT_NEAR(current.flicker, by_current * torque.at("elbow").flicker, 1e-9 * by_current);

  ObservedDataset commanded = logged(trajectory::Quantity::torque, 0.2);
  commanded.measured_input = false;
  EXPECT_TRUE(input_noise(commanded, settings).empty());
}

TEST(InputNoise, JoinsTheNuisancesOfAWindow) {
  Hypotheses hypotheses;
  for (const char* name : {"shoulder", "elbow"}) {
    ForceGroup group{name, {}};
    for (int box = 0; box < 2; ++box) {
      group.boxes.push_back(count_of(hypotheses.parameters));
      hypotheses.parameters.push_back({"force", name, "N m", 0.0, 12.0, {}});
    }
    hypotheses.forces.push_back(group);
  }
  const SegmentNuisances before{0, 3, Matrix::Ones(3, 1), Vector::Zero(1), Vector::Ones(1), {"c"}};
  const Matrix slopes = Matrix::Random(3, 4);
  const SegmentNuisances after =
      with_input_noise(before, hypotheses, {{"elbow", {0.6, 0.0}}}, slopes);
  ASSERT_EQ(after.columns.cols(), 3);
  EXPECT_EQ(after.columns.leftCols(1), before.columns);
  EXPECT_EQ(after.mean, Vector::Zero(3));
  EXPECT_TRUE(after.scale.isApprox((Vector(3) << 1.0, 0.05, 0.05).finished()));
  EXPECT_EQ(after.names.back(), "noise of the input at elbow");

  // White noise is the same by boxes and by their cosines.
  const Matrix by_cosines = after.columns.rightCols(2), by_boxes = slopes.rightCols(2);
  EXPECT_TRUE((by_cosines * by_cosines.transpose()).isApprox(by_boxes * by_boxes.transpose()));
}

}  // namespace
}  // namespace jaculus::diagnosis
