#include "simulation/experiment/channel_values.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace jaculus::simulation {

MotorChannel motor_channel(const model::PlanarModel& model, const std::string& name) {
  if (const int m = model.motor_index(name); m >= 0) return {m, Quantity::position};

  const trajectory::ChannelName parts = trajectory::parse_channel(name);
  return {model.motor_index(parts.of), parts.quantity};
}

Eigen::RowVectorXd raw_channel(const model::PlanarModel& model, const Simulation& s,
                               const std::string& name) {
  if (const auto [m, quantity] = motor_channel(model, name); m >= 0) {
    if (quantity == Quantity::position) return s.motor_position.row(m);
    if (quantity == Quantity::velocity) return s.motor_velocity.row(m);
    if (quantity == Quantity::torque) return s.torque.row(m);
    if (quantity == Quantity::current) return s.current.row(m);
    if (quantity == Quantity::voltage) return s.voltage.row(m);
    if (quantity == Quantity::duty)
      return s.voltage.row(m).array() / s.bus_voltage.transpose().array();
  }

  if (name == "bus_voltage") return s.bus_voltage.transpose();
  if (name == "imu_pitch") return s.q.row(model.coordinate_index("pitch"));
  if (name == "imu_pitch_velocity") return s.v.row(model.coordinate_index("pitch"));
  if (const int i = model.coordinate_index(name); i >= 0) return s.q.row(i);

  const trajectory::ChannelName parts = trajectory::parse_channel(name);
  const int i = parts.quantity == Quantity::velocity ? model.coordinate_index(parts.of) : -1;
  assert(i >= 0 && "channels are checked where they are read");
  return s.v.row(i);
}

namespace {

/// A coordinate of the base, or its rate; zero where the robot has none.
Eigen::RowVectorXd base_row(const model::PlanarModel& model, const Simulation& s,
                            const std::string& name, bool rate) {
  const int i = model.coordinate_index(name);
  if (i < 0) return Eigen::RowVectorXd::Zero(s.time.size());
  return rate ? s.v.row(i) : s.q.row(i);
}

}  // namespace

Eigen::RowVectorXd tracked_channel(const Plant& plant, const Simulation& s,
                                   const std::string& name) {
  const Vec2& point = plant.sensing.tracked_point;
  const double tilt = plant.sensing.mocap_tilt;
  const bool x = name == "x" || name == "x_velocity", z = name == "z" || name == "z_velocity";
  if ((!x && !z) || (point.isZero(0.0) && tilt == 0.0)) return raw_channel(plant.model, s, name);

  const bool rate = name.size() > 1;
  const Eigen::ArrayXd pitch = base_row(plant.model, s, "pitch", false).transpose().array();
  Eigen::ArrayXd along = pitch.cos() * point.x() + pitch.sin() * point.y();
  Eigen::ArrayXd up = pitch.cos() * point.y() - pitch.sin() * point.x();
  if (rate) {
    const Eigen::ArrayXd turning = base_row(plant.model, s, "pitch", true).transpose().array();
    const Eigen::ArrayXd before = along;
    along = turning * up;
    up = -turning * before;
  }
  along += base_row(plant.model, s, "x", rate).transpose().array();
  up += base_row(plant.model, s, "z", rate).transpose().array();

  const double c = std::cos(tilt), sine = std::sin(tilt);
  if (x) return (c * along - sine * up).matrix().transpose();
  return (c * up + sine * along).matrix().transpose();
}

double interpolate(const Eigen::Ref<const Eigen::RowVectorXd, 0, Eigen::InnerStride<>>& values,
                   double step, double time) {
  if (values.size() == 1) return values[0];
  const int last = count_of(values) - 1;
  const double place = std::clamp<double>(time / step, 0.0, last);
  const double whole = std::min(std::floor(place), last - 1.0);
  const double share = place - whole;
  const Eigen::Index left = std::lround(whole);
  return (1.0 - share) * values[left] + share * values[left + 1];
}

Eigen::RowVectorXd low_passed(Eigen::RowVectorXd values, double step, double time) {
  if (time <= 0.0 || values.size() < 2) return values;
  const double keep = std::exp(-step / time);
  double before = values[0];  // of v
  for (Eigen::Index k = 1; k < values.size(); ++k) {
    const double value = values[k], behind = time * (value - before) / step;
    values[k] = value - behind + keep * (values[k - 1] - before + behind);
    before = value;
  }
  return values;
}

}  // namespace jaculus::simulation
