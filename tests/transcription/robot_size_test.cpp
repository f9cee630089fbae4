// Problems in units of the robot, and the template that suits any.

#include "jaculus/transcription/robot_size.h"

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/dynamics/loop_closure.h"
#include "jaculus/transcription/derivative_check.h"
#include "support/input_error.h"
#include "transcription/example_problems.h"

namespace jaculus::transcription {
namespace {

using test::extended_problem;
using test::holds;
using test::input_error_of;

model::Robot shipped(const std::string& name) {
  return model::read_robot(model::find_robot(name, ""));
}

Vec2 foot_at(const model::PlanarModel& model, const std::map<std::string, double>& pose, int foot) {
  const dynamics::AbsoluteTree tree(model);
  Vector q = Vector::Zero(model.size());
  for (const auto& [name, value] : pose) q[model.coordinate_index(name)] = value;
  dynamics::Motion motion(tree);
  EXPECT_TRUE(dynamics::set_configuration(tree, q, motion));
  return position(tree.feet[foot], motion.pose);
}

TEST(RobotSize, OfASerialRobotByHand) {
  // thigh and shank of 0.2 m each, 25 kg; at rest thigh 0.7 rad forward, knee back by 1.4 rad
  const model::Robot robot = shipped("quadruped25");
  const RobotSize size = robot_size(robot);
  const double L = size.leg_length;
  EXPECT_NEAR(size.body_weight, robot.planar.total_mass() * 9.81, 1e-9);
  EXPECT_NEAR(size.leg_time, std::sqrt(L / 9.81), 1e-12);
  // the foot lies below the hip by L cos(0.7) where both links are L/2 long
  const double below = robot.planar.bodies[robot.planar.body_of_joint("rear_hip")].origin.y();
  EXPECT_NEAR(size.standing_height, L * std::cos(0.7) - below, 1e-9);
}

TEST(RobotSize, StretchedFeetStandBelowTheHipsAtOneHeight) {
  for (const char* name : {"quadruped25", "minitaur"}) {
    const model::Robot robot = shipped(name);
    const model::PlanarModel& model = robot.planar;
    const std::map<std::string, double> pose = stretched_coordinates(robot);
    const double L = robot_size(robot).leg_length;
    for (int f = 0; f < 2; ++f) {
      const Vec2 foot = foot_at(model, pose, f);
      int hip = model.feet[f].body;
      while (model.bodies[hip].parent > 0) hip = model.bodies[hip].parent;
      EXPECT_LT((foot - model.bodies[hip].origin - Vec2(0.0, -0.92 * L)).norm(), 1e-3 * L) << name;
    }
    for (const auto& [coordinate, value] : pose)
      EXPECT_TRUE(model.coordinates[model.coordinate_index(coordinate)].range.contains(value));
  }
}

TEST(RobotSize, KneesBendAsAtRest) {
  const auto knee = [](const std::map<std::string, double>& pose) { return pose.at("front_knee"); };
  const model::Robot robot = shipped("quadruped25");
  EXPECT_LT(knee(rest_coordinates(robot)), 0.0);
  EXPECT_LT(knee(stretched_coordinates(robot)), 0.0);
}

TEST(RobotSize, CoordinatesOfLegsFollowFromTheirMotors) {
  // 1 rad at both motors of a leg: extension 1, angle 0
  const auto pose = rest_coordinates(shipped("minitaur"));
  EXPECT_NEAR(pose.at("front_extension"), 1.0, 1e-12);
  EXPECT_NEAR(pose.at("rear_angle"), 0.0, 1e-12);
}

TEST(RobotSize, ARestPoseAtTheEndOfARangeIsWithinIt) {
  model::Robot robot = shipped("quadruped25");
  const int hip = robot.planar.coordinate_index("front_hip");
  for (int k = 1; k <= 30; ++k) {
    const double end = 0.1 * k;
    robot.rest_pose["front_hip"] = end;
    robot.planar.coordinates[hip].range = {end, end + 1.0};
    EXPECT_GE(rest_coordinates(robot).at("front_hip"), end);
    robot.planar.coordinates[hip].range = {end - 1.0, end};
    EXPECT_LE(rest_coordinates(robot).at("front_hip"), end);
  }
}

TEST(RobotSize, NumbersOfAProblemAreInUnitsOfItsOwnRobot) {
  const RobotSize big = robot_size(shipped("quadruped25")), small = robot_size(shipped("minitaur"));
  const Problem first = extended_problem("leap_template", "");
  const Problem second = extended_problem("leap_template", "robot: minitaur");
  EXPECT_NEAR(first.position_bounds.at("x").upper, 4.0 * big.leg_length, 1e-12);
  EXPECT_NEAR(second.position_bounds.at("x").upper, 4.0 * small.leg_length, 1e-12);
  EXPECT_NEAR(second.final.velocity.at("x").lower, 0.7 * std::sqrt(9.81 * small.leg_length), 1e-12);
  EXPECT_NEAR(*second.friction, 0.4, 1e-12);
  EXPECT_EQ(first.initial.position.count("front_hip"), 1u);
  EXPECT_EQ(second.initial.position.count("front_hip"), 0u);
  EXPECT_NEAR(second.initial.position.at("front_extension").lower, 1.0, 1e-12);
}

TEST(RobotSize, WhatIsNamedWinsOverThePose) {
  const Problem problem =
      extended_problem("leap_template", "initial: {position: {front_knee: -1.5}}");
  EXPECT_EQ(problem.initial.position.at("front_knee").lower, -1.5);
  EXPECT_NEAR(problem.initial.position.at("rear_knee").lower, -1.4, 1e-12);
}

TEST(RobotSize, LegsAtRestAreThoseThatMoveTheFoot) {
  EXPECT_EQ(leg_coordinates(shipped("quadruped25"), "front_foot"),
            (std::vector<std::string>{"front_hip", "front_knee"}));
  EXPECT_EQ(leg_coordinates(shipped("minitaur"), "front_foot"),
            (std::vector<std::string>{"front_extension", "front_angle"}));
  const Problem problem = extended_problem("leap_template", "final: {legs_at_rest: [front_foot]}");
  EXPECT_TRUE(problem.final.velocity.at("front_knee").fixed());
  EXPECT_EQ(problem.final.velocity.count("rear_knee"), 0u);
}

TEST(RobotSize, FaultsSayWhatIsAllowed) {
  EXPECT_TRUE(holds(input_error_of([] {
                      (void)extended_problem("leap_template",
                                             "limits: {friction: 0.5 flor_friction}");
                    }),
                    "unknown unit 'flor_friction', did you mean 'floor_friction'?"));
  EXPECT_TRUE(holds(
      input_error_of([] { (void)extended_problem("leap_template", "initial: {pose: crouched}"); }),
      "initial.pose: 'crouched' given; allowed: rest, stretched"));
  EXPECT_TRUE(holds(input_error_of([] {
                      (void)extended_problem("leap_template",
                                             "initial: {pose: rest}\nrobot: slider");
                    }),
                    "robot 'slider': no feet or no gravity"));
}

TEST(MotorLimits, HoldVoltageAndSpeedWhereAMotorHasThem) {
  const auto rows_of = [](const std::string& lines) {
    const Problem problem = extended_problem("leap_tail_as_published", lines);
    const NonlinearProgram program(problem, test::model_of(problem));
    int voltage = 0, speed = 0;
    for (const Interval& interval : program.intervals()) {
      for (const PathRows& path : interval.path) {
        for (const RowSpec& row : path.term->rows) {
          voltage += row.name.ends_with("voltage");
          speed += row.name == "tail speed";
        }
      }
    }
    return std::pair(voltage, speed);
  };
  const auto [voltage, none] = rows_of("");
  const std::string limits = "constraints: [{type: motor_limits}]\n";
  EXPECT_GT(voltage, 0);
  EXPECT_EQ(rows_of(limits), std::pair(2 * voltage, 0));  // beside the file's own voltage
  const auto [both, speed] = rows_of(limits + "override: {motors.tail.speed_limit: 100 rad/s}");
  EXPECT_EQ(both, 2 * voltage);
  EXPECT_EQ(speed, voltage / 5);  // one motor of five
}

/// Speed rows, torques at the joint and friction of the motors, in one small leap.
TEST(MotorLimits, DerivativesAreExactWithSpeedFrictionAndTorquesAtTheJoint) {
  Problem problem = extended_problem(
      "leap_tail",
      "override: {motors.*.speed_limit: 100 rad/s, motors.*.viscous_friction: 0.02}\n"
      "constraints: [{type: motor_limits}]\n"
      "objective: {maximise: [{type: mean_acceleration}], minimise: [{type: torque_squared, at: "
      "joint, per: 2 N m}]}\n");
  problem = test::on_grid(problem, {3, 2});
  NonlinearProgram program(problem, test::model_of(problem));
  const Vector x = random_point(program, initial_guess(program, problem.guess, 0), 0.03, 1);
  const DerivativeReport report = check_derivatives(program, x);
  ASSERT_TRUE(report.defined);
  // as for the terms of the catalogue
  EXPECT_LT(report.gradient.error, 1e-6) << report.gradient.column;
  EXPECT_LT(report.jacobian.error, 1e-6) << report.jacobian.row << report.jacobian.column;
  EXPECT_LT(report.hessian.error, 1e-6) << report.hessian.row << report.hessian.column;
}

/// The tail's gear of 4 at an efficiency of 0.8: its torque counts 1 / (3.2)^2 before the gear.
TEST(MotorLimits, TorquesCountBeforeTheGearOrAtTheJoint) {
  const auto cost_of = [](const std::string& keys) {
    Problem problem =
        extended_problem("leap_tail",
                         "objective: {maximise: [{type: mean_acceleration}], minimise: [{type: "
                         "torque_squared" +
                             keys + "}]}");
    problem = test::on_grid(problem, {3, 2});
    NonlinearProgram program(problem, test::model_of(problem));
    Vector x = initial_guess(program, problem.guess, 0);
    const Layout& layout = program.layout();
    double values[2];
    for (const double torque : {0.0, 3.2}) {  // of the tail alone
      for (const IntervalBlock& interval : layout.intervals) {
        x.segment(interval.u_first, layout.n_u).setZero();
        x[interval.u_first + layout.n_u - 1] = torque;
      }
      EXPECT_TRUE(program.objective(x, values[torque > 0.0 ? 1 : 0]));
    }
    return values[1] - values[0];
  };
  const double before = cost_of(""), at_joint = cost_of(", at: joint");
  EXPECT_NEAR(at_joint, before * 3.2 * 3.2, 1e-9 * at_joint);
  EXPECT_NEAR(cost_of(", at: joint, per: 2 N m"), at_joint / 4.0, 1e-9 * at_joint);
}

}  // namespace
}  // namespace jaculus::transcription
