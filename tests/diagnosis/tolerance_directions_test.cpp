// Tolerances as moves of plant and controller.

#include "diagnosis/forward/tolerance_directions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

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

TEST(ToleranceDirections, ALoggedInputHasNoLoopToBeOff) {
  const model::Robot robot = model::read_robot(source_folder() / "models" / "pendulum");
  for (const bool measured : {false, true}) {
    const auto directions = tolerance_directions(robot.planar, robot.tolerances, measured, 0.1);
    const bool loop = std::any_of(directions.begin(), directions.end(), [](const auto& d) {
      return d.name.starts_with("kp of ") || d.name.starts_with("encoder of ");
    });
    EXPECT_NE(loop, measured);
  }
}

}  // namespace
}  // namespace jaculus::diagnosis
