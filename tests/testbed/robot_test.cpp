// The robot itself: what its own static and swept tests show, datasets it writes, and what it
// refuses.

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/core/installation.h"
#include "jaculus/testbed/effects.h"
#include "jaculus/testbed/trials.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"
#include "testbed/drives.h"
#include "testbed/mjcf.h"
#include "testbed/static_tests.h"

namespace jaculus::testbed {
namespace {

using test::holds;
using test::input_error_of;

const std::filesystem::path kRobot = source_folder() / "models" / "minitaur_tail";

double measured(const std::string& name, double value) {
  const auto effects = bench_effects(kRobot);
  const BenchEffect& effect = *find_bench_effect(effects, name);
  std::vector<double> values;
  for (const BenchParameter& p : effect.parameters) values.push_back(p.usual);
  values[0] = value;
  Changes changes;
  effect.apply(values, changes);
  return measured_parameters(name, values, read_robot_files(kRobot), changes)[0];
}

TEST(StaticTests, ShowTheStrengthThatWasBuilt) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  EXPECT_NEAR(measured("tail_compliance", 0.01), 0.01, 0.01 * 0.01);
  EXPECT_NEAR(measured("tail_compliance", 0.002), 0.002, 0.01 * 0.002);
  EXPECT_NEAR(measured("tail_backlash", 0.02), 0.02, 0.03 * 0.02);
  EXPECT_NEAR(measured("tail_stop_restitution", 0.5), 0.5, 0.05);
  EXPECT_NEAR(measured("tail_stop_restitution", 0.0), 0.0, 0.05);
  EXPECT_NEAR(measured("ground_compliance", 1e-4), 1e-4, 1e-7);
}

TEST(Stop, RestitutionOfTheDampedOscillatorHasItsKnownValues) {
  EXPECT_NEAR(restitution_of_damping_ratio(1.0), std::exp(-2.0), 1e-9);
  EXPECT_NEAR(restitution_of_damping_ratio(1e-6), 1.0, 1e-5);
  EXPECT_NEAR(restitution_of_damping_ratio(1.001), restitution_of_damping_ratio(0.999), 1e-3);
  for (const double e : {0.05, 0.2, 0.5, 0.9}) {
    EXPECT_NEAR(restitution_of_damping_ratio(damping_ratio_of_restitution(e)), e, 1e-9);
  }
}

TEST(Drives, TheCubicIsInvertedAndTheBatterySagsByThePowerDrawn) {
  const RobotFiles files = read_robot_files(kRobot);
  const model::PlanarMotor& motor = files.drives.front().motor;
  for (const double torque : {-3.0, -0.1, 0.0, 1.0, 2.9}) {
    EXPECT_NEAR(torque_of_current(motor, current_of_torque(motor, torque)), torque, 1e-12);
  }
  Changes changes;
  changes.battery_resistance = 0.05;
  const Drives drives(files, changes, trajectory::Quantity::duty);
  std::vector<DriveState> states;
  const std::vector<double> commands(files.drives.size(), 0.3), rates(files.drives.size(), 5.0);
  const double bus = drives.run(commands, rates, states);
  double power = 0.0;
  for (const DriveState& state : states) power += state.voltage * state.current;
  EXPECT_GT(power, 100.0);
  EXPECT_NEAR(bus, motor.voltage - 0.05 * power / bus, 1e-8);
}

TEST(Trials, AreRobotsLogs) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  TrialSpec spec;
  spec.trials = 2;
  spec.seed = 7;
  trajectory::Dataset dataset = run_trials(self_righting(kRobot), {}, spec);
  const test::TemporaryFolder folder;
  trajectory::write_dataset(dataset, folder / "drop");
  const trajectory::Dataset back = trajectory::read_dataset(folder / "drop");
  ASSERT_EQ(back.trials.size(), 2U);
  const trajectory::Stream& mocap = *back.trials[0].stream("mocap");
  EXPECT_EQ(mocap.channels, (std::vector<std::string>{"x", "z", "pitch"}));
  EXPECT_NEAR(mocap.values(1, 0), 1.0, 5e-3);
  EXPECT_LT(mocap.values(2, mocap.values.cols() - 1), -1.0)
      << "the body has turned nose-up against the tail";
  EXPECT_GE(back.trials[0].stream("joints")->channel("tail_velocity"), 0);
  const trajectory::Dataset again = run_trials(self_righting(kRobot), {}, spec);
  EXPECT_EQ(again.trials[1].streams[0].values, dataset.trials[1].streams[0].values)
      << "same seed, same trial";
  EXPECT_NE(dataset.trials[0].streams[0].values(0, 5), dataset.trials[1].streams[0].values(0, 5));
}

TEST(Trials, NoiseHasTheFloorThatIsStated) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  TrialSpec spec;
  spec.trials = 1;
  spec.pose_scatter = spec.clock_scatter = 0.0;
  TrialSpec exact = spec;
  exact.exact = true;
  const trajectory::Dataset asked = tail_bench(kRobot);
  trajectory::Dataset noisy = run_trials(asked, {}, spec), still = run_trials(asked, {}, exact);
  const trajectory::Stream &a = *noisy.trials[0].stream("joints"),
                           &b = *still.trials[0].stream("joints");
  // The phases of sampling differ, so noise is told by second differences, of which white noise has
  // six times the variance.
  const auto row = a.channel("tail_velocity");
  const Eigen::Index n = std::min(a.values.cols(), b.values.cols());
  double sum = 0.0;
  for (Eigen::Index k = 1; k + 1 < n; ++k) {
    const double d = a.values(row, k + 1) - 2.0 * a.values(row, k) + a.values(row, k - 1) -
                     (b.values(row, k + 1) - 2.0 * b.values(row, k) + b.values(row, k - 1));
    sum += d * d;
  }
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(n - 2) / 6.0), spec.sensors.tachometer,
              0.1 * spec.sensors.tachometer);
}

TEST(Effects, RefuseWhatTheyAreNot) {
  Changes changes;
  const auto known = bench_effects(kRobot);
  EXPECT_TRUE(holds(
      input_error_of([&] { apply_effect("tail_complience:compliance=0.01", known, changes); }),
      "tail_compliance"));
  EXPECT_TRUE(holds(input_error_of([&] { apply_effect("wind:sped=1", known, changes); }),
                    "did you mean 'speed'"));
  EXPECT_TRUE(holds(input_error_of([&] { apply_effect("wind:speed=1e9", known, changes); }),
                    "from -4 to 4"));
  EXPECT_TRUE(holds(input_error_of([&] { apply_effect("wind:speed=abc", known, changes); }),
                    "'abc' given"));
  EXPECT_TRUE(holds(input_error_of([&] { apply_effect("wind", known, changes); }), "no value"));
  EXPECT_TRUE(holds(input_error_of([&] { apply_effect("wind:speed=1,speed=2", known, changes); }),
                    "twice"));
  apply_effect("wind:speed=1.5", known, changes);
  EXPECT_EQ(changes.wind, 1.5);
}

TEST(Effects, AtTheirUsualValuesChangeNothing) {
  if (!available()) GTEST_SKIP() << "built without MuJoCo";
  const RobotFiles files = read_robot_files(kRobot);
  const std::string plain = mjcf(files, {}, {}, {});
  for (const BenchEffect& effect : bench_effects(kRobot)) {
    std::vector<double> values;
    for (const BenchParameter& p : effect.parameters) values.push_back(p.usual);
    Changes changes;
    effect.apply(values, changes);
    EXPECT_EQ(mjcf(files, changes, {}, {}), plain) << effect.name;
  }
}

}  // namespace
}  // namespace jaculus::testbed
