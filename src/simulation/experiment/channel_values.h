#pragma once
// What a sensor could show of a simulation at best: values of its channels, and those between the
// samples.

#include <string>

#include "jaculus/simulation/plant.h"
#include "jaculus/simulation/simulate.h"

namespace jaculus::simulation {

/// A channel of a motor: "front_a_torque".
struct MotorChannel {
  int motor = -1;  ///< -1: of no motor
  Quantity quantity = Quantity::position;
};
MotorChannel motor_channel(const model::PlanarModel& model, const std::string& name);

/// One channel of a simulation, a value a sample: a motor's position, velocity, torque, current,
/// voltage or duty, bus_voltage, imu_pitch, imu_pitch_velocity, a coordinate or its velocity.
/// Misuse: others.
Eigen::RowVectorXd raw_channel(const model::PlanarModel& model, const Simulation& simulation,
                               const std::string& name);

/// The same as motion capture sees it: x, z and their rates are those of the point that it tracks,
///   y = R(-tilt) ([x z] + R(pitch) point),  R(a) [x z] = [cos a x + sin a z, cos a z - sin a x],
/// every other channel as it is.
Eigen::RowVectorXd tracked_channel(const Plant& plant, const Simulation& simulation,
                                   const std::string& name);

/// Linear between values on a uniform grid from zero, held at its ends.
double interpolate(const Eigen::Ref<const Eigen::RowVectorXd, 0, Eigen::InnerStride<>>& values,
                   double step, double time);

/// y of y' = (v - y)/T, T: `time` [s], at the samples of v, which is linear between them and has
/// stood at its first value before. With h the step and s v's slope there,
///   y_(k+1) = v_(k+1) - T s + (y_k - v_k + T s) e^(-h/T),
/// which is v itself at T = 0, with the slope -v' by T.
Eigen::RowVectorXd low_passed(Eigen::RowVectorXd values, double step, double time);

}  // namespace jaculus::simulation
