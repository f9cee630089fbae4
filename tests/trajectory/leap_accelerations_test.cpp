#include "jaculus/trajectory/leap_accelerations.h"

#include <gtest/gtest.h>

#include <string>

#include "trajectory/accelerated.h"

namespace jaculus::trajectory {
namespace {

using test::accelerated;

TEST(LeapAccelerations, AreTheRecipeOnEveryTrialBesideThePlan) {
  const Vector time = Vector::LinSpaced(241, -0.5, 0.5);
  const auto trial = [&](const std::string& name, double a) {
    Stream stream;
    stream.name = kMocapStream;
    stream.time = time;
    stream.channels = {"x"};
    stream.units = {"m"};
    stream.values = accelerated(time, a).transpose();
    return Trial{name, {stream}};
  };
  Dataset dataset;
  EXPECT_FALSE(leap_accelerations(dataset)) << "there is no plan";
  Table plan{{{"time", "s"}, {"x_velocity", "m/s"}}, Matrix(2, 2), {}};
  plan.values << 0.0, 0.0, 0.2, 1.0;
  dataset.plan = plan;
  EXPECT_FALSE(leap_accelerations(dataset)) << "there is no trial";

  dataset.trials = {trial("slow", 4.0), trial("fast", 6.0), trial("still", 0.0)};
  const auto all = leap_accelerations(dataset);
  ASSERT_TRUE(all);
  ASSERT_EQ(all->trials.size(), 3U);
  EXPECT_DOUBLE_EQ(all->plan, 5.0);
  EXPECT_DOUBLE_EQ(all->duration, 0.2);
  EXPECT_FALSE(all->trials[2].found);
  for (const std::size_t k : {0U, 1U}) {
    const auto one = leap_speed(time, accelerated(time, k == 0 ? 4.0 : 6.0), Vector(), 0.2);
    ASSERT_TRUE(all->trials[k].found && one);
    EXPECT_EQ(all->trials[k].found->acceleration, one->acceleration);
  }
  EXPECT_DOUBLE_EQ(all->mean,
                   0.5 * (all->trials[0].found->acceleration + all->trials[1].found->acceleration));
}

}  // namespace
}  // namespace jaculus::trajectory
