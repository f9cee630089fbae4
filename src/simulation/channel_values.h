#pragma once
// What a sensor could show of a simulation at best: values of its channels, and those between the samples.

#include <map>
#include <string>

#include "jaculus/simulation/simulate.h"

namespace jaculus {

double value_or(const std::map<std::string, double>& values, const std::string& key, double otherwise);

/// One channel of a simulation, a value a sample: a motor's joint with nothing, _velocity, _torque, _current, _voltage or _duty
/// behind it, bus_voltage, imu_pitch, imu_pitch_velocity, or a coordinate with nothing or _velocity behind it. Misuse: others.
Eigen::RowVectorXd raw_channel(const PlanarModel& model, const Simulation& simulation, const std::string& name);

/// Linear between values on a uniform grid from zero, held at its ends.
double interpolate(const Eigen::Ref<const Eigen::RowVectorXd, 0, Eigen::InnerStride<>>& values, double step,
                   double time);

}  // namespace jaculus
