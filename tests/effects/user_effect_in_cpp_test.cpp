// Effects that users write beside the same in C++.

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/core/installation.h"
#include "jaculus/effects/select.h"
#include "jaculus/effects/user_effect.h"
#include "jaculus/model/robot.h"
#include "jaculus/simulation/experiment.h"
#include "support/lugre.h"
#include "support/temporary_folder.h"

namespace jaculus::effects {
namespace {

using simulation::ActionKind;
using simulation::LawFunctions;
using simulation::Plant;
using simulation::ReadingKind;

/// A trial of pendulum_trials on plants with one of two effects.
struct Trial {
  simulation::Experiment experiment =
      simulation::read_experiment(source_folder() / "problems" / "pendulum_trials.yaml");
  model::PlanarModel model = simulation::dataset_robot(experiment.setup).planar;
  Plant plant = simulation::dataset_plant(experiment.setup, model);

  [[nodiscard]] simulation::Simulation run(const Plant& own) const {
    const simulation::Controller controller = simulation::experiment_controller(experiment, model);
    return simulation::run_trial(experiment, own, controller, 0, 1).truth;
  }
};

/// What a file does beside what C++ does: the same to 1e-9.
void expect_alike(const Trial& trial, const Plant& by_file, const Plant& in_cpp) {
  const simulation::Simulation a = trial.run(by_file), b = trial.run(in_cpp);
  ASSERT_EQ(a.status, simulation::SimulationStatus::done) << a.message;
  ASSERT_EQ(a.q.cols(), b.q.cols());
  EXPECT_LT((a.q - b.q).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((a.v - b.v).cwiseAbs().maxCoeff(), 1e-9);
  const simulation::Simulation without = trial.run(trial.plant);
  EXPECT_GT((a.q - without.q).cwiseAbs().maxCoeff(), 0.1) << "the friction does nothing";
}

TEST(UserEffect, LuGreDoesWhatItDoesInCpp) {
  const UserEffect user = read_user_effect(source_folder() / "effects" / "lugre.yaml");
  const Trial trial;
  Vector theta = user.effect.probed();
  theta[3] = 0.01;
  Plant by_file = trial.plant, in_cpp = trial.plant;
  user.effect.apply(theta, by_file);
  in_cpp.laws = {test::lugre("pendulum", theta)};
  expect_alike(trial, by_file, in_cpp);
}

TEST(UserEffect, DryFrictionDoesWhatTheCataloguesDoes) {
  const test::TemporaryFolder folder;
  const UserEffect user = read_user_effect(folder.write("dry.yaml", R"yaml(format: jaculus-effect/1
name: dry
caption: dry friction
at: {group: other}
parameters: {level: {unit: N m, nominal: 0, bounds: [0, 3], scale: 0.3}}
constants: {rest: {unit: rad/s, value: 0.1}}
torque: "-level*tanh(qd/rest)"
)yaml"));
  const Trial trial;
  Plant by_file = trial.plant, in_cpp = trial.plant;
  user.effect.apply(Vector::Constant(1, 0.2), by_file);
  find_effect("joint_coulomb_friction")->apply(Vector::Constant(1, 0.2), in_cpp);
  for (simulation::JointFriction& friction : in_cpp.friction) friction.smoothing_rate = 0.1;
  expect_alike(trial, by_file, in_cpp);
}

/// Friction of bam/model.py's M6 with mx106/m6.json: its loss and damping, for a joint that moves.
double bam_m6(double motor, double external, double rate) {
  const double stribeck = std::exp(-std::pow(std::abs(rate / 1.746), 1.143));
  double loss = 1.02e-5 + std::abs(external * 0.0222 - motor * 0.198);
  loss += stribeck * 0.122 + std::abs(external * 0.0871 - motor * 0.1986) * stribeck;
  if ((external < 0.0) != (motor < 0.0)) {
    const double quadratic = std::abs(external) < std::abs(motor)   ? 7.33e-5 * external * external
                             : std::abs(external) > std::abs(motor) ? 0.01 * motor * motor
                                                                    : 0.0;
    loss += stribeck * quadratic;
  }
  return loss + 0.0507 * std::abs(rate);
}

TEST(UserEffect, M6IsBamsFormula) {
  const UserEffect user = read_user_effect(source_folder() / "effects" / "bam_m6.yaml");
  Plant plant = simulation::nominal_plant(
      model::read_robot(source_folder() / "models" / "ak80_pendulum").planar);
  Vector theta = user.effect.nominal();
  theta[0] = 1.0;
  user.effect.apply(theta, plant);
  ASSERT_EQ(plant.laws.size(), 1u);
  const LawFunctions functions = plant.laws[0].functions();

  for (const double motor : {-3.0, -0.2, 1.0, 4.0}) {
    for (const double external : {-2.0, 0.3, 5.0}) {
      for (const double rate : {-6.0, -1.0, 0.8, 3.0}) {
        std::vector<double> readings;
        for (const simulation::Reading& r : plant.laws[0].readings)
          readings.push_back(r.kind == ReadingKind::joint_rate     ? rate
                             : r.kind == ReadingKind::motor_torque ? motor
                                                                   : external);
        double torque = kNaN;
        functions.act(readings.data(), nullptr, &torque, nullptr);
        // at these rates the joint slides: tanh(8) and above
        EXPECT_NEAR(torque, -std::copysign(bam_m6(motor, external, rate), rate), 1e-6);
      }
    }
  }
}

}  // namespace
}  // namespace jaculus::effects
