#include "diagnosis/forward/unknown_gains.h"

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/model/robot.h"

namespace jaculus::test {
namespace {

using namespace diagnosis;
using trajectory::Quantity;

/// A leap of Minitaur whose gains are known within [0.2, 1.2] and [0, 0.03].
ObservedDataset leap(Quantity quantity) {
  ObservedDataset observed;
  observed.model = model::read_robot(model::find_robot("minitaur", "")).planar;
  trajectory::StatedController& stated = observed.dataset.controller;
  stated.quantity = quantity;
  stated.gains_stated = true;
  stated.kp["*"].range = {0.2, 1.2};
  stated.kd["*"].range = {0.0, 0.03};
  return observed;
}

simulation::Controller controller_of(const ObservedDataset& observed) {
  const simulation::AssumedGains gains = first_gains(observed, {});
  simulation::Controller controller;
  for (const model::PlanarMotor& motor : observed.model.motors)
    controller.reference.motors.push_back(motor.joint);
  controller.kp = Vector::Constant(count_of(observed.model.motors), gains.kp.at("front_a"));
  controller.kd = Vector::Constant(count_of(observed.model.motors), gains.kd.at("front_a"));
  return controller;
}

Hypotheses hypotheses_of(const std::vector<ObservedDataset>& datasets) {
  Hypotheses hypotheses;
  for (const ObservedDataset& observed : datasets)
    add_gain_factors(observed, controller_of(observed), "", {}, hypotheses);
  return hypotheses;
}

TEST(UnknownGains, AreUniformOverTheStatedRangeAndBeginAtItsMiddle) {
  const ObservedDataset observed = leap(Quantity::torque);
  const simulation::Controller first = controller_of(observed);
  EXPECT_DOUBLE_EQ(first.kp[0], 0.7);
  Hypotheses h;
  const auto factors = add_gain_factors(observed, first, "", {}, h);
  ASSERT_EQ(h.parameters.size(), 2U);

  simulation::Plant plant;
  const auto gains_at = [&](double kp, double kd) {
    simulation::Controller moved = first;
    apply_factors(factors, Vec2(kp, kd), plant, moved);
    return Vec2(moved.kp[3], moved.kd[3]);
  };
  EXPECT_TRUE(gains_at(0.0, 0.0).isApprox(Vec2(0.7, 0.015)));
  EXPECT_TRUE(gains_at(10.0, -10.0).isApprox(Vec2(1.2, 0.0)));
  EXPECT_NEAR(gains_at(-0.6744897502, 0.0)[0], 0.45, 1e-9);  // the lower quartile
}

TEST(UnknownGains, LeaveTheScaleOfADutyOpenToo) {
  const Hypotheses h = hypotheses_of({leap(Quantity::duty)});
  ASSERT_EQ(h.parameters.size(), 3U);
  EXPECT_EQ(h.parameters[2].name, "log_feedforward");
}

TEST(UnknownGains, AreSharedByDatasetsThatStateTheSameController) {
  const ObservedDataset one = leap(Quantity::duty);
  ObservedDataset other = one;
  EXPECT_EQ(hypotheses_of({one, other}).gains.size(), 3U);
  EXPECT_TRUE(same_controller(one.dataset.controller, other.dataset.controller));
  other.dataset.controller.kp["*"].range.upper = 1.3;
  EXPECT_FALSE(same_controller(one.dataset.controller, other.dataset.controller));
}

ObservedDataset tracked(const std::vector<std::string>& channels) {
  ObservedDataset observed = leap(Quantity::duty);
  observed.dataset.folder = "leap_1";
  observed.streams = {"mocap"};
  for (const std::string& name : channels) {
    observed.channels.emplace_back();
    observed.channels.back().name = name;
    observed.channels.back().stream = "mocap";
  }
  return observed;
}

TEST(UnknownGains, AreAClockOfMotionCaptureThatIsAlone) {
  const ObservedDataset alone = tracked({"x", "z", "pitch"});
  Hypotheses h;
  EXPECT_TRUE(add_foreign_clock(tracked({"x", "front_a"}), false, {}, h).empty());
  const auto clock = add_foreign_clock(alone, false, {}, h);
  ASSERT_EQ(h.gains.size(), 1U);
  EXPECT_EQ(h.parameters[0].name, "clock");
  EXPECT_NEAR(h.parameters[0].scale, Settings{}.foreign_clock, 1e-15);

  simulation::Plant plant;
  simulation::Controller controller;
  apply_factors(clock, Vector::Constant(1, 0.007), plant, controller);
  EXPECT_NEAR(plant.sensing.latency.at("mocap"), 0.007, 1e-15);

  add_foreign_clock(alone, true, {}, h);
  EXPECT_EQ(h.parameters[1].name, "clock of leap_1");  // one for each dataset
}

TEST(UnknownGains, HaveStartsADeviationToEachSide) {
  Hypotheses h;
  add_foreign_clock(tracked({"x"}), false, {}, h);
  h.parameters.push_back({"tolerance", "mass", "deviations", 0.0, 1.0, {-2.0, 2.0}});
  const std::vector<Vector> starts = h.gain_starts(Vec2(0.0, 0.5));
  ASSERT_EQ(starts.size(), 3U);
  EXPECT_EQ(starts[1], Vec2(-0.01, 0.5));
  EXPECT_EQ(starts[2], Vec2(0.01, 0.5));
  EXPECT_EQ(h.gain_starts(Vec2(0.015, 0.5)).size(), 2U);  // beyond the bound there is none
}

}  // namespace
}  // namespace jaculus::test
