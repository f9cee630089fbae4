#include "jaculus/export/export.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/installation.h"
#include "jaculus/core/yaml.h"
#include "jaculus/model/robot.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::exporting {
namespace {

using test::holds;
using test::input_error_of;
using transcription::InputHold;

/// Two intervals of 0.1 s, theta = t^3, torque 1 then -2.
Source two_steps(InputHold hold) {
  Source s;
  s.name = "2 steps";
  s.hold = hold;
  s.table.columns = {
      {"time", "s"}, {"arm", "rad"}, {"arm_velocity", "rad/s"}, {"arm_torque", "N m"}};
  s.table.values.resize(3, 4);
  const double tau[] = {1.0, -2.0, -2.0};
  for (int k = 0; k < 3; ++k) {
    const double t = 0.1 * k;
    s.table.values.row(k) << t, t * t * t, 3.0 * t * t, tau[k];
  }
  solver::MotorFigures motor;
  motor.joint = "arm";
  motor.count = 2;
  motor.gear = 4.0;
  motor.efficiency = 0.5;
  motor.torque_constant = 0.1;
  motor.resistance = 0.2;
  motor.saturation_linear = 9.0;
  motor.saturation_cubic = 0.5;
  motor.torque_limit = 1.0;
  motor.voltage_limit = 2.0;
  s.motors = {motor};
  s.limits_known = true;
  return s;
}

TEST(Resample, CubicMotionIsExactBetweenSamples) {
  const Export plan = resample(two_steps(InputHold::held), 1000.0, Side::joint);
  ASSERT_EQ(plan.time.size(), 201u);
  for (std::size_t k = 0; k < plan.time.size(); ++k) {
    const double t = plan.time[k];
    EXPECT_NEAR(plan.motors[0].position[k], t * t * t, 1e-15);
    EXPECT_NEAR(plan.motors[0].velocity[k], 3.0 * t * t, 1e-13);
  }
}

TEST(Resample, HonoursTheHoldOfTheInputs) {
  const Export held = resample(two_steps(InputHold::held), 40.0, Side::joint);
  EXPECT_EQ(held.motors[0].torque[3], 1.0);
  EXPECT_EQ(held.motors[0].torque[4], -2.0);
  const Export linear = resample(two_steps(InputHold::linear), 40.0, Side::joint);
  // From 1 to -2 in 0.1 s: in the middle of [0.05, 0.075].
  EXPECT_NEAR(linear.motors[0].torque[2], 1.0 - 30.0 * 0.0625, 1e-12);
}

TEST(Resample, ASampleHasTheImpulseOfThePlanWhateverTheRate) {
  for (const double rate : {7.0, 37.0, 1000.0}) {
    const Export held = resample(two_steps(InputHold::held), rate, Side::joint);
    const Export linear = resample(two_steps(InputHold::linear), rate, Side::joint);
    double impulses[] = {0.0, 0.0};
    for (std::size_t k = 0; k < held.time.size(); ++k) {
      const double lasts = std::min(held.time[k] + 1.0 / rate, 0.2) - held.time[k];
      impulses[0] += lasts * held.motors[0].torque[k];
      impulses[1] += lasts * linear.motors[0].torque[k];
    }
    EXPECT_NEAR(impulses[0], 0.1 * 1.0 - 0.1 * 2.0, 1e-12) << rate;
    EXPECT_NEAR(impulses[1], 0.1 * -0.5 - 0.1 * 2.0, 1e-12) << rate;
  }
}

/// One interval of 0.1 s in which the arm turns at 0.031 s, under a torque of 2 N m against 1.5 N m
/// of dry friction: v = 2000 (t - 0.031).
Source turning(InputHold hold) {
  Source s = two_steps(hold);
  s.motors[0].dry_friction = 1.5;
  s.motors[0].torque_limit = kInfinity;
  s.table.values.resize(2, 4);
  for (int k = 0; k < 2; ++k) {
    const double t = 0.1 * k, v = 2000.0 * (t - 0.031);
    s.table.values.row(k) << t, 1000.0 * t * t - 62.0 * t, v, 2.0 + std::copysign(1.5, v);
  }
  return s;
}

TEST(Resample, FrictionThatIsMadeUpForFollowsTheVelocityOfEachInstant) {
  for (const InputHold hold : {InputHold::held, InputHold::linear}) {
    const Export plan = resample(turning(hold), 1000.0, Side::joint);
    const ExportedMotor& arm = plan.motors[0];
    // 0.1 rad/s, within which friction swells, are left behind in a tenth of a millisecond
    EXPECT_NEAR(arm.torque[29], 2.0 - 1.5, 1e-3);
    EXPECT_NEAR(arm.torque[30], 2.0 - 1.5, 0.06) << "on the way to the turn";
    EXPECT_NEAR(arm.torque[31], 2.0 + 1.5, 0.06) << "and from it";
    EXPECT_NEAR(arm.torque[32], 2.0 + 1.5, 1e-3);
    // a sample in which it turns has as much of either sign as its time
    const Export slow = resample(turning(hold), 100.0, Side::joint);
    EXPECT_NEAR(slow.motors[0].torque[3], 2.0 - 1.5 * 0.1 + 1.5 * 0.9, 2.0 * 1.5 / 64);
  }
}

TEST(Resample, WithoutFrictionNothingIsAdded) {
  Source s = turning(InputHold::linear);
  s.motors[0].dry_friction = 0.0;
  const Export plan = resample(s, 1000.0, Side::joint);
  EXPECT_NEAR(plan.motors[0].torque[50], 2.0 + 1.5 * (2.0 * 0.505 - 1.0), 1e-12);
}

/// The arm as a left joint and a right one that turns the other way, and a joint that is held.
Export two_sided() {
  Source s = two_steps(InputHold::held);
  s.motors[0].file_joints = {{"left", 1.0}, {"right", -1.0}};
  s.held_joints = {{"roll", 0.25, false}};
  return resample(s, 10.0, Side::joint);
}

TEST(ExportFormats, LeftAndRightAreWrittenOutWithTheirOwnSigns) {
  const Export plan = two_sided();
  const auto json = nlohmann::json::parse(to_json(plan));
  ASSERT_EQ(json["joints"].size(), 2u);
  EXPECT_EQ(json["joints"][1]["name"], "right");
  EXPECT_EQ(json["joints"][1]["motor"], "arm");
  for (const char* key : {"position", "velocity", "torque", "current_A", "voltage_V"})
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(json["joints"][1][key][k], -json["joints"][0][key][k].get<double>()) << key;
  EXPECT_EQ(json["joints"][0]["torque"][0], 1.0);

  const test::TemporaryFolder folder;
  const trajectory::Table table = trajectory::read_csv(folder.write("e.csv", to_csv(plan)));
  EXPECT_EQ(table.values(2, table.column("left")), -table.values(2, table.column("right")));
  EXPECT_EQ(table.column("arm"), -1);

  const yaml::Node message = yaml::Node::parse(to_joint_trajectory(plan), "export");
  EXPECT_EQ(message.at("joint_names").texts(), (std::vector<std::string>{"left", "right", "roll"}));
  EXPECT_EQ(message.at("points").items()[0].at("effort").numbers(dimension::none),
            (std::vector<double>{1.0, -1.0, 0.0}));
  EXPECT_TRUE(holds(to_c(plan), "{\"left\", \"right\"}"));
  EXPECT_TRUE(holds(to_c(plan), "arm of the plan is left, minus right"));
}

TEST(ExportFormats, HeldJointsStandInEveryFormat) {
  const Export plan = two_sided();
  EXPECT_EQ(nlohmann::json::parse(to_json(plan))["held_joints"][0]["position"], 0.25);
  EXPECT_TRUE(holds(to_csv(plan), ",roll [rad]"));
  EXPECT_TRUE(holds(to_c(plan), "held_position[1] = {2.50000000e-01f}"));
  const yaml::Node message = yaml::Node::parse(to_joint_trajectory(plan), "export");
  EXPECT_EQ(message.at("points").items()[2].at("positions").numbers(dimension::none)[2], 0.25);
}

TEST(ExportFormats, WhatSlidesIsInMetresAndNewtons) {
  Source s = two_steps(InputHold::held);
  s.motors[0].slides = true;
  const std::string text = to_csv(resample(s, 10.0, Side::joint));
  EXPECT_TRUE(holds(text, "arm [m],arm_velocity [m/s],arm_torque [N]")) << text;
}

TEST(ExportFormats, CaptionsOfAHeaderHaveTheUnitsOfEachJoint) {
  Source s = two_steps(InputHold::held);
  s.motors[0].slides = true;
  EXPECT_TRUE(holds(to_c(resample(s, 10.0, Side::joint)), "/* joint torque [N] */"));
  s.table.columns.insert(s.table.columns.end(),
                         {{"leg", "rad"}, {"leg_velocity", "rad/s"}, {"leg_torque", "N m"}});
  const Matrix one = s.table.values;
  s.table.values.resize(3, 7);
  s.table.values << one, one.rightCols(3);
  s.motors.push_back(s.motors[0]);
  s.motors[1].joint = "leg";
  s.motors[1].slides = false;
  EXPECT_TRUE(holds(to_c(resample(s, 10.0, Side::motor)), "/* motor position [m, rad] */"));
}

TEST(ExportFormats, AnAttachedJointIsSaidToBeNoneOfTheFile) {
  Source s = two_steps(InputHold::held);
  s.motors[0].file_joints = {{"tail", 1.0, true}};
  const Export plan = resample(s, 10.0, Side::joint);
  EXPECT_TRUE(holds(to_c(plan), "tail: attached by robot.yaml, not in the robot's file"));
  EXPECT_EQ(nlohmann::json::parse(to_json(plan))["joints"][0]["attached"], true);
  EXPECT_EQ(nlohmann::json::parse(to_json(two_sided()))["joints"][0]["attached"], false);
}

TEST(ExportFormats, WhatIsHeldStaysOnItsJointsSideOfTheGear) {
  Source s = two_steps(InputHold::held);
  s.held_joints = {{"roll", 0.25, false}};
  const Export plan = resample(s, 10.0, Side::motor);
  const auto held = nlohmann::json::parse(to_json(plan))["held_joints"][0];
  EXPECT_EQ(held["position"], 0.25);
  EXPECT_EQ(held["side"], "joint");
  EXPECT_TRUE(holds(to_joint_trajectory(plan), "0.25 rad behind its gear, of which nothing"));
}

TEST(Resample, ASpeedLimitIsHeldBeforeTheGearAtBothEndsOfASample) {
  Source s = two_steps(InputHold::held);
  // 3 t^2 at the end, 0.2 s, times the gear of 4
  const double peak = 4.0 * 3.0 * 0.04;
  const auto speed_of = [&](double limit) {
    s.motors[0].speed_limit = limit;
    const Export plan = resample(s, 7.0, Side::joint);
    return *std::find_if(plan.checks.begin(), plan.checks.end(), [](const LimitCheck& c) {
      return c.quantity == trajectory::Quantity::velocity;
    });
  };
  EXPECT_NEAR(speed_of(kInfinity).peak, peak, 1e-12);
  EXPECT_FALSE(speed_of(kInfinity).exceeded);
  EXPECT_FALSE(speed_of(peak).exceeded);
  EXPECT_TRUE(speed_of(0.99 * peak).exceeded);
  EXPECT_NEAR(speed_of(0.99 * peak).time, 0.2, 1e-12);
}

TEST(ExportFormats, UnknownJointsAreSaidToBeThePlansOwn) {
  const Export plan = resample(two_steps(InputHold::held), 10.0, Side::joint);
  EXPECT_FALSE(plan.file_joints_known);
  EXPECT_TRUE(holds(to_c(plan), "joints are the plan's"));
  EXPECT_EQ(nlohmann::json::parse(to_json(plan))["joints_of_robot_file"], false);
  EXPECT_TRUE(two_sided().file_joints_known);
}

TEST(Resample, AtTheBorderOfTwoPhasesTheLaterCounts) {
  Source s = two_steps(InputHold::held);
  Matrix values(4, 4);
  values.topRows(2) = s.table.values.topRows(2);
  values.bottomRows(2) = s.table.values.bottomRows(2);
  values(1, 3) = 1.0;
  values.row(2) = s.table.values.row(1);
  s.table.values = values;
  EXPECT_EQ(resample(s, 10.0, Side::joint).motors[0].torque[1], -2.0);
}

TEST(Resample, MotorSideIsBeforeTheGear) {
  const Export plan = resample(two_steps(InputHold::held), 10.0, Side::motor);
  EXPECT_NEAR(plan.motors[0].torque[0], 1.0 / (4.0 * 0.5), 1e-15);
  EXPECT_NEAR(plan.motors[0].position[2], 4.0 * 0.008, 1e-15);
  EXPECT_NEAR(plan.motors[0].velocity[2], 4.0 * 0.12, 1e-15);
}

TEST(Resample, ChecksLimitsAtBothEndsOfASample) {
  const Export plan = resample(two_steps(InputHold::held), 10.0, Side::joint);
  ASSERT_EQ(plan.checks.size(), 4u);
  EXPECT_EQ(plan.checks[0].quantity, trajectory::Quantity::torque);
  EXPECT_NEAR(plan.checks[0].peak, 1.0, 1e-12);
  EXPECT_FALSE(plan.checks[0].exceeded);  // just at its limit
  EXPECT_FALSE(plan.checks[1].exceeded);  // no limit on current
  // 9 A and 0.5 A through 0.2 ohm at the second sample, less what the motion induces.
  EXPECT_NEAR(plan.checks[2].peak, 0.2 * 9.5 - 0.1 * 4.0 * 0.03, 1e-12);
  EXPECT_FALSE(plan.checks[2].exceeded);
  Source tight = two_steps(InputHold::held);
  tight.motors[0].voltage_limit = 1.5;
  EXPECT_TRUE(resample(tight, 10.0, Side::joint).checks[2].exceeded);
}

TEST(ExportFormats, JointTrajectoryIsYamlWithAllPoints) {
  const Export plan = resample(two_steps(InputHold::held), 10.0, Side::joint);
  const yaml::Node node = yaml::Node::parse(to_joint_trajectory(plan), "export");
  node.only({"header", "joint_names", "points"});
  EXPECT_EQ(node.at("joint_names").texts(), std::vector<std::string>{"arm"});
  const auto points = node.at("points").items();
  ASSERT_EQ(points.size(), 3u);
  EXPECT_EQ(points[1].at("effort").numbers(dimension::none).at(0), -2.0);
  EXPECT_EQ(points[1].at("time_from_start").at("nanosec").integer(0, 999999999), 100000000);
}

TEST(ExportFormats, StateSideHoldAndExceededLimits) {
  Source s = two_steps(InputHold::linear);
  s.motors[0].voltage_limit = 0.5;
  const Export plan = resample(s, 10.0, Side::motor);
  const std::string text = to_c(plan);
  EXPECT_TRUE(holds(text, "motor side"));
  EXPECT_TRUE(holds(text, "inputs were linear"));
  EXPECT_TRUE(holds(text, "LIMIT EXCEEDED: arm voltage"));
  EXPECT_TRUE(holds(text, "_2_steps_torque[3][1]"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '{'), std::count(text.begin(), text.end(), '}'));
  const auto json = nlohmann::json::parse(to_json(plan));
  EXPECT_EQ(json["side"], "motor");
  EXPECT_EQ(json["plan_hold"], "linear");
  EXPECT_EQ(json["joints"][0]["torque"].size(), 3u);
}

TEST(ExportFormats, CsvReadsBack) {
  const test::TemporaryFolder folder;
  const Export plan = resample(two_steps(InputHold::held), 1000.0, Side::joint);
  const trajectory::Table table = trajectory::read_csv(folder.write("e.csv", to_csv(plan)));
  const auto column = table.values.col(table.column("arm_torque"));
  ASSERT_EQ(column.size(), plan.time.size());
  for (Eigen::Index k = 0; k < column.size(); ++k) EXPECT_EQ(column[k], plan.motors[0].torque[k]);
  EXPECT_GE(table.column("arm_voltage"), 0);
}

TEST(ExportSource, FindsThePlanAndItsHold) {
  const test::TemporaryFolder folder;
  folder.write("plan.csv",
               "time [s],arm [rad],arm_velocity [rad/s],arm_torque [N m]\n0,0,0,1\n1,1,0,1\n");
  const auto read = [&](const std::string& name, const std::optional<InputHold>& hold) {
    return read_source(name.empty() ? folder.path() : folder / name, hold);
  };
  EXPECT_EQ(read("plan.csv", InputHold::held).motors[0].joint, "arm");
  EXPECT_FALSE(read("", InputHold::linear).limits_known);
  EXPECT_TRUE(holds(input_error_of([&] { static_cast<void>(read("", std::nullopt)); }), "--hold"));
  solver::Summary summary;
  summary.name = "s";
  summary.status = solver::Status::optimal;
  summary.input_hold = InputHold::held;
  solver::MotorFigures motor;
  motor.joint = "arm";
  summary.motors = {motor};
  folder.write("summary.json", solver::to_json(summary).dump());
  EXPECT_EQ(read("plan.csv", std::nullopt).hold, InputHold::held);
  EXPECT_TRUE(read("plan.csv", std::nullopt).limits_known);
  EXPECT_TRUE(
      holds(input_error_of([&] { static_cast<void>(read("", InputHold::linear)); }), "are held"));
  folder.write("summary.json", "{");
  EXPECT_TRUE(
      holds(input_error_of([&] { static_cast<void>(read("", std::nullopt)); }), "not JSON"));
}

TEST(ExportSource, ALonePlanTakesJointsAndLimitsFromARobot) {
  const model::Robot robot = model::read_robot(source_folder() / "models" / "minitaur_tail");
  const std::filesystem::path file = source_folder() / "problems" / "leap_tail_plan.csv";
  const Source source = read_source(file, InputHold::held, &robot.planar);
  ASSERT_EQ(source.motors.size(), 5u);
  EXPECT_TRUE(source.limits_known);
  EXPECT_EQ(source.motors[0].voltage_limit, 16.0);
  std::vector<std::string> names;
  const Export plan = resample(source, 100.0, Side::joint);
  for (const PlayedJoint& joint : played_joints(plan)) names.push_back(joint.name);
  EXPECT_EQ(names, (std::vector<std::string>{"front_left_a", "front_right_a", "front_left_b",
                                             "front_right_b", "rear_left_a", "rear_right_a",
                                             "rear_left_b", "rear_right_b", "tail"}));
}

TEST(ExportSource, ARobotWithoutThePlansMotorsIsRefused) {
  const model::Robot robot = model::read_robot(source_folder() / "models" / "minitaur");
  const std::filesystem::path file = source_folder() / "problems" / "leap_tail_plan.csv";
  const std::string error =
      input_error_of([&] { static_cast<void>(read_source(file, InputHold::held, &robot.planar)); });
  EXPECT_TRUE(holds(error, "tail_torque"));
  EXPECT_TRUE(holds(error, "allowed: front_a"));

  const test::TemporaryFolder folder;
  folder.write("plan.csv",
               "time [s],arm [rad],arm_velocity [rad/s],arm_torque [N m]\n0,0,0,1\n1,1,0,1\n");
  solver::Summary summary;
  summary.status = solver::Status::optimal;
  folder.write("summary.json", solver::to_json(summary).dump());
  EXPECT_TRUE(holds(input_error_of([&] {
                      static_cast<void>(read_source(folder.path(), std::nullopt, &robot.planar));
                    }),
                    "--robot with a plan.csv alone"));
}

TEST(ExportSource, RefusesPlansThatCantBePlayed) {
  const test::TemporaryFolder folder;
  const auto error = [&](const std::string& text) {
    folder.write("plan.csv", text);
    return input_error_of([&] { static_cast<void>(read_source(folder.path(), InputHold::held)); });
  };
  EXPECT_TRUE(holds(error("time [s],arm [rad]\n0,0\n"), "<joint>_torque"));
  EXPECT_TRUE(
      holds(error("time [s],arm [rad],arm_torque [N m]\n0,0,0\n"), "'arm_velocity' is missing"));
  EXPECT_TRUE(holds(error("time [s],arm [rad],arm_velocity [rad/s],arm_torque [N m]\n0,0,0,\n"),
                    "empty cells"));
  EXPECT_TRUE(
      holds(error("time [s],arm [rad],arm_velocity [rad/s],arm_torque [N m]\n1,0,0,0\n0,0,0,0\n"),
            "plan.csv:3"));
}

}  // namespace
}  // namespace jaculus::exporting
