#include "testbed/noise_floor.h"

#include <algorithm>
#include <cmath>

namespace jaculus::testbed {
namespace {

/// Mean square of a difference in noise floors. A sample beside a jump says when rather than how
/// much: its floor is half of what the run bends there.
double mean_square(const Vector& was, const Vector& is, double floor) {
  const Vector most = bends(was).cwiseMax(bends(is));
  return ((is - was).array().square() / (floor * floor + 0.25 * most.array().square())).mean();
}

}  // namespace

double channel_floor(const std::string& channel, const std::string& unit, const SensorSpec& s,
                     const RobotFiles& robot) {
  if (channel == "x" || channel == "z") return s.mocap_position;
  if (channel == "pitch") return s.mocap_angle;
  if (channel == "imu_pitch") return s.imu_angle;
  if (channel == "imu_pitch_velocity") return s.imu_rate;

  const trajectory::ChannelName name = trajectory::parse_channel(channel);
  if (name.quantity == trajectory::Quantity::apart) return kNaN;  // no model of the plane has it
  const double sides = std::max(1, count_of(robot.sides_of(name.of)));
  if (unit == "rad")
    return std::hypot(s.encoder, s.encoder_step / std::sqrt(12.0)) / std::sqrt(sides);
  if (unit == "rad/s") return s.tachometer / std::sqrt(sides);
  return kNaN;  // currents and the like are inputs of the motion rather than the motion
}

Vector bends(const Vector& y) {
  const Eigen::Index n = y.size();
  Vector own = Vector::Zero(n), most = own;
  if (n > 2)
    own.segment(1, n - 2) = (y.tail(n - 2) - 2.0 * y.segment(1, n - 2) + y.head(n - 2)).cwiseAbs();
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index from = std::max<Eigen::Index>(0, k - 1), to = std::min(k + 1, n - 1);
    most[k] = own.segment(from, to - from + 1).maxCoeff();
  }
  return most;
}

double gap(const trajectory::Dataset& a, const trajectory::Dataset& b, const SensorSpec& sensors,
           const RobotFiles& robot) {
  double sum = 0.0;
  int channels = 0;
  for (std::size_t t = 0; t < a.trials.size(); ++t) {
    for (const trajectory::Stream& stream : a.trials[t].streams) {
      const trajectory::Stream* other = b.trials.at(t).stream(stream.name);
      for (int c = 0; c < count_of(stream.channels); ++c) {
        const double floor = channel_floor(stream.channels[c], stream.units[c], sensors, robot);
        if (std::isnan(floor)) continue;
        sum +=
            mean_square(stream.values.row(c).transpose(), other->values.row(c).transpose(), floor);
        ++channels;
      }
    }
  }
  return channels == 0 ? 0.0 : std::sqrt(sum / channels);
}

}  // namespace jaculus::testbed
