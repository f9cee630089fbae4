#include "jaculus/core/error.h"

#include <gtest/gtest.h>

#include "jaculus/core/yaml.h"

namespace jaculus {
namespace {

TEST(InputError, AMessageOpensWithWhatIsKnownOfItsPlace) {
  EXPECT_STREQ(InputError({"a.yaml", 3, "mass"}, "wrong").what(), "a.yaml:3: mass: wrong");
  EXPECT_STREQ(InputError({"a.csv", 3}, "wrong").what(), "a.csv:3: wrong");
  EXPECT_STREQ(InputError({.file = "a.csv"}, "wrong").what(), "a.csv: wrong");
  EXPECT_STREQ(InputError({.line = 3, .key = "mass"}, "wrong").what(), "line 3: mass: wrong");
  EXPECT_STREQ(InputError({.key = "--horizon"}, "wrong").what(), "--horizon: wrong");
  EXPECT_STREQ(InputError({}, "wrong").what(), "wrong");
}

TEST(InputError, KeepsItsPlaceWhenItIsCaught) {
  try {
    throw InputError({"a.yaml", 3, "mass"}, "wrong");
  } catch (const InputError& error) {
    EXPECT_EQ(error.place().file, "a.yaml");
    EXPECT_EQ(error.place().line, 3);
    EXPECT_EQ(error.place().key, "mass");
    EXPECT_EQ(error.fault(), "wrong");
  }
}

TEST(InputError, OfAMessageAloneHasNoPlace) {
  const InputError error("a.yaml:3: mass: wrong");
  EXPECT_EQ(error.place().file, "");
  EXPECT_EQ(error.place().line, 0);
  EXPECT_EQ(error.fault(), "a.yaml:3: mass: wrong");
}

TEST(InputError, OfAYamlNodeHasTheNodesPlace) {
  const yaml::Node node = yaml::Node::parse("body:\n  mass: [1]\n", "a.yaml");
  const InputError error = node.at("body").at("mass").items()[0].error("wrong");
  EXPECT_EQ(error.place().file, "a.yaml");
  EXPECT_EQ(error.place().line, 2);
  EXPECT_EQ(error.place().key, "body.mass[0]");
}

}  // namespace
}  // namespace jaculus
