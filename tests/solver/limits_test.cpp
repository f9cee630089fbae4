// What is looked at between nodes, and under which name.

#include <gtest/gtest.h>

#include "solver/verify_limits.h"
#include "transcription/example_problems.h"

namespace jaculus::solver::detail {
namespace {

/// Limits that the pendulum passes under an input [N m] at a rate [rad/s], with 1 N m of dry
/// friction and a motor of 5 N m.
std::vector<LimitExcess> passed(double input, double rate) {
  const transcription::NonlinearProgram program = test::make_program(
      test::extended_problem("pendulum_swing_up", "override: {motors.swing.dry_friction: 1}"));
  components::EquationsPoint point(program.equations(), {});
  const Vector q = Vector::Zero(1), v = Vector::Constant(1, rate), u = Vector::Constant(1, input);
  EXPECT_TRUE(program.equations().evaluate(q, v, u, point));

  LimitMonitor monitor(program);
  monitor.begin_phase(point);
  monitor.check_point(0, 0.5, 0.0, u, point);
  return monitor.excesses();
}

TEST(Limits, TorqueBetweenNodesIsTheMotorsWithFrictionMadeUpFor) {
  const std::vector<LimitExcess> with_it = passed(4.5, 1.0);
  ASSERT_EQ(with_it.size(), 1U);
  EXPECT_EQ(with_it.front().name, "swing torque");
  EXPECT_NEAR(with_it.front().value, 5.5, 1e-6);  // 4.5 and 1 tanh(10)
  EXPECT_NEAR(with_it.front().limit, 5.0, 1e-12);
  EXPECT_NEAR(with_it.front().scaled, 0.5 / 5.0, 1e-6);

  EXPECT_TRUE(passed(4.5, -1.0).empty()) << "friction helps: 3.5 of 5 N m";
  EXPECT_TRUE(passed(-3.9, -1.0).empty()) << "-4.9 of 5 N m";
  EXPECT_EQ(passed(-4.5, -1.0).size(), 1U);
}

}  // namespace
}  // namespace jaculus::solver::detail
