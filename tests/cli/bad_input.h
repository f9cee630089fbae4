#pragma once
// A folder with a good problem and its good robot, which a test spoils or asks wrongly for.

#include <gtest/gtest.h>

#include <filesystem>

#include "support/temporary_folder.h"

namespace jaculus::test {

// A robot of one leg: a pendulum on a rail, small enough to be read beside a test.
inline constexpr const char* kUrdf =
    R"(<?xml version="1.0"?>
<robot name="toy">
  <link name="base">
    <inertial><origin xyz="0 0 0"/><mass value="2"/>)"
    R"(<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="arm">
    <inertial><origin xyz="0 0 -0.5"/><mass value="1"/>)"
    R"(<inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="swing" type="revolute">
    <parent link="base"/><child link="arm"/><origin xyz="0 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="10" velocity="50"/>
  </joint>
</robot>
)";

inline constexpr const char* kRobot = R"(format: jaculus-robot/1
base: floating
gravity: 9.81 m/s^2
friction: 0.8
feet:
  foot: {link: arm, point: [0, -1]}
motors:
  swing:
    kind: electric
    torque_constant: 0.1 N m/A
    resistance: 0.2 ohm
    saturation_linear: 9 A/(N m)
    saturation_cubic: 0.5 A/(N m)^3
    voltage: 16 V
    current_limit: 60 A
    torque_limit: 3 N m
    gear: 1
    efficiency: 1
    rotor_inertia: 0
)";

inline constexpr const char* kProblem = R"(format: jaculus-problem/1
name: toy_problem
robot: toy
override: {motors.swing.resistance: 0.22 ohm}
limits: {voltage: 7 V, torque: 3 N m, current: 60 A, friction: 0.5}
bounds:
  position: {x: [-1 m, 1 m], z: [0 m, 2 m], pitch: [-1, 1], swing: [-90 deg, 90 deg]}
phases:
  - {name: stand, contacts: [foot], intervals: 4, duration: [10 ms, 500 ms]}
  - {name: fly, contacts: [], intervals: 4, duration: [10 ms, 500 ms]}
initial: {at_rest: true, position: {pitch: 0}}
final: {velocity: {x: [0.1 m/s, 5 m/s]}}
constraints:
  - {type: friction}
  - {type: normal_force, min: 1 N, phases: [stand]}
objective:
  maximise: [{type: mean_acceleration, weight: 1}]
transcription: {scheme: hermite_simpson, inputs: held}
guess: {kind: static}
solver: {tolerance: 1e-6}
)";

class BadInput : public ::testing::Test {
 protected:
  BadInput() {
    std::filesystem::create_directories(folder / "toy");
    restore();
  }
  void restore() const {
    folder.write("toy/robot.urdf", kUrdf);
    folder.write("toy/robot.yaml", kRobot);
    folder.write("problem.yaml", kProblem);
  }
  TemporaryFolder folder;
};

}  // namespace jaculus::test
