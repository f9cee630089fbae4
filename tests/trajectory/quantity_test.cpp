// Names of columns and of what files may state, taken apart and put together in one place.

#include "jaculus/trajectory/quantity.h"

#include <gtest/gtest.h>

#include "jaculus/trajectory/kinds.h"

namespace jaculus::trajectory {
namespace {

TEST(ChannelName, IsTakenApartAtItsLongestSuffix) {
  const auto is = [](const char* name, const char* of, Quantity quantity) {
    const ChannelName parts = parse_channel(name);
    EXPECT_EQ(parts.of, of) << name;
    EXPECT_EQ(parts.quantity, quantity) << name;
  };
  is("front_a", "front_a", Quantity::position);
  is("front_a_velocity", "front_a", Quantity::velocity);
  is("tail_torque", "tail", Quantity::torque);
  is("tail_motor_torque", "tail", Quantity::motor_torque);
  is("rear_force_z", "rear", Quantity::force_z);
  is("rear_force", "rear", Quantity::force);
  is("front_a_apart", "front_a", Quantity::apart);
  is("imu_pitch", "imu_pitch", Quantity::position);
  is("imu_pitch_velocity", "imu_pitch", Quantity::velocity);
  is("bus_voltage", "bus", Quantity::voltage);
  is("_torque", "_torque", Quantity::position);
  is("torque", "torque", Quantity::position);
}

TEST(ChannelName, OfEveryQuantityReadsBack) {
  for (const std::string& name : quantity_names().names()) {
    const Quantity quantity = *quantity_names().find(name);
    const ChannelName parts = parse_channel(channel_name("front_a", quantity));
    EXPECT_EQ(parts.of, "front_a") << name;
    EXPECT_EQ(parts.quantity, quantity) << name;
    EXPECT_EQ(name_of(quantity), name);
    EXPECT_FALSE(dimensions_of(quantity).empty()) << name;
  }
}

TEST(Quantity, HasAUnitForWhatTurnsAndWhatSlides) {
  EXPECT_EQ(unit_of(Quantity::velocity), "rad/s");
  EXPECT_EQ(unit_of(Quantity::velocity, true), "m/s");
  EXPECT_EQ(unit_of(Quantity::torque, true), "N");
  EXPECT_EQ(unit_of(Quantity::duty, true), "-");
}

template <class Value>
void expect_names_read_back(const NameTable<Value>& table) {
  for (const std::string& name : table.names()) {
    ASSERT_TRUE(table.find(name)) << name;
    EXPECT_EQ(table.name(*table.find(name)), name);
  }
  EXPECT_FALSE(table.find("gremlins"));
}

TEST(Kinds, HaveNamesThatReadBack) {
  expect_names_read_back(experiment_kinds());
  expect_names_read_back(controller_kinds());
  expect_names_read_back(after_ends());
  expect_names_read_back(quantity_names());
  EXPECT_EQ(command_names().names(), (std::vector<std::string>{"torque", "duty", "voltage"}));
}

}  // namespace
}  // namespace jaculus::trajectory
