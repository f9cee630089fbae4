#include "jaculus/trajectory/bag_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "support/input_error.h"

namespace jaculus::trajectory {
namespace {

using test::holds;
using test::input_error_of;

std::vector<BagTopic> topics_of(const std::string& topics) {
  return read_bag_map(yaml::Node::parse("format: jaculus-bag/1\ntopics:\n" + topics, "bag.yaml"));
}

TEST(BagMap, ReadsTopicsOfKnownTypesInTheOrderOfTheFile) {
  const auto topics = topics_of(
      "  /z: {}\n"
      "  /joint_states: {stream: legs, rate_hz: 500, stamp: log, joints: {a: front_a}}\n"
      "  /pose: {forward: -y, rest: 500 ms}\n");
  ASSERT_EQ(topics.size(), 3u);
  EXPECT_EQ(topics[0].topic, "/z");
  EXPECT_TRUE(std::isnan(topics[0].rate_hz));
  EXPECT_FALSE(topics[0].stamp || topics[0].forward || topics[0].rest);
  EXPECT_EQ(topics[1].stream, "legs");
  EXPECT_EQ(topics[1].rate_hz, 500.0);
  EXPECT_EQ(topics[1].stamp, BagStamp::log);
  EXPECT_EQ(topics[1].joints.at("a"), "front_a");
  EXPECT_EQ(topics[2].forward, MocapForward::minus_y);
  EXPECT_EQ(topics[2].rest, 0.5);
}

TEST(BagMap, ReadsFieldsAsChannelsInSi) {
  const auto topics = topics_of(
      "  /status:\n    channels:\n"
      "      hip: {fields: [\"m[0].q\", \"m[1].q\"], unit: deg, scale: -2, offset: 90}\n");
  const MappedChannel& hip = topics.at(0).channels.at(0);
  EXPECT_EQ(hip.columns, (std::vector<std::string>{"m[0].q", "m[1].q"}));
  EXPECT_EQ(hip.unit, "rad");
  EXPECT_NEAR(hip.scale, -2.0 * 3.14159265358979 / 180.0, 1e-15);
  EXPECT_NEAR(hip.shift, 0.5 * 3.14159265358979, 1e-14);
}

TEST(BagMap, RefusesWhatItCannotMean) {
  const auto told = [](const std::string& topics) {
    return input_error_of([&] { topics_of(topics); });
  };
  EXPECT_TRUE(holds(told("  /a: {stamp: mine}\n"), "bag.yaml:3"));
  EXPECT_TRUE(holds(told("  /a: {strem: x}\n"), "did you mean 'stream'"));
  EXPECT_TRUE(holds(told("  /a: {stream: x}\n  /b: {stream: x}\n"), "another topic has it"));
  EXPECT_TRUE(holds(told("  /a: {channels: {}}\n"), "allowed: at least one channel"));
  EXPECT_TRUE(
      holds(told("  /a: {channels: {q: {column: x, unit: rad}}}\n"), "allowed: field, fields"));
  EXPECT_TRUE(holds(told("  /a: {channels: {q: {unit: rad}}}\n"), "one of field and fields"));
  EXPECT_TRUE(holds(told("  /a: {channels: {q_torque: {field: x, unit: rad}}}\n"), "q_torque"));
  EXPECT_TRUE(holds(told("  /a: {forward: +x, channels: {q: {field: x, unit: rad}}}\n"),
                    "of a known type"));
  EXPECT_TRUE(holds(input_error_of([] {
                      read_bag_map(yaml::Node::parse("format: jaculus-columns/1\n", "bag.yaml"));
                    }),
                    "jaculus-columns/1"));
}

}  // namespace
}  // namespace jaculus::trajectory
