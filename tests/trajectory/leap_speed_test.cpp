#include "jaculus/trajectory/leap_speed.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "jaculus/trajectory/dataset.h"
#include "support/shared_data.h"
#include "trajectory/accelerated.h"

namespace jaculus::trajectory {
namespace {

using test::accelerated;

TEST(LeapSpeed, OnAConstantAccelerationItsErrorIsThatOfAForwardDifference) {
  const double a = 5.0, dt = 1.0 / 240.0, duration = 0.2;
  const Vector time = Vector::LinSpaced(241, -0.5, 0.5);
  const auto found = leap_speed(time, accelerated(time, a), Vector(), duration);
  ASSERT_TRUE(found);
  // The last sample before the motion already has a third of the first step in its mean: a dt/6 =
  // 0.0035 m/s, still rest.
  EXPECT_NEAR(found->start, -dt, 1e-9);
  // A forward difference is the speed half a sample later.
  EXPECT_NEAR(found->speed, a * (found->start + duration + 0.5 * dt), 1e-9);
  EXPECT_NEAR(found->acceleration, found->speed / duration, 1e-12);
}

TEST(LeapSpeed, GapsAreLeftOutAndNoMotionIsNoLeap) {
  Vector time = Vector::LinSpaced(241, -0.5, 0.5);
  Vector x = accelerated(time, 5.0);
  const double whole = leap_speed(time, x, Vector(), 0.2)->speed;
  x[150] = kNaN;
  EXPECT_NEAR(leap_speed(time, x, Vector(), 0.2)->speed, whole, 1e-3);
  EXPECT_FALSE(leap_speed(time, Vector::Zero(241), Vector(), 0.2));
  EXPECT_FALSE(leap_speed(time, accelerated(time, 5.0), Vector(), 0.6)) << "the samples end before";
}

TEST(LeapSpeed, TheAuthorsTrialsGiveTheKnownFigures) {
  JACULUS_REQUIRE_SHARED_DATA(data);
  struct Case {
    std::string name;
    double acceleration, tolerance;
  };
  // The figures known of these sets, rounded to 0.05 m/s^2.
  for (const Case& c :
       {Case{"leap_tail_2019-06-21", 6.45, 0.05}, Case{"leap_tailless_2019-06-21", 5.8, 0.05},
        Case{"leap_inactive_tail_2019-07-17", 5.55, 0.05}}) {
    const Dataset dataset = read_dataset(data / "minitaur" / c.name);
    const Vector plan_time = dataset.plan->values.col(dataset.plan->column("time"));
    double sum = 0.0;
    for (const Trial& trial : dataset.trials) {
      const Stream& mocap = *trial.stream("mocap");
      const auto found = leap_speed(mocap.time, mocap.values.row(mocap.channel("x")).transpose(),
                                    mocap.values.row(mocap.channel("y")).transpose(),
                                    plan_time[plan_time.size() - 1]);
      ASSERT_TRUE(found) << c.name << ' ' << trial.name;
      sum += found->acceleration;
      RecordProperty(c.name + trial.name, std::to_string(found->acceleration));
    }
    EXPECT_NEAR(sum / static_cast<double>(dataset.trials.size()), c.acceleration, c.tolerance)
        << c.name;
  }
}

}  // namespace
}  // namespace jaculus::trajectory
