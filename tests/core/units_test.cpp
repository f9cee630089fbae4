#include "jaculus/core/units.h"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "jaculus/core/error.h"

namespace jaculus {
namespace {

constexpr double kPi = std::numbers::pi;

struct Good {
  const char* text;
  Dimension dimension;
  double value;
};

TEST(Units, ReadsQuantities) {
  const std::vector<Good> cases = {
      {"16 V", dimension::voltage, 16.0},
      {"16V", dimension::voltage, 16.0},
      {"+16 V", dimension::voltage, 16.0},
      {" -2.5 V ", dimension::voltage, -2.5},
      {"15 deg", dimension::angle, 15.0 * kPi / 180.0},
      {"15\u00b0", dimension::angle, 15.0 * kPi / 180.0},
      {"0.5 rev", dimension::angle, kPi},
      {"4 ms", dimension::time, 4e-3},
      {"7.2e-5 kg m^2", dimension::inertia, 7.2e-5},
      {"7.2e-5 kg*m^2", dimension::inertia, 7.2e-5},
      {"7.2e-5 kg\u00b7m\u00b2", dimension::inertia, 7.2e-5},
      {"720 g cm^2", dimension::inertia, 7.2e-5},
      {"0.186 ohm", dimension::resistance, 0.186},
      {"186 mohm", dimension::resistance, 0.186},
      {"0.186 V/A", dimension::resistance, 0.186},
      {"0.0954 N m/A", dimension::torque_constant, 0.0954},
      {"0.0954 V s/rad", dimension::torque_constant, 0.0954},
      {"1 V/rpm", dimension::torque_constant, 60.0 / (2.0 * kPi)},
      {"100 deg/s", dimension::angular_velocity, 100.0 * kPi / 180.0},
      {"60 rpm", dimension::angular_velocity, 2.0 * kPi},
      {"1 kHz", dimension::frequency, 1000.0},
      {"5 1/s", dimension::frequency, 5.0},
      {"5 s^-1", dimension::frequency, 5.0},
      {"0.539 A/(N m)^3", dimension::saturation_cubic, 0.539},
      {"8.93 A/(N m)", dimension::saturation_linear, 8.93},
      {"8.93 A/N/m", dimension::saturation_linear, 8.93},
      {"1 N m/deg", dimension::angular_stiffness, 180.0 / kPi},
      {"1 J", dimension::torque, 1.0},
      {"80 %", dimension::none, 0.8},
      {"0.8", dimension::none, 0.8},
      {"0.8 -", dimension::none, 0.8},
      {"9.81 N/kg", dimension::acceleration, 9.81},
  };
  for (const Good& c : cases) {
    EXPECT_NEAR(parse_quantity(c.text, c.dimension), c.value, 1e-14 * (1.0 + std::abs(c.value)))
        << c.text;
  }
}

struct Bad {
  const char* text;
  Dimension dimension;
  const char* message;  ///< must stand in the error
};

TEST(Units, RefusesWithTheReason) {
  const std::vector<Bad> cases = {
      {"16 A", dimension::voltage, "'16 A' is in A; allowed: a number in V"},
      {"16", dimension::voltage, "'16' has no unit; allowed: a number in V"},
      {"15 deg", dimension::none, "'15 deg' is in rad; allowed: a plain number"},
      {"5 1/s", dimension::angular_velocity, "is in Hz; allowed: a number in rad/s"},
      {"5 Hz", dimension::angular_velocity, "is in Hz; allowed: a number in rad/s"},
      {"5 rad/s", dimension::frequency, "is in rad/s; allowed: a number in Hz"},
      {"3 N m/rad", dimension::torque, "is in N m/rad; allowed: a number in N m"},
      {"3 V s", dimension::angle, "allowed: a number in rad"},
      {"3 volts", dimension::voltage, "unknown unit 'volts'"},
      {"3 Ohm", dimension::resistance, "did you mean 'ohm'?"},
      {"3 Nm", dimension::torque, "unknown unit 'Nm', did you mean 'N m'?"},
      {"V", dimension::voltage, "'V' is not a number"},
      {"", dimension::voltage, "'' is not a number"},
      {"nan V", dimension::voltage, "not a finite number"},
      {"inf", dimension::none, "not a finite number"},
      {"1e999 V", dimension::voltage, "too large or too small"},
      {"1e308 km", dimension::length, "too large"},
      {"1 m^", dimension::length, "a power must be a whole number"},
      {"1 m^0", dimension::none, "a power must be a whole number"},
      {"1 m^99", dimension::length, "a power must be a whole number"},
      {"1 (m", dimension::length, "')' is missing"},
      {"1 m)", dimension::length, "unexpected ')'"},
      {"1 m//s", dimension::velocity, "unexpected '/'"},
      {"1 m/", dimension::velocity, "a unit is missing"},
      {"1 ((((((((((m))))))))))", dimension::length, "nested too deeply"},
      {"1,5 V", dimension::voltage, "unexpected ','"},
  };
  for (const Bad& c : cases) {
    try {
      parse_quantity(c.text, c.dimension);
      ADD_FAILURE() << "accepted: " << c.text;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(c.message), std::string::npos)
          << c.text << " -> " << e.what();
    }
  }
}

TEST(Units, EveryNameReadsBackAsOne) {
  using namespace dimension;
  for (const Dimension& d : {none,
                             length,
                             area,
                             mass,
                             time,
                             frequency,
                             angle,
                             velocity,
                             angular_velocity,
                             acceleration,
                             angular_acceleration,
                             force,
                             torque,
                             inertia,
                             density,
                             current,
                             voltage,
                             resistance,
                             torque_constant,
                             saturation_linear,
                             saturation_cubic,
                             angular_stiffness,
                             angular_damping,
                             Dimension{3, -2, 1, 4, -1},
                             Dimension{1, 1, 1, 1, 1}}) {
    EXPECT_EQ(parse_quantity("1 " + unit_name(d), d), 1.0) << unit_name(d);
  }
}

TEST(Units, FollowANumberWhereThereIsOne) {
  EXPECT_EQ("12" + after_number("N m"), "12 N m");
  EXPECT_EQ("1.2" + after_number(unit_name(dimension::none)), "1.2");
}

}  // namespace
}  // namespace jaculus
