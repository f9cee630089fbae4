// What an experiment's file may not say.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "jaculus/simulation/experiment.h"
#include "support/input_error.h"

namespace jaculus::simulation {
namespace {

/// What is said of an experiment on a joint that turns or slides, with these two lines.
std::string said_of(const std::string& robot, const std::string& joint, const std::string& kind,
                    const std::string& noise) {
  const std::string text = fmt::format(R"(format: jaculus-experiment/1
name: one
experiment: {}
robot: {}
input: {{torque: {{{}: 0.1}}}}
controller: {{kind: torque, rate_hz: 500}}
initial: {{{}: 0}}
streams:
  joints: {{rate_hz: 100, channels: ["*"], noise: {{"*": {}}}}}
)",
                                       kind, robot, joint, joint, noise);
  return test::input_error_of(
      [&] { (void)read_experiment(yaml::Node::parse(text, "models/one.yaml")); });
}

TEST(ReadExperiment, NoiseIsInAUnitThatItsJointHas) {
  const std::string angle = said_of("pendulum", "swing", "pendulum", "0.2 mm"),
                    length = said_of("slider", "slide", "pendulum", "0.1 deg");
  for (const std::string& said : {angle, length})
    EXPECT_TRUE(test::holds(said, "models/one.yaml:9: streams.joints.noise.*: ")) << said;
  EXPECT_TRUE(test::holds(angle, "allowed: a number in rad")) << angle;
  EXPECT_TRUE(test::holds(length, "allowed: a number in m")) << length;
}

TEST(ReadExperiment, ALeapNeedsABaseThatRises) {
  const std::string said = said_of("pendulum", "swing", "leap", "0.1 deg");
  EXPECT_TRUE(test::holds(said, "models/one.yaml:3: experiment: leap given")) << said;
}

}  // namespace
}  // namespace jaculus::simulation
