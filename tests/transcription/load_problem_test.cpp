// A problem beside the robot that it plans for: limits and overrides of files that extend others.

#include <gtest/gtest.h>

#include "jaculus/core/installation.h"
#include "jaculus/transcription/problem.h"
#include "support/input_error.h"
#include "support/temporary_folder.h"

namespace jaculus::transcription {
namespace {

using test::holds;
using test::input_error_of;
using test::TemporaryFolder;

TEST(LoadProblem, ForcesAreLimitedOfJointsThatSlideAlone) {
  const TemporaryFolder folder;
  const auto load = [&](const std::string& torque) {
    const std::string integrator =
        (source_folder() / "problems" / "double_integrator.yaml").string();
    return load_problem(yaml::Node::load(
        folder.write("push.yaml", "format: jaculus-problem/1\nextends: " + integrator +
                                      "\nname: push\nlimits: {torque: " + torque + "}\n")));
  };
  const LoadedProblem gentle = load("0.5 N");
  EXPECT_EQ(planning_model(gentle.problem, gentle.robot.planar).motors[0].torque_limit, 0.5);
  EXPECT_EQ(planning_model(load("0.4").problem, gentle.robot.planar).motors[0].torque_limit, 0.4);
  EXPECT_TRUE(holds(input_error_of([&] { (void)load("300 N"); }),
                    "push.yaml:4: limits.torque: 300 N given; allowed: at most 1 N"));
  EXPECT_TRUE(holds(input_error_of([&] { (void)load("0.5 N m"); }),
                    "push.yaml:4: limits.torque: a torque given, but every motor of this robot "
                    "slides its joint; allowed: a number in N"));
}

TEST(LoadProblem, AnOverrideThatLeavesLessThanItsBaseUsesIsToldItself) {
  const TemporaryFolder folder;
  const std::string leap = (source_folder() / "problems" / "leap_tail.yaml").string();
  const auto error = [&](const std::string& override) {
    const std::string file =
        folder.write("weak.yaml", "format: jaculus-problem/1\nextends: " + leap +
                                      "\nname: weak\noverride:\n  " + override + "\n");
    return input_error_of([&] { (void)load_problem(yaml::Node::load(file)); });
  };
  const std::string voltage = error("motors.*.voltage: 3 V");
  EXPECT_TRUE(holds(voltage, "weak.yaml:5: override.motors.*.voltage: 3 V of motor '"));
  EXPECT_TRUE(holds(voltage, "leap_tail.yaml:"));
  EXPECT_TRUE(holds(error("tail.drag.point_area: 0 m^2"),
                    "weak.yaml:5: override.tail.drag.point_area: tail.drag.point_area: must be"));
}

}  // namespace
}  // namespace jaculus::transcription
