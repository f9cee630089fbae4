// What the controller does once its plan is over: hold, relax, repeat, or go into a pose to land
// in. The torque is read off at instants of a run and held against the formula in controller.h.

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/simulation/experiment.h"
#include "simulation/support.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::simulation {
namespace {

using namespace test;

constexpr double kEnd = 0.1, kLast = 0.6, kLastRate = 4.0, kLastTorque = 0.3, kKp = 6.0, kKd = 0.2;
constexpr double kPose = -0.2, kWithin = 0.08;

/// A link of 0.01 kg m^2 on an ideal motor, without gravity; its plan ends at kLast with kLastRate.
model::PlanarModel link_on_motor() {
  model::PlanarModel model =
      test_support::on_fixed_base({link("arm", 0, Vec2::Zero(), 1.0, Vec2::Zero(), 0.01)}, {"arm"});
  model.gravity = 0.0;
  model::PlanarMotor motor;
  motor.joint = "arm";
  motor.body = 1;
  motor.voltage = kInfinity;
  model.motors = {motor};
  return model;
}

Simulation play(AfterEnd after_end, double rate_hz, const std::vector<double>& times) {
  Controller c;
  c.rate_hz = rate_hz;
  c.kp = Vector::Constant(1, kKp);
  c.kd = Vector::Constant(1, kKd);
  c.after_end = after_end;
  c.landing_pose = Vector::Constant(1, kPose);
  c.landing_time = kWithin;
  Reference& r = c.reference;
  r.motors = {"arm"};
  r.time = (Vector(2) << 0.0, kEnd).finished();
  r.duration = kEnd;
  r.position = (Matrix(1, 2) << 0.0, kLast).finished();
  r.velocity = Matrix::Constant(1, 2, kLastRate);
  r.feedforward = Matrix::Constant(1, 2, kLastTorque);
  SimulationOptions options = options_for(times.back());
  options.sample_times = Eigen::Map<const Vector>(times.data(), times.size());
  const Simulation s = simulate(plant_of(link_on_motor(), 0.0), c, start_at({0}, {0}), options);
  EXPECT_EQ(s.status, SimulationStatus::done) << s.message;
  return s;
}

/// Torque of feed-forward and PD towards a reference at sample k.
double wanted(const Simulation& s, Eigen::Index k, double feedforward, double position,
              double rate) {
  return feedforward + kKp * (position - s.motor_position(0, k)) +
         kKd * (rate - s.motor_velocity(0, k));
}

/// The cubic from the plan's end to the pose: position and rate.
std::pair<double, double> landing(double time) {
  const double s = std::min(1.0, (time - kEnd) / kWithin), c = 1.0 - s;
  return {
      (1 + 2 * s) * c * c * kLast + s * c * c * kWithin * kLastRate + s * s * (3 - 2 * s) * kPose,
      (6 * s * c * (kPose - kLast)) / kWithin + c * (1 - 3 * s) * kLastRate};
}

TEST(AfterEnd, HoldRelaxAndRepeatFollowTheirFormulas) {
  const std::vector<double> times = {0.1001, 0.12, 0.15};
  const Simulation hold = play(AfterEnd::hold, kInfinity, times),
                   relax = play(AfterEnd::relax, kInfinity, times),
                   repeat = play(AfterEnd::repeat, kInfinity, times);
  for (Eigen::Index k = 0; k < 3; ++k) {
    EXPECT_NEAR(hold.torque(0, k), wanted(hold, k, 0.0, kLast, 0.0), 1e-12);
    EXPECT_EQ(relax.torque(0, k), 0.0);
    EXPECT_NEAR(repeat.torque(0, k), wanted(repeat, k, kLastTorque, kLast, 0.0), 1e-12);
  }
}

TEST(AfterEnd, PoseIsReachedOnACubicAndKept) {
  const std::vector<double> times = {0.1001, 0.12, 0.14, 0.1799, 0.19, 1.5};
  const Simulation s = play(AfterEnd::pose, kInfinity, times);
  for (Eigen::Index k = 0; k < s.time.size(); ++k) {
    const auto [position, rate] = landing(s.time[k]);
    EXPECT_NEAR(s.torque(0, k), wanted(s, k, 0.0, position, rate), 1e-12) << s.time[k];
  }
  const auto [start, start_rate] = landing(kEnd);
  EXPECT_NEAR(start, kLast, 1e-15);  // neither position nor rate jumps at the plan's end
  EXPECT_NEAR(start_rate, kLastRate, 1e-12);
  EXPECT_NEAR(s.motor_position(0, 5), kPose, 1e-5);
  EXPECT_NEAR(s.motor_velocity(0, 5), 0.0, 1e-4);
}

TEST(AfterEnd, SampledPoseHoldsTheCommandOfItsInstant) {
  const Simulation s = play(AfterEnd::pose, 1000.0, {0.130, 0.1305, 0.1309});
  const auto [position, rate] = landing(0.130);
  const double command = wanted(s, 0, 0.0, position, rate);
  for (Eigen::Index k = 0; k < 3; ++k) EXPECT_NEAR(s.torque(0, k), command, 1e-9);
}

// From YAML
// -------------------------------------------------------------------------------------------------

constexpr const char* kExperiment = R"(format: jaculus-experiment/1
name: landing
experiment: leap
robot: minitaur
plan: plan.csv
controller:
  kind: KIND
  rate_hz: 1000
GAINS
  after_end: END
)";

struct Written {
  Written(const std::string& kind, const std::string& gains, const std::string& end) {
    std::string plan = "time [s]", rows[2] = {"0", "0.2"};
    for (const std::string joint : {"front_a", "front_b", "rear_a", "rear_b"}) {
      plan += "," + joint + " [rad]," + joint + "_velocity [rad/s]," + joint + "_torque [N m]," +
              joint + "_voltage [V]";
      for (std::string& row : rows) row += ",1,0,0.1,1";
    }
    folder.write("plan.csv", plan + "\n" + rows[0] + "\n" + rows[1] + "\n");
    std::string text = kExperiment;
    for (const auto& [what, by] :
         {std::pair("KIND", kind), std::pair("GAINS", gains), std::pair("END", end)})
      text.replace(text.find(what), std::string(what).size(), by);
    folder.write("experiment.yaml", text);
  }
  TemporaryFolder folder;
};

TEST(AfterEnd, PoseComesFromYamlAndGoesIntoTheDataset) {
  const Written written("feedforward_pd", "  kp: 3\n  kd: 0.1",
                        "{pose: {\"*\": 60 deg, rear_b: 0.5}, within: 40 ms}");
  Experiment experiment = read_experiment(written.folder / "experiment.yaml");
  const model::PlanarModel model = dataset_robot(experiment.setup).planar;
  const Controller controller = experiment_controller(experiment, model);
  ASSERT_EQ(controller.after_end, AfterEnd::pose);
  EXPECT_EQ(controller.landing_time, 0.04);
  for (Eigen::Index m = 0; m < controller.landing_pose.size(); ++m)
    EXPECT_NEAR(controller.landing_pose[m],
                controller.reference.motors[m] == "rear_b" ? 0.5 : 1.0471975511965976, 1e-15);
  trajectory::Dataset dataset = experiment.setup;
  dataset.robot = (source_folder() / "models" / "minitaur").string();
  dataset.trials.push_back(
      run_trial(experiment, dataset_plant(dataset, model), controller, 0, 1).trial);
  trajectory::write_dataset(dataset, written.folder / "out");
  const trajectory::StatedController back =
      trajectory::read_dataset(written.folder / "out").controller;
  EXPECT_EQ(back.after_end, AfterEnd::pose);
  EXPECT_EQ(back.landing_pose, experiment.setup.controller.landing_pose);
  EXPECT_EQ(back.landing_time, 0.04);
}

TEST(AfterEnd, BadPosesNameThePlace) {
  const auto fault = [](const std::string& end, const std::string& kind = "feedforward_pd",
                        const std::string& gains = "  kp: 3\n  kd: 0.1") {
    const Written written(kind, gains, end);
    const std::string message =
        input_error_of([&] { (void)read_experiment(written.folder / "experiment.yaml"); });
    EXPECT_TRUE(holds(message, "experiment.yaml:" + std::string(gains.empty() ? "10" : "11") +
                                   ": controller.after_end"));
    return message;
  };
  EXPECT_TRUE(holds(fault("land"), "allowed"));
  EXPECT_TRUE(holds(fault("{pose: {\"*\": 1}}"), "within"));
  EXPECT_TRUE(holds(fault("{pose: {\"*\": 1}, within: 0}"), "0"));
  EXPECT_TRUE(holds(fault("{pose: {\"*\": 1}, within: 1 V}"), "V"));
  EXPECT_TRUE(holds(fault("{pose: {}, within: 1 s}"), "no joint given"));
  EXPECT_TRUE(holds(fault("{pose: {\"*\": 1, rear_c: 1}, within: 1 s}"), "did it mean 'rear_"));
  EXPECT_TRUE(holds(fault("{pose: {rear_b: 1}, within: 1 s}"), "nothing for 'front_a'"));
  EXPECT_TRUE(holds(fault("{poses: {\"*\": 1}, within: 1 s}"), "did you mean 'pose'"));
  EXPECT_TRUE(holds(fault("{pose: {\"*\": 1}, within: 1 s}", "voltage", ""), "no feedback"));
}

}  // namespace
}  // namespace jaculus::simulation
