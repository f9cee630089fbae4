#include "testbed/loop.h"

#include <algorithm>
#include <cmath>

#include "jaculus/trajectory/dataset.h"
#include "testbed/joint_laws.h"

namespace jaculus::testbed {
namespace {

constexpr double kBurstPeriod = 0.1;  ///< of packets that get lost [s]

/// A driver's full command in the quantity that it hears: the torque limit, all duty, the bus.
double full_command(const Drive& drive, const JointSize& size, trajectory::Quantity quantity) {
  if (quantity == trajectory::Quantity::torque) return size.motor_torque;
  return quantity == trajectory::Quantity::duty ? 1.0 : drive.motor.voltage;
}

/// Cubic through two places and rates at a share s of the interval `h`.
double hermite(double p0, double v0, double p1, double v1, double h, double s) {
  const double a = p0 + s * h * v0, b = p1 - (1.0 - s) * h * v1;
  const double w = s * s * (3.0 - 2.0 * s);
  // p = p0 (1 - w) + p1 w + h s (1-s) (v0 (1-s) - v1 s), written with the two tangents a and b
  return (1.0 - w) * p0 + w * p1 + (1.0 - s) * (1.0 - s) * (a - p0) + s * s * (b - p1);
}

}  // namespace

Loop::Loop(const RobotFiles& files, const Changes& changes, const Commands& commands,
           const LoopSensors& sensors)
    : commands_(commands), outside_(changes.outside), sensors_(sensors), random_(sensors.seed) {
  period_ = 1.0 / commands.rate_hz;
  delay_ = changes.delay;
  late_ = changes.late_start;
  latency_ = value_of(changes.latency, trajectory::kJointStream, 0.0);
  for (const Drive& drive : files.drives) {
    const auto found = std::find(commands.motors.begin(), commands.motors.end(), drive.planar);
    row_.push_back(found == commands.motors.end() ? -1 : found - commands.motors.begin());
    kp_.push_back(changes.gain_p * drive.gain_p * value_of(commands.kp, drive.planar, 0.0));
    kd_.push_back(changes.gain_d * drive.gain_d * value_of(commands.kd, drive.planar, 0.0));
    gear_.push_back(drive.motor.gear);
    scale_.push_back(value_of(changes.scale, drive.planar, 1.0));
    offset_.push_back(drive.encoder_zero + value_of(changes.joint_offset, drive.planar, 0.0));
    sizes_.push_back(size_of(files, drive));
    full_.push_back(full_command(drive, sizes_.back(), commands.quantity));
  }
  now_.assign(files.drives.size(), kNaN);
  driven_.assign(files.drives.size(), 0.0);
}

double Loop::instant() const { return late_ + static_cast<double>(index_) * period_; }

double Loop::read_time() const { return std::max(0.0, instant() - latency_); }

double Loop::next() const {
  return std::min(read_time(), sent_.empty() ? kInfinity : sent_.front().arrives);
}

void Loop::update(double t, const std::vector<double>& angles, const std::vector<double>& rates) {
  while (read_time() <= t + 1e-12) {
    std::vector<double> commands = evaluate(instant() - late_, angles, rates);
    if (!loses()) {
      for (std::size_t i = 0; i < commands.size(); ++i) commands[i] = driven(i, commands[i]);
      sent_.push_back({instant() + delay_, std::move(commands)});
    }
    ++index_;
  }
  while (!sent_.empty() && sent_.front().arrives <= t + 1e-12) {
    now_ = sent_.front().commands;
    waiting_ = false;
    sent_.pop_front();
  }
}

bool Loop::loses() const {
  const CommandDisturbances& o = outside_.commands;
  if (o.lost_time == 0.0 || index_ == 0) return false;
  return std::fmod(instant() + o.lost_phase, kBurstPeriod) < o.lost_time;
}

double Loop::driven(std::size_t i, double command) {
  const CommandDisturbances& o = outside_.commands;
  if (std::isnan(command)) {
    driven_[i] = 0.0;
    return command;
  }

  const double dead = o.dead_band * full_[i], step = o.step * full_[i];
  if (dead > 0.0) command -= std::clamp(command, -dead, dead);
  if (step > 0.0) command = step * std::round(command / step);
  if (o.slew_time > 0.0) {
    const double most = full_[i] * period_ / o.slew_time;
    command = driven_[i] + std::clamp(command - driven_[i], -most, most);
  }
  return driven_[i] = command;
}

std::vector<double> Loop::evaluate(double moment, const std::vector<double>& angles,
                                   const std::vector<double>& rates) {
  std::normal_distribution<double> normal;
  std::vector<double> out(row_.size(), kNaN);
  const Vector& time = commands_.time;
  const double end = time[time.size() - 1];
  const bool ended = moment >= end;
  const double at = std::clamp(moment, 0.0, end);
  Eigen::Index k = 0;
  while (k + 1 < time.size() && time[k + 1] <= at + 1e-12) ++k;

  const Eigen::Index l = std::min(k + 1, time.size() - 1);
  const double h = time[l] - time[k], s = h > 0.0 ? std::clamp((at - time[k]) / h, 0.0, 1.0) : 0.0;
  for (std::size_t i = 0; i < row_.size(); ++i) {
    if (row_[i] < 0 || (ended && commands_.relax_after_end)) continue;
    const Eigen::Index r = row_[i];
    const bool tracks = commands_.position.size() > 0;
    double value = ended && !commands_.repeat_after_end ? 0.0 : commands_.feedforward(r, k);
    if (commands_.linear && !ended) {
      value += s * (commands_.feedforward(r, l) - commands_.feedforward(r, k));
    }
    if (tracks) {
      const double step = sensors_.resolution / gear_[i];
      const JointDisturbances& o = outside_.joints;
      double seen = scale_[i] * angles[i] + offset_[i] + sensors_.position_noise * normal(random_);
      seen += misreading(o, sizes_[i], angles[i]);
      if (step > 0.0) seen = step * std::round(seen / step);
      const double speed = (scale_[i] + misreading_rate(o, sizes_[i], angles[i])) * rates[i] +
                           sensors_.rate_noise * normal(random_);
      const auto& p = commands_.position;
      const auto& v = commands_.velocity;
      const double place = hermite(p(r, k), v(r, k), p(r, l), v(r, l), h, s);
      const double rate = ended ? 0.0 : v(r, k) + s * (v(r, l) - v(r, k));
      value += gear_[i] * (kp_[i] * (place - seen) + kd_[i] * (rate - speed));
    }
    out[i] = value;
  }

  return out;
}

}  // namespace jaculus::testbed
