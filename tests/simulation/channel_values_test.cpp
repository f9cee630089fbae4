#include "simulation/experiment/channel_values.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "jaculus/model/robot.h"
#include "simulation/integrate/start.h"

namespace jaculus::simulation {
namespace {

constexpr double kStep = 1e-3, kTime = 2e-3;  // s

TEST(LowPass, LagsBehindARampByItsTime) {
  const Eigen::RowVectorXd ramp = Eigen::RowVectorXd::LinSpaced(41, 0.0, 0.4);
  const Eigen::RowVectorXd passed = low_passed(ramp, kStep, kTime);
  const double slope = 0.4 / (40 * kStep);
  for (Eigen::Index k = 0; k < ramp.size(); ++k) {
    const double t = static_cast<double>(k) * kStep;
    EXPECT_NEAR(passed[k], slope * (t - kTime * (1.0 - std::exp(-t / kTime))), 1e-12);
  }
}

TEST(LowPass, SettlesFromAJumpByItsTime) {
  Eigen::RowVectorXd jump = Eigen::RowVectorXd::Ones(21);
  jump[0] = 0.0;
  const Eigen::RowVectorXd passed = low_passed(jump, kStep, kTime);
  // after the sample within which it rises
  for (Eigen::Index k = 2; k < jump.size(); ++k)
    EXPECT_NEAR((1.0 - passed[k]) / (1.0 - passed[k - 1]), std::exp(-kStep / kTime), 1e-12);
}

TEST(LowPass, OfNoTimeIsTheValueItselfWithTheSlopeOfADelay) {
  Eigen::RowVectorXd values(5);
  values << 0.0, 1.0, -2.0, 0.5, 3.0;
  EXPECT_EQ(low_passed(values, kStep, 0.0), values);
  const double little = 1e-6;
  const Eigen::RowVectorXd passed = low_passed(values, kStep, little);
  for (Eigen::Index k = 1; k < values.size(); ++k)
    EXPECT_NEAR((passed[k] - values[k]) / little, -(values[k] - values[k - 1]) / kStep, 1e-6);
}

/// A base that moves and turns, every 0.1 ms.
Simulation turning_base(const Plant& plant) {
  const model::PlanarModel& model = plant.model;
  const int x = model.coordinate_index("x"), z = model.coordinate_index("z"),
            pitch = model.coordinate_index("pitch");
  Simulation s;
  s.time = Vector::LinSpaced(2001, 0.0, 0.2);
  s.q = Matrix::Zero(model.size(), s.time.size());
  s.v = s.q;
  for (Eigen::Index k = 0; k < s.time.size(); ++k) {
    const double t = s.time[k];
    s.q.col(k)[x] = 2.0 * t;
    s.q.col(k)[z] = 0.2 + 3.0 * t - 4.9 * t * t;
    s.q.col(k)[pitch] = 0.3 * std::sin(20.0 * t);
    s.v.col(k)[x] = 2.0;
    s.v.col(k)[z] = 3.0 - 9.8 * t;
    s.v.col(k)[pitch] = 6.0 * std::cos(20.0 * t);
  }
  return s;
}

TEST(TrackedChannel, IsThatOfAPointOfTheBaseOnTiltedAxes) {
  Plant plant;
  plant.model = model::read_robot(model::find_robot("minitaur", "")).planar;
  const Simulation s = turning_base(plant);
  for (const char* name : {"x", "z", "pitch", "x_velocity"})
    EXPECT_EQ(tracked_channel(plant, s, name), raw_channel(plant.model, s, name)) << name;

  plant.sensing.tracked_point = Vec2(0.05, 0.02);
  plant.sensing.mocap_tilt = 0.04;
  const Eigen::Index last = s.time.size() - 1;
  const double turned = 0.3 * std::sin(4.0);
  // Nose-down positive: a point ahead sinks as the pitch grows, one above goes ahead.
  const double x = 0.4 + 0.05 * std::cos(turned) + 0.02 * std::sin(turned);
  const double z = 0.2 + 0.6 - 0.196 - 0.05 * std::sin(turned) + 0.02 * std::cos(turned);
  // On axes whose x points down, what goes ahead rises.
  EXPECT_NEAR(tracked_channel(plant, s, "x")[last], std::cos(0.04) * x - std::sin(0.04) * z, 1e-12);
  EXPECT_NEAR(tracked_channel(plant, s, "z")[last], std::cos(0.04) * z + std::sin(0.04) * x, 1e-12);
  EXPECT_EQ(tracked_channel(plant, s, "pitch"), raw_channel(plant.model, s, "pitch"));

  for (const std::string name : {"x", "z"}) {
    const Eigen::RowVectorXd value = tracked_channel(plant, s, name);
    const Eigen::RowVectorXd rate = tracked_channel(plant, s, name + "_velocity");
    for (const Eigen::Index k : {500, 1000, 1500})
      EXPECT_NEAR(rate[k], (value[k + 1] - value[k - 1]) / 2e-4, 1e-5) << name;
  }
}

TEST(TrackedChannel, GivesBackTheBaseThatItShows) {
  Plant plant;
  plant.model = model::read_robot(model::find_robot("minitaur", "")).planar;
  const Simulation s = turning_base(plant);
  plant.sensing.tracked_point = Vec2(0.05, 0.02);
  plant.sensing.mocap_tilt = 0.04;
  const Eigen::Index k = 700;
  const StartState truth{s.q.col(k), s.v.col(k)};
  StartState read = truth;
  for (const std::string name : {"x", "z"}) {
    const int i = plant.model.coordinate_index(name);
    read.q[i] = tracked_channel(plant, s, name)[k];
    read.v[i] = tracked_channel(plant, s, name + "_velocity")[k];
  }
  EXPECT_GT((read.q - truth.q).norm(), 0.02);
  const StartState found = state_as_read(plant, read);
  EXPECT_LT((found.q - truth.q).norm(), 1e-12);
  EXPECT_LT((found.v - truth.v).norm(), 1e-12);
}

}  // namespace
}  // namespace jaculus::simulation
