// Known answers of what is wrong at a joint, on its mount or with its commands.

#include "testbed/joint_laws.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "jaculus/core/installation.h"
#include "jaculus/testbed/effects.h"
#include "jaculus/testbed/playback.h"
#include "jaculus/testbed/trials.h"
#include "testbed/mjcf.h"

namespace jaculus::testbed {
namespace {

constexpr double kPi = std::numbers::pi;

RobotFiles robot_of(const std::string& name) {
  return read_robot_files(source_folder() / "models" / name);
}

/// The slider, 1 kg without friction and 1 N at most, under a force that holds for `duration` [s].
Recording slide(const Changes& changes, double force, double duration) {
  Commands commands;
  commands.motors = {"slide"};
  commands.time = Vector::LinSpaced(2, 0.0, duration);
  commands.feedforward = Matrix::Constant(1, 2, force);
  commands.repeat_after_end = true;
  PlayOptions options;
  options.duration = duration;
  options.floor = false;
  return play(robot_of("slider"), changes, commands, options, Numerics{});
}

double last(const Matrix& row) { return row(0, row.cols() - 1); }

TEST(Push, GivesTheMomentumOfItsHalfSine) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const auto effects = bench_effects(robot_of("slider"));
  const BenchEffect* push = find_bench_effect(effects, "joint_push@slide");
  ASSERT_NE(push, nullptr);
  EXPECT_TRUE(push->event && push->outside);
  EXPECT_EQ(push->joint, "slide");
  EXPECT_EQ(push->parameters.front().unit, "N");

  for (const double peak : {0.8, -0.5}) {
    Changes changes;
    push->apply({peak, 0.1, 0.2}, changes);
    const Recording run = slide(changes, 0.0, 0.5);
    EXPECT_NEAR(last(run.velocity), 2.0 / kPi * peak * 0.2, 1e-6) << "of 1 kg";
    EXPECT_EQ(sample(run.time, run.velocity.row(0), Vector::Constant(1, 0.099))[0], 0.0)
        << "nothing before it starts";
  }
}

TEST(Push, TurnsAPendulumByItsImpulse) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const RobotFiles files = robot_of("pendulum");
  Changes changes;
  find_bench_effect(bench_effects(files), "joint_push@swing")->apply({0.3, 0.0, 0.05}, changes);
  Commands commands;
  commands.motors = {"swing"};
  commands.time = Vector::LinSpaced(2, 0.0, 0.1);
  commands.feedforward = Matrix::Zero(1, 2);
  PlayOptions options;
  options.duration = 0.05;
  const Recording run = play(files, changes, commands, options, Numerics{});

  // 1 kg at 1 m; gravity takes back less than 9.81 N m times a quarter of the turn so far
  const double impulse = 2.0 / kPi * 0.3 * 0.05;
  EXPECT_NEAR(last(run.velocity), impulse, 0.015 * impulse);
  EXPECT_LT(last(run.velocity), impulse);
}

TEST(Hysteresis, LosesTheAreaOfItsLoop) {
  // Dahl's law between -A and A, once it repeats itself: z turns at Fc tanh(A/w), and a cycle takes
  // 4 Fc (A - w tanh(A/w)).
  const RobotFiles files = robot_of("pendulum");
  const Drive& drive = files.drives.front();
  const JointSize size = size_of(files, drive);
  JointDisturbances o;
  o.hysteresis = 0.2;
  o.hysteresis_width = 0.3;
  const double force = 0.2 * size.torque, amplitude = 0.25;

  constexpr int kSteps = 4000;
  JointMemory memory;
  double work = 0.0;
  for (int cycle = 0; cycle < 6; ++cycle) {
    work = 0.0;
    double before = amplitude * std::sin(0.0);
    for (int k = 1; k <= kSteps; ++k) {
      const double angle = amplitude * std::sin(2.0 * kPi * k / kSteps);
      const double torque = torque_of_laws(o, size, drive, memory, {0.5 * (before + angle)});
      work -= torque * (angle - before);
      memory = moved(o, size, memory, angle);
      before = angle;
    }
  }
  const double loop = 4.0 * force * (amplitude - 0.3 * std::tanh(amplitude / 0.3));
  EXPECT_NEAR(work, loop, 1e-4 * loop);
}

TEST(Grease, TakesAForceTimesItsTravelUntilItIsLoose) {
  const RobotFiles files = robot_of("pendulum");
  const Drive& drive = files.drives.front();
  const JointSize size = size_of(files, drive);
  JointDisturbances o;
  o.grease = 0.1;
  o.grease_travel = 0.3;
  JointMemory memory;
  double work = 0.0;
  constexpr double kStep = 1e-4;
  for (int k = 0; k < 50000; ++k) {  // there and back, 5 rad in all
    work += friction_of_laws(o, size, drive, memory) * kStep;
    memory = moved(o, size, memory, memory.last + (k / 1000 % 2 == 0 ? kStep : -kStep));
  }
  EXPECT_NEAR(work, 0.1 * size.torque * 0.3, 1e-3 * work);
}

/// Work of a law from one angle to another, slowly [N m].
double work_of(const JointDisturbances& o, const RobotFiles& files, double from, double to) {
  constexpr int kSteps = 20000;
  const Drive& drive = files.drives.front();
  const double step = (to - from) / kSteps;
  double work = 0.0;
  for (int k = 0; k < kSteps; ++k)
    work += torque_of_laws(o, size_of(files, drive), drive, {}, {from + (k + 0.5) * step}) * step;
  return work;
}

TEST(Springs, HoldTheEnergyOfTheirLaws) {
  const RobotFiles files = robot_of("pendulum");
  const double torque = size_of(files, files.drives.front()).torque;
  JointDisturbances cable, detent;
  cable.cable = -0.5;
  cable.cable_slack = 0.05;
  EXPECT_EQ(work_of(cable, files, 0.0, 1.0), 0.0) << "it is on the other side";
  const double stretched = 0.5 * torque * std::pow(0.2, 3) / (3.0 * 0.3 * 0.3);
  EXPECT_NEAR(work_of(cable, files, 0.0, -0.25), -stretched, 1e-6 * stretched);

  detent.detent = 0.4;
  detent.detent_place = 0.1;
  const double depth = 0.4 * torque * 0.1 * std::exp(0.5);
  EXPECT_NEAR(work_of(detent, files, 0.1, 1.5), -depth, 1e-6 * depth) << "out of the well";
  EXPECT_NEAR(work_of(detent, files, -1.3, 0.1), depth, 1e-6 * depth) << "into it";
}

TEST(SoftStop, PushesBackOnlyAndMoreOnTheWayIn) {
  const RobotFiles files = robot_of("pendulum");
  const Drive& drive = files.drives.front();
  const JointSize size = size_of(files, drive);
  JointDisturbances o;
  o.stop = 10.0;
  o.stop_place = 0.1;
  const auto push = [&](double angle, double rate) {
    return torque_of_laws(o, size, drive, {}, {angle, rate});
  };
  EXPECT_EQ(push(0.05, 3.0), 0.0);
  EXPECT_NEAR(push(0.12, 0.0), -0.2 * size.torque, 1e-12);
  EXPECT_LT(push(0.12, 1.0), push(0.12, 0.0));
  EXPECT_EQ(push(0.12, -50.0), 0.0) << "it doesn't pull";
}

TEST(Magnets, SaturateOverTheTorqueThatIsLogged) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  Changes changes;
  changes.outside.joints.saturation = 0.5;
  const Recording run = slide(changes, 0.8, 0.5);
  EXPECT_EQ(last(run.torque), 0.8) << "by the current";
  // from rest under one force: v = F t
  EXPECT_NEAR(last(run.velocity), 0.8 / (1.0 + 0.5 * 0.8 * 0.8) * 0.5, 1e-9);
}

TEST(CommandSlew, TakesItsTimeToTheFullCommand) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  Changes changes;
  changes.outside.commands.slew_time = 0.2;
  const Recording run = slide(changes, 1.0, 0.4);
  const Vector torque = sample(run.time, run.torque.row(0), Vector::LinSpaced(3, 0.0505, 0.2505));
  EXPECT_NEAR(torque[0], 0.0505 / 0.2, 1e-2);
  EXPECT_NEAR(torque[1], 0.1505 / 0.2, 1e-2);
  EXPECT_EQ(torque[2], 1.0);
}

TEST(ShakingSupport, MovesWhatSlidesFreelyOnIt) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  Changes changes;
  changes.outside.shaking = 2.0;
  changes.outside.shaking_frequency = 3.0;
  const Recording run = slide(changes, 0.0, 0.4);
  const double w = 2.0 * kPi * 3.0;
  EXPECT_NEAR(last(run.velocity), -2.0 / w * (1.0 - std::cos(w * 0.4)), 1e-6);
}

TEST(CompliantMount, SwaysAtItsFrequency) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  // What slides is free, so the mount, 1 kg, sways alone: 20 rad/s, damped by c = 0.1 sqrt(2 k).
  Changes changes;
  changes.outside.mount_compliance = 1.0 / 400.0;
  changes.outside.joint_push["slide"] = {1.0, 0.0, 0.05};
  const Recording run = slide(changes, 0.0, 1.5);
  std::vector<double> crests;
  for (Eigen::Index k = 400; k + 1 < run.time.size(); ++k) {
    const auto v = [&](Eigen::Index i) { return run.velocity(0, i); };
    if (v(k) > v(k - 1) && v(k) >= v(k + 1)) crests.push_back(run.time[k]);
  }
  ASSERT_GE(crests.size(), 3U);
  const double damping = 0.1 * std::sqrt(2.0) / 2.0;
  const double period = 2.0 * kPi / (20.0 * std::sqrt(1.0 - damping * damping));
  EXPECT_NEAR((crests.back() - crests.front()) / static_cast<double>(crests.size() - 1), period,
              2e-3 * period);
}

TEST(EncoderRunout, IsRightAtZeroAndNoFurtherOffThanTwice) {
  const RobotFiles files = robot_of("pendulum");
  const JointSize size = size_of(files, files.drives.front());
  JointDisturbances o;
  o.encoder_runout = 0.05;
  o.encoder_phase = 0.7;
  EXPECT_EQ(misreading(o, size, 0.0), 0.0);
  double most = 0.0;
  for (double q = -kPi; q < kPi; q += 0.01) {
    most = std::max(most, std::abs(misreading(o, size, q)));
    const double slope = (misreading(o, size, q + 1e-6) - misreading(o, size, q - 1e-6)) / 2e-6;
    EXPECT_NEAR(misreading_rate(o, size, q), slope, 1e-8);
  }
  EXPECT_NEAR(most, 0.05 * (1.0 + std::sin(0.7)), 1e-5);
}

}  // namespace
}  // namespace jaculus::testbed
