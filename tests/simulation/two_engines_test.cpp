// The plant's equations of motion against the planner's (components/equations.h): accelerations and
// forces of every robot of models/, at random states and inputs. The two share models and the law
// of drag, nothing else of what is compared here. tests/components/mujoco_reference_test.cpp holds
// the planner's against MuJoCo, tests/testbed whole motions.

#include <gtest/gtest.h>

#include <filesystem>

#include "jaculus/components/equations.h"
#include "jaculus/core/installation.h"
#include "jaculus/model/robot.h"
#include "simulation/contact/plant_equations.h"
#include "simulation/support.h"
#include "support/random_state.h"

namespace jaculus::simulation {
namespace {

using namespace test;
using detail::Touch;

std::vector<model::Robot> robots() {
  std::vector<model::Robot> all;
  for (const auto& entry : std::filesystem::directory_iterator(source_folder() / "models"))
    if (entry.is_directory()) all.push_back(model::read_robot(entry.path()));
  return all;
}

/// Holds these torques before the gears [N m], for ever.
Controller constant_torques(const model::PlanarModel& model, const Vector& torques) {
  Controller c = no_controller();
  c.after_end = AfterEnd::repeat;
  c.reference.time = Vector::Zero(1);
  c.reference.feedforward = torques;
  for (const model::PlanarMotor& motor : model.motors) c.reference.motors.push_back(motor.joint);
  return c;
}

double largest(const Vector& v) { return v.size() == 0 ? 0.0 : v.cwiseAbs().maxCoeff(); }

/// Largest differences over random states, relative to the largest of the values beside 1.
struct Difference {
  double acceleration = 0.0, force = 0.0;
  int states = 0;  ///< compared
};

/// `pinned`: feet that stand still, the others and all stops open.
Difference compare(const model::PlanarModel& model, const std::vector<int>& pinned, int trials) {
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const Plant plant = nominal_plant(model);
  const components::Equations planner(model, plant.drag_smoothing);
  components::EquationsPoint point(planner, pinned);
  const int n = model.size(), motors = count_of(model.motors);
  Difference worst;

  for (int trial = 0; trial < trials; ++trial) {
    Vector torques(motors), u(motors);
    for (int m = 0; m < motors; ++m) {
      torques[m] = 0.02 * unit(rng);  // far from every limit
      u[m] = torques[m] * model.motors[m].gear * model.motors[m].efficiency;
    }
    const Controller controller = constant_torques(model, torques);
    detail::PlantEquations equations(plant, controller);
    const auto state = test_support::random_state(model, rng);
    detail::State y(equations.states()), dydt(y.size());
    std::copy(state.q.begin(), state.q.end(), y.begin());
    std::copy(state.v.begin(), state.v.end(), y.begin() + n);
    std::vector<Touch> modes(equations.unilaterals().size(), Touch::open);
    for (const int foot : pinned) modes[foot] = Touch::stick;

    equations.take_inputs(0.0, y);
    const detail::Evaluation* at = equations.evaluate(0.0, y, modes, dydt);
    const bool possible = planner.evaluate(state.q, state.v, u, point);
    EXPECT_EQ(at != nullptr, possible);
    if (at == nullptr || !possible) continue;
    ++worst.states;

    const Vector a = Eigen::Map<const Vector>(dydt.data() + n, n);
    worst.acceleration =
        std::max(worst.acceleration, largest(a - point.a) / (1.0 + largest(point.a)));
    for (int k = 0; k < count_of(pinned); ++k) {
      const Vec2 force(at->lambda[2 * pinned[k]], at->lambda[2 * pinned[k] + 1]);
      worst.force = std::max(worst.force, largest(force - point.force.segment<2>(2 * k)) /
                                              (1.0 + largest(point.force)));
    }
  }
  return worst;
}

TEST(TwoEngines, AgreeOnAccelerationsOfEveryRobotInFlight) {
  int compared = 0;
  for (const model::Robot& robot : robots()) {
    const Difference worst = compare(robot.planar, {}, 50);
    EXPECT_GT(worst.states, 25) << robot.name;
    EXPECT_LT(worst.acceleration, 1e-9) << robot.name;
    ++compared;
  }
  EXPECT_GE(compared, 6);
}

TEST(TwoEngines, AgreeOnAccelerationsAndForcesWithFeetPinned) {
  int compared = 0;
  for (const model::Robot& robot : robots()) {
    std::vector<int> all;
    for (int foot = 0; foot < count_of(robot.planar.feet); ++foot) {
      const Difference worst = compare(robot.planar, {foot}, 50);
      EXPECT_GT(worst.states, 25) << robot.name;
      EXPECT_LT(worst.acceleration, 1e-9) << robot.name << ", foot " << foot;
      EXPECT_LT(worst.force, 1e-9) << robot.name << ", foot " << foot;
      all.push_back(foot);
      ++compared;
    }
    if (count_of(all) < 2) continue;
    const Difference worst = compare(robot.planar, all, 50);
    EXPECT_GT(worst.states, 25) << robot.name;
    EXPECT_LT(worst.acceleration, 1e-9) << robot.name;
    EXPECT_LT(worst.force, 1e-9) << robot.name;
  }
  EXPECT_GE(compared, 4);
}

}  // namespace
}  // namespace jaculus::simulation
