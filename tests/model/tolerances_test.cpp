// What a careful builder can't know: stated or by default.

#include "jaculus/model/tolerances.h"

#include <gtest/gtest.h>

#include "jaculus/core/error.h"
#include "jaculus/model/robot.h"

namespace jaculus::model {
namespace {

Tolerances read(const std::string& text) {
  return read_tolerances(yaml::Node::parse(text, "robot.yaml"));
}

std::string message(const std::string& text) {
  try {
    (void)read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Tolerances, AbsentOnesKeepTheirDefaults) {
  const Tolerances read_in = read("tolerances: {mass: 0.1, com: 5 mm}");

  EXPECT_DOUBLE_EQ(read_in.mass, 0.1);
  EXPECT_DOUBLE_EQ(read_in.com, 5e-3);
  EXPECT_DOUBLE_EQ(read_in.inertia, Tolerances{}.inertia);
  EXPECT_DOUBLE_EQ(read("base: fixed").torque_constant, Tolerances{}.torque_constant);
}

TEST(Tolerances, ANonsenseValueIsRefusedWithItsPlace) {
  EXPECT_NE(message("base: fixed\ntolerances: {mass: -0.1}").find("robot.yaml:2"),
            std::string::npos);
  EXPECT_NE(message("tolerances: {resistance: 3}").find("resistance"), std::string::npos);
  EXPECT_NE(message("tolerances: {masses: 0.1}").find("mass"), std::string::npos);
}

TEST(Tolerances, EveryKeyIsExplained) {
  const std::string text = explain_robot();
  for (const ToleranceKey& key : tolerance_keys())
    EXPECT_NE(text.find("    " + std::string(key.name)), std::string::npos) << key.name;
}

}  // namespace
}  // namespace jaculus::model
