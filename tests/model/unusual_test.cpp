// Values that can be meant and hardly are: told of robots that were spoiled, of none that ships.

#include "jaculus/model/unusual.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "jaculus/model/robot.h"
#include "model/support.h"
#include "support/input_error.h"

namespace jaculus::model {
namespace {

using testing::kModels;

std::vector<std::string> unusual(const std::string& robot, const std::string& path,
                                 const std::string& value) {
  return unusual_values(
      read_robot(kModels / robot, {{path, yaml::Node::parse(value, "override")}}).planar);
}

TEST(Unusual, NothingIsToldOfRobotsThatShip) {
  for (const auto& entry : std::filesystem::directory_iterator(kModels))
    for (const std::string& told : unusual_values(read_robot(entry.path()).planar))
      ADD_FAILURE() << entry.path().filename() << ": " << told;
}

TEST(Unusual, SlipsOfThePointAndOfTheUnitAreTold) {
  struct Case {
    const char *robot, *path, *value, *told;
  };
  for (const Case& c : {
           Case{"minitaur_tail", "friction", "35", "friction = 35; usual: 0.1 (rubber on ice)"},
           {"minitaur_tail", "gravity", "98", "gravity = 98 m/s^2; usual: 9.81"},
           {"minitaur_tail", "bodies.front_a_upper.mass", "500",
            "mass = 500 kg; in a body of 0.1 m"},
           {"minitaur_tail", "motors.tail.torque_limit", "1e6",
            "motors.tail.torque_limit = 1e+06 N m"},
           {"minitaur_tail", "motors.front_a.torque_limit", "9000",
            "times this robot's weight times its reach"},
           {"minitaur_tail", "motors.tail.voltage", "16000", "motors.tail.voltage = 1.6e+04 V"},
           {"minitaur_tail", "motors.tail.torque_constant", "95.4 mN m/A", ""},
           {"minitaur_tail", "motors.tail.torque_constant", "95.4", "without load"},
           {"minitaur_tail", "motors.tail.efficiency", "0.09", "worm gears have 0.3"},
           {"minitaur_tail", "tail.drag.density", "1225", "water has 1000"},
           {"minitaur_tail", "tail.drag.density", "0", ""},
           {"pendulum", "gravity", "0", ""},
           {"slider", "motors.slide.torque_limit", "3e6", "hydraulic cylinder"},
       }) {
    const std::vector<std::string> told = unusual(c.robot, c.path, c.value);
    const bool silent = std::string(c.told).empty();
    EXPECT_EQ(told.empty(), silent) << c.path << ": " << (told.empty() ? "" : told.front());
    bool found = silent;
    for (const std::string& sentence : told)
      found = found || sentence.find(c.told) != std::string::npos;
    EXPECT_TRUE(found) << c.path << ": " << (told.empty() ? "" : told.front());
  }
}

}  // namespace
}  // namespace jaculus::model
