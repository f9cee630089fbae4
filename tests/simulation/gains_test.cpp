// Gains that are stated at the joint: what they are at the motor, from YAML and back.

#include <gtest/gtest.h>

#include <Eigen/Core>

#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/simulation/experiment.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::simulation {
namespace {

using namespace test;

/// The arm, of gears 15, 12 and 10, held by `controller`'s keys.
Experiment held_arm(const std::string& controller) {
  const TemporaryFolder folder;
  folder.write(
      "plan.csv",
      "time [s],shoulder [rad],elbow [rad],wrist [rad],shoulder_velocity [rad/s],"
      "elbow_velocity [rad/s],wrist_velocity [rad/s],shoulder_torque [N m],elbow_torque [N m],"
      "wrist_torque [N m]\n0,2.1,0.6,0.3,0,0,0,0,0,0\n0.1,2.1,0.6,0.3,0,0,0,0,0,0\n");
  folder.write("held.yaml",
               "format: jaculus-experiment/1\nname: held\nexperiment: pendulum\nrobot: arm\n"
               "plan: plan.csv\ncontroller: {kind: feedforward_pd, rate_hz: 1000, " +
                   controller + "}\n");
  return read_experiment(folder / "held.yaml");
}

TEST(GainsAtJoints, AreThoseAtMotorsTimesTheGearSquared) {
  const Experiment experiment =
      held_arm("quantity: torque, kp: {\"*\": 900, wrist: 50}, kd: 36, gains_at: joint");
  const Controller controller =
      experiment_controller(experiment, dataset_robot(experiment.setup).planar);
  const std::vector<std::string> motors = {"shoulder", "elbow", "wrist"};
  ASSERT_EQ(controller.reference.motors, motors);
  EXPECT_TRUE(
      controller.kp.isApprox(Eigen::Vector3d(900.0 / 225.0, 900.0 / 144.0, 50.0 / 100.0), 1e-15));
  EXPECT_TRUE(
      controller.kd.isApprox(Eigen::Vector3d(36.0 / 225.0, 36.0 / 144.0, 36.0 / 100.0), 1e-15));
}

TEST(GainsAtJoints, HoldTheSameWhateverTheGear) {
  const auto sag = [](const std::string& gear) {
    const Experiment experiment = held_arm(
        "quantity: torque, kp: 900, kd: 36, gains_at: joint}\n"
        "override: {motors.shoulder.gear: " +
        gear);
    const model::PlanarModel model = dataset_robot(experiment.setup).planar;
    const Plant plant = dataset_plant(experiment.setup, model);
    const TrialRun run =
        run_trial(experiment, plant, experiment_controller(experiment, model), 0, 1);
    return run.truth.q(0, run.truth.q.cols() - 1) - 2.1;
  };
  const double sagged = sag("15");
  EXPECT_GT(std::abs(sagged), 1e-4);
  EXPECT_NEAR(sag("7.5"), sagged, 0.1 * std::abs(sagged));  // the rotor's inertia differs
}

TEST(GainsAtJoints, RangesAndUnknownOnesAreTurnedToo) {
  trajectory::StatedController controller;
  controller.gains_at_joint = true;
  controller.kp["*"].range = {90.0, 180.0};
  controller.kd["shoulder"].range = {0.0, kInfinity};
  put_gains_at_motors(model::read_robot(model::find_robot("arm", ".")).planar, controller);
  EXPECT_FALSE(controller.gains_at_joint);
  EXPECT_EQ(controller.kp.at("wrist").range.lower, 0.9);
  EXPECT_EQ(controller.kp.at("wrist").range.upper, 1.8);
  EXPECT_EQ(controller.kd.at("shoulder").range.upper, kInfinity);
  EXPECT_EQ(controller.kp.count("*"), 0u);
}

TEST(GainsAtJoints, OfAnythingButTorqueAreRefused) {
  const std::string message =
      input_error_of([] { (void)held_arm("quantity: duty, kp: 1, kd: 0, gains_at: joint"); });
  EXPECT_NE(message.find("held.yaml:6: controller.gains_at: joint given with gains that are no "
                         "torque; allowed: motor"),
            std::string::npos)
      << message;
}

}  // namespace
}  // namespace jaculus::simulation
