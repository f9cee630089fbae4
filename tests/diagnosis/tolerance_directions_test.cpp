// Tolerances as moves of plant and controller.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "diagnosis/forward/tolerance_part.h"
#include "jaculus/core/installation.h"
#include "jaculus/model/robot.h"

namespace jaculus::diagnosis {
namespace {

TEST(ToleranceDirections, MoveWhatTheyNameByOneDeviationAndNothingElse) {
  const model::Robot robot = model::read_robot(source_folder() / "models" / "minitaur");
  const auto directions = tolerance_directions(robot.planar, robot.tolerances, false, 0.1);
  std::set<std::string> names;
  for (const ToleranceDirection& d : directions) names.insert(d.name);
  EXPECT_EQ(names.size(), directions.size());

  const auto mass = std::find_if(directions.begin(), directions.end(),
                                 [](const auto& d) { return d.name.starts_with("mass of "); });
  ASSERT_NE(mass, directions.end());
  simulation::Plant plant = simulation::nominal_plant(robot.planar);
  simulation::Controller controller;
  mass->move(1.0, plant, controller);
  const std::string link = mass->name.substr(8);
  for (std::size_t b = 0; b < plant.model.bodies.size(); ++b) {
    const double share = plant.model.bodies[b].name == link ? robot.tolerances.mass : 0.0;
    EXPECT_NEAR(plant.model.bodies[b].mass, (1.0 + share) * robot.planar.bodies[b].mass, 1e-12);
    EXPECT_EQ(plant.model.bodies[b].inertia, robot.planar.bodies[b].inertia);
  }
}

Matrix part_of(const model::Robot& robot, const std::string& effect, const Vector& theta,
               const std::vector<ToleranceDirection>& directions) {
  return tolerance_part(simulation::nominal_plant(robot.planar), *effects::find_effect(effect),
                        theta, directions);
}

int place_of(const std::vector<ToleranceDirection>& directions, const std::string& name) {
  const auto found = std::find_if(directions.begin(), directions.end(),
                                  [&](const auto& d) { return d.name == name; });
  EXPECT_NE(found, directions.end()) << name;
  return static_cast<int>(found - directions.begin());
}

TEST(TolerancePart, AddsToAnEffectWhatIsOfItsQuantityAlone) {
  const model::Robot robot = model::read_robot(source_folder() / "models" / "double_pendulum");
  auto directions = tolerance_directions(robot.planar, robot.tolerances, true, 0.1);
  directions.push_back(input_clock(2e-3));
  const int first = place_of(directions, "torque constant of shoulder"),
            second = place_of(directions, "torque constant of elbow"),
            clock = place_of(directions, "clock of the input");

  // An effect of both joints grows by the mean over them, at 0.8 of the files' value by as much.
  const Matrix weak = part_of(robot, "torque_constant", Vector::Constant(1, 0.8), directions);
  ASSERT_EQ(weak.rows(), 1);
  const double half = 0.5 * 0.8 * robot.tolerances.torque_constant;
  EXPECT_NEAR(weak(0, first), half, 1e-9);
  EXPECT_NEAR(weak(0, second), half, 1e-9);
  EXPECT_NEAR(weak.cwiseAbs().sum(), 2.0 * half, 1e-9);

  const Matrix late = part_of(robot, "actuation_delay", Vector::Constant(1, 0.005), directions);
  EXPECT_NEAR(late(0, clock), 2e-3, 1e-12);
  EXPECT_NEAR(late.cwiseAbs().sum(), 2e-3, 1e-12);

  const Matrix viscous =
      part_of(robot, "joint_viscous_friction", Vector::Constant(1, 0.01), directions);
  EXPECT_EQ(viscous.cwiseAbs().sum(), 0.0) << "tolerances rub dry";
}

TEST(TolerancePart, TakesFrictionsOfOneQuantityTogether) {
  const model::Robot robot = model::read_robot(source_folder() / "models" / "double_pendulum");
  const auto directions = tolerance_directions(robot.planar, robot.tolerances, true, 0.1);
  const int elbow = place_of(directions, "friction of elbow");
  simulation::Plant plant = simulation::nominal_plant(robot.planar);
  simulation::Controller controller;
  directions[elbow].move(1.0, plant, controller);
  const double deviation = plant.friction.front().coulomb;

  const Matrix dry = part_of(robot, "joint_coulomb_friction", Vector::Constant(1, 0.1), directions);
  EXPECT_NEAR(dry(0, elbow), 0.5 * deviation, 1e-9);
  Vector leaning(2);
  leaning << 0.1, -0.2;
  const Matrix by_way = part_of(robot, "joint_directional_friction", leaning, directions);
  EXPECT_NEAR(by_way(0, elbow), 0.5 * deviation, 1e-9);
  // The same difference between both ways is a smaller share of more friction.
  EXPECT_NEAR(by_way(1, elbow), 0.2 * 0.5 * deviation / 0.1, 1e-6);
}

TEST(ToleranceDirections, ALoggedInputHasNoLoopToBeOff) {
  const model::Robot robot = model::read_robot(source_folder() / "models" / "pendulum");
  for (const bool measured : {false, true}) {
    const auto directions = tolerance_directions(robot.planar, robot.tolerances, measured, 0.1);
    const auto named = [&](const std::string& start) {
      return std::any_of(directions.begin(), directions.end(),
                         [&](const auto& d) { return d.name.starts_with(start); });
    };
    EXPECT_NE(named("kp of "), measured);
    EXPECT_TRUE(named("encoder of ")) << "weight pulls at a pendulum whose zero is off";
  }
}

TEST(ToleranceDirections, DriversReportsHaveAScaleEachAndOneLowPass) {
  const model::Robot robot = model::read_robot(source_folder() / "models" / "pendulum");
  ObservedDataset observed;
  observed.dataset.robot = robot.folder.string();
  observed.model = robot.planar;
  const std::string joint = robot.planar.motors.front().joint, current = joint + "_current";
  for (const std::string& name : {joint, current}) {
    Channel channel;
    channel.name = name;
    observed.channels.push_back(channel);
  }

  const std::vector<ToleranceDirection> directions = tolerances_of(observed, Settings{});
  simulation::Plant plant = simulation::nominal_plant(robot.planar);
  simulation::Controller controller;
  directions[place_of(directions, "scale of " + current)].move(-1.0, plant, controller);
  EXPECT_EQ(plant.sensing.scale, (std::map<std::string, double>{{current, 0.98}}));
  const ToleranceDirection& filter = directions[place_of(directions, "low pass of currents")];
  filter.move(2.0, plant, controller);
  EXPECT_EQ(plant.sensing.filter, (std::map<std::string, double>{{current, 2e-3}}));
  EXPECT_EQ(filter.range.lower, 0.0);
}

TEST(ToleranceDirections, ATorqueThatDrivesTheModelIsOffByTheAmmeterToo) {
  const model::Robot robot = model::read_robot(source_folder() / "models" / "pendulum");
  ObservedDataset observed;
  observed.dataset.robot = robot.folder.string();
  observed.model = robot.planar;
  observed.measured_input = true;
  const std::string joint = robot.planar.motors.front().joint;
  const auto scale_by = [&](trajectory::Quantity input) {
    observed.dataset.controller.input = input;
    const std::vector<ToleranceDirection> directions = tolerances_of(observed, Settings{});
    simulation::Plant plant = simulation::nominal_plant(robot.planar);
    simulation::Controller controller;
    directions[place_of(directions, "torque constant of " + joint)].move(1.0, plant, controller);
    return plant.actuation.torque_scale.at(joint) - 1.0;
  };

  const model::Tolerances& own = robot.tolerances;
  EXPECT_NEAR(scale_by(trajectory::Quantity::torque),
              std::hypot(own.torque_constant, own.current_scale), 1e-12);
  EXPECT_NEAR(scale_by(trajectory::Quantity::voltage), own.torque_constant, 1e-12);
}

}  // namespace
}  // namespace jaculus::diagnosis
