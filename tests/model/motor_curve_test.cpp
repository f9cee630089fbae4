// Torque-speed curves of data sheets, read as electric motors.

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/model/robot.h"
#include "model/support.h"
#include "support/input_error.h"

namespace jaculus::model {
namespace {

using test::holds;
using test::input_error_of;

const char* const kArmUrdf = R"(<robot name="arm"><link name="base"/>
<link name="arm"><inertial><origin xyz="0 0 -0.1"/><mass value="2"/>
<inertia ixx="0.02" iyy="0.03" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="continuous"><parent link="base"/><child link="arm"/>
<axis xyz="0 1 0"/></joint>
</robot>)";

PlanarMotor motor_of(const std::string& keys) {
  const testing::Folder folder;
  folder.write("robot.urdf", kArmUrdf);
  folder.write("robot.yaml",
               "format: jaculus-robot/1\nbase: fixed\nmotors:\n  j: {" + keys + "}\n");
  return read_robot(folder.path()).planar.motors.at(0);
}

const std::string kCurve =
    "kind: envelope, torque_limit: 3 N m, knee_speed: 150 rad/s, no_load_speed: 240 rad/s, "
    "voltage: 24 V, gear: 6, efficiency: 1, rotor_inertia: 0";

/// Motor torque at a voltage and motor speed, by the law of the motor.
double torque_at(const PlanarMotor& m, double volts, double speed) {
  return (volts - m.torque_constant * speed) / m.resistance / m.saturation_linear;
}

TEST(MotorCurve, PassesThroughKneeAndNoLoadSpeed) {
  const PlanarMotor m = motor_of(kCurve);
  EXPECT_NEAR(m.torque_constant, 0.1, 1e-12);
  EXPECT_NEAR(torque_at(m, 24.0, 150.0), 3.0, 1e-12);
  EXPECT_NEAR(torque_at(m, 24.0, 195.0), 1.5, 1e-12);  // half way down
  EXPECT_NEAR(torque_at(m, 24.0, 240.0), 0.0, 1e-12);
  EXPECT_EQ(m.torque_limit, 3.0);
  EXPECT_EQ(m.saturation_cubic, 0.0);
  EXPECT_FALSE(m.ideal());
}

TEST(MotorCurve, FallsWithTheVoltageAsAMotorsDoes) {
  const PlanarMotor m = motor_of(kCurve);
  EXPECT_NEAR(torque_at(m, 12.0, 120.0), 0.0, 1e-12);  // no-load speed goes with the voltage
  EXPECT_NEAR(torque_at(m, 12.0, 30.0), 3.0, 1e-12);   // the knee comes by as much less
}

TEST(MotorCurve, AKneeAtRestIsThatOfAMotorWithoutLimit) {
  const PlanarMotor m = motor_of(
      "kind: envelope, torque_limit: 2, knee_speed: 0, no_load_speed: 100, voltage: 10, gear: 1, "
      "efficiency: 1, rotor_inertia: 0");
  EXPECT_NEAR(torque_at(m, 10.0, 0.0), 2.0, 1e-12);  // stall torque is the peak
}

TEST(MotorCurve, FaultsNameFileLineAndWhatIsAllowed) {
  const auto fault = [](const std::string& from, const std::string& to) {
    return input_error_of([&] { (void)motor_of(testing::replaced(kCurve, from, to)); });
  };
  EXPECT_TRUE(holds(fault("knee_speed: 150", "knee_speed: 250"),
                    "robot.yaml:4: motors.j.knee_speed: 250 rad/s given with no_load_speed 240"));
  EXPECT_TRUE(holds(fault("torque_limit: 3 N m", "torque_limit: .inf"),
                    "motors.j.torque_limit: no limit given"));
  EXPECT_TRUE(holds(fault("knee_speed: 150 rad/s, ", ""), "key 'knee_speed' is missing"));
  EXPECT_TRUE(holds(fault("torque_limit: 3 N m, ", ""), "key 'torque_limit' is missing"));
  EXPECT_TRUE(holds(fault("voltage: 24 V", "voltage: 24 A"), "motors.j.voltage: '24 A' is in A"));
  EXPECT_TRUE(holds(fault("gear: 6", "gear: 6, resistance: 1"), "unknown key 'resistance'"));
  EXPECT_TRUE(holds(fault("kind: envelope", "kind: curve"), "allowed: electric, envelope, ideal"));
}

TEST(MotorFriction, IsOfIdealAndElectricMotorsAlike) {
  const PlanarMotor m = motor_of(kCurve + ", viscous_friction: 0.01, dry_friction: 0.2 N m");
  EXPECT_EQ(m.viscous_friction, 0.01);
  EXPECT_EQ(m.dry_friction, 0.2);
  const PlanarMotor ideal = motor_of(
      "kind: ideal, torque_limit: 3, speed_limit: 9, viscous_friction: 0.02, dry_friction: 0.1");
  EXPECT_EQ(ideal.speed_limit, 9.0);
  EXPECT_EQ(ideal.viscous_friction, 0.02);
}

}  // namespace
}  // namespace jaculus::model
