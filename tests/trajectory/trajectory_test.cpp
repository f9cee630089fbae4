#include "jaculus/trajectory/trajectory.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace jaculus::trajectory {
namespace {

/// Three coordinates (one linear, one joint, one that is neither), two joints, one motor, one foot,
/// two phases.
Trajectory example() {
  Trajectory t;
  t.coordinates = {"x", "tail", "leg_angle"};
  t.angular = {false, true, true};
  t.joints = {"tail", "knee"};
  t.motors = {"tail"};
  t.feet = {"rear_foot"};
  t.phases = {{"push", {"rear_foot"}, 0, 1}, {"flight", {}, 2, 3}};
  t.time = Vector{{0.0, 0.1, 0.1, 0.2}};
  t.position = Matrix{{1, 2, 3, 4}, {5, 6, 7, 8}, {9, 10, 11, 12}};
  t.velocity = 10.0 * t.position;
  t.acceleration = 100.0 * t.position;
  t.joint_position = Matrix{{5, 6, 7, 8}, {-1, -2, -3, -4}};
  t.joint_velocity = 10.0 * t.joint_position;
  t.torque = Matrix{{0.1, 0.2, 0.3, 0.4}};
  t.motor_torque = t.torque / 4.0;
  t.current = 2.0 * t.torque;
  t.voltage = 3.0 * t.torque;
  t.force_x = Matrix{{20, 21, 22, 23}};
  t.force_z = Matrix{{70, 71, 72, 73}};
  return t;
}

TEST(Trajectory, TableHasTheColumnsOfAPlan) {
  const Table table = to_table(example());
  std::vector<std::string> names;
  for (const Column& c : table.columns) names.push_back(c.name + " [" + c.unit + "]");
  const std::vector<std::string> expected = {"time [s]",
                                             "x [m]",
                                             "leg_angle [rad]",
                                             "tail [rad]",
                                             "knee [rad]",
                                             "x_velocity [m/s]",
                                             "leg_angle_velocity [rad/s]",
                                             "tail_velocity [rad/s]",
                                             "knee_velocity [rad/s]",
                                             "x_acceleration [m/s^2]",
                                             "tail_acceleration [rad/s^2]",
                                             "leg_angle_acceleration [rad/s^2]",
                                             "tail_torque [N m]",
                                             "tail_motor_torque [N m]",
                                             "tail_current [A]",
                                             "tail_voltage [V]",
                                             "rear_foot_force_x [N]",
                                             "rear_foot_force_z [N]"};
  EXPECT_EQ(names, expected);
  EXPECT_EQ(table.phase, (std::vector<std::string>{"push", "push", "flight", "flight"}));
  ASSERT_EQ(table.values.rows(), 4);
  EXPECT_EQ(table.values(2, table.column("knee")), -3.0);
  EXPECT_EQ(table.values(2, table.column("leg_angle_velocity")), 110.0);
  EXPECT_EQ(table.values(3, table.column("tail_motor_torque")), 0.1);
  EXPECT_EQ(table.values(3, table.column("rear_foot_force_z")), 73.0);
}

TEST(Trajectory, AbsentQuantitiesHaveNoColumns) {
  Trajectory t = example();
  t.voltage.resize(0, 4);
  t.current.resize(0, 0);
  const Table table = to_table(t);
  EXPECT_EQ(table.column("tail_voltage"), -1);
  EXPECT_EQ(table.column("tail_current"), -1);
  EXPECT_GE(table.column("tail_torque"), 0);
}

TEST(Trajectory, PrismaticJointsAreInMetresAndNewtons) {
  Trajectory t = example();
  t.angular[1] = false;
  const Table table = to_table(t);
  const auto unit = [&](const std::string& name) { return table.columns[table.column(name)].unit; };
  EXPECT_EQ(unit("tail"), "m");
  EXPECT_EQ(unit("tail_velocity"), "m/s");
  EXPECT_EQ(unit("tail_torque"), "N");
  EXPECT_EQ(unit("tail_motor_torque"), "N m");
  EXPECT_EQ(unit("knee"), "rad");
}

TEST(Trajectory, PlanReadsBackTheSame) {
  const Table table = to_table(example());
  const Table back = parse_csv(format_csv(table), "plan.csv");
  EXPECT_EQ(back.values, table.values);
  EXPECT_EQ(back.phase, table.phase);
}

}  // namespace
}  // namespace jaculus::trajectory
