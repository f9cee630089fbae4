#pragma once
// The summary of a leap, made up.

#include "jaculus/solver/summary.h"

namespace jaculus::test {

inline solver::Summary sample_summary() {
  solver::Summary s;
  s.name = "leap";
  s.caption = "a leap";
  s.status = solver::Status::optimal;
  s.objective = 6.8;
  s.iterations = 42;
  s.size = {100, 120, 900, 400};
  s.duration = 0.19;
  s.phases = {{"all_feet", 0.184, false}, {"rear_feet", 0.006, true}};
  s.liftoff_velocity = 1.3;
  s.liftoff_velocity_com = 1.2;
  s.average_acceleration = 1.3 / 0.19;
  s.average_acceleration_com = 1.2 / 0.19;
  solver::MotorFigures motor;
  motor.joint = "tail";
  motor.file_joints = {{"tail", 1.0}, {"tail_mirror", -1.0}};
  motor.joint_torque = 8.0;
  motor.voltage = 6.99;
  motor.voltage_limit = 7.0;
  s.motors = {motor};
  s.held_joints = {{"abduction", 0.1, false}};
  s.active_limits = {{"tail voltage", "all_feet", 0.0, 0.1, 12}};
  s.gains = {{"voltage", 0.5, "m/s^2 per V"}};
  s.verification.passed = true;
  s.verification.reintegration_error = {{"x", 1e-4}, {"pitch", 2e-4}};
  s.verification.worst_violation = {"all_feet, node 3: friction", 1e-9, "N"};
  s.warnings = {"rear_feet: its duration stands at its bound"};
  s.input_hold = transcription::InputHold::held;
  s.seed = 3;
  s.reference = {{"average_acceleration_m_s2", 6.803}};
  s.problem = {{"name", "leap"}};
  return s;
}

}  // namespace jaculus::test
