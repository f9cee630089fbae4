#include "simulation/channel_values.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace jaculus {

double value_or(const std::map<std::string, double>& values, const std::string& key, double otherwise) {
  const auto found = values.find(key);
  return found == values.end() ? otherwise : found->second;
}

Eigen::RowVectorXd raw_channel(const PlanarModel& model, const Simulation& s, const std::string& name) {
  for (std::size_t m = 0; m < model.motors.size(); ++m) {
    const std::string& joint = model.motors[m].joint;
    const auto row = static_cast<Eigen::Index>(m);
    if (name == joint) return s.motor_position.row(row);
    if (name == joint + "_velocity") return s.motor_velocity.row(row);
    if (name == joint + "_torque") return s.torque.row(row);
    if (name == joint + "_current") return s.current.row(row);
    if (name == joint + "_voltage") return s.voltage.row(row);
    if (name == joint + "_duty") return s.voltage.row(row).array() / s.bus_voltage.transpose().array();
  }
  if (name == "bus_voltage") return s.bus_voltage.transpose();
  if (name == "imu_pitch") return s.q.row(model.coordinate_index("pitch"));
  if (name == "imu_pitch_velocity") return s.v.row(model.coordinate_index("pitch"));
  if (const int i = model.coordinate_index(name); i >= 0) return s.q.row(i);
  const std::string suffix = "_velocity";
  const int i = name.ends_with(suffix) ? model.coordinate_index(name.substr(0, name.size() - suffix.size())) : -1;
  assert(i >= 0 && "channels are checked where they are read");
  return s.v.row(i);
}

double interpolate(const Eigen::Ref<const Eigen::RowVectorXd, 0, Eigen::InnerStride<>>& values, double step,
                   double time) {
  if (values.size() == 1) return values[0];
  const auto last = static_cast<double>(values.size() - 1);
  const double place = std::clamp(time / step, 0.0, last);
  const auto left = static_cast<Eigen::Index>(std::min(std::floor(place), last - 1.0));
  const double share = place - static_cast<double>(left);
  return (1.0 - share) * values[left] + share * values[left + 1];
}

}  // namespace jaculus
