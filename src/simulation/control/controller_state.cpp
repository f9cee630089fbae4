#include "simulation/control/controller_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"
#include "simulation/control/command_lag.h"
#include "simulation/plant/named_values.h"

namespace jaculus::simulation::detail {

namespace {

void check_reference(const Controller& c, const model::PlanarModel& model) {
  const auto count = std::ssize(c.reference.motors);
  std::vector<std::string> known;
  for (const model::PlanarMotor& motor : model.motors) known.push_back(motor.joint);
  for (const std::string& name : c.reference.motors) {
    if (model.motor_index(name) >= 0) continue;
    const auto near = yaml::nearest_name(name, known);
    throw InputError(
        fmt::format("the reference is for another robot: this one has no motor at '{}'{}", name,
                    near ? fmt::format("; did it mean '{}'?", *near) : ""));
  }

  if (!(c.rate_hz > 0.0))
    throw InputError(fmt::format("controller: rate {} Hz; it must be positive", c.rate_hz));
  const auto fits = [&](const Matrix& m, bool may_lack) {
    return (may_lack && m.size() == 0) ||
           (m.rows() == count && m.cols() == c.reference.time.size());
  };

  if (!fits(c.reference.feedforward, true) || !fits(c.reference.position, true) ||
      !fits(c.reference.velocity, true))
    throw InputError("the reference's samples don't match its motors and times");
  if (c.after_end == AfterEnd::pose && (c.reference.position.size() == 0 ||
                                        c.landing_pose.size() != count || !(c.landing_time > 0.0)))
    throw InputError(
        "controller: a landing pose needs positions in the reference, a value a motor and a time "
        "above 0");
  for (const Vector* gains : {&c.kp, &c.kd})
    if (gains->size() != 0 && gains->size() != count)
      throw InputError(fmt::format("controller: {} gains for {} motors", gains->size(), count));
}

}  // namespace

ControllerState::ControllerState(const Plant& plant, const Controller& controller)
    : controller_(controller),
      rate_(controller.rate_hz),
      delay_(plant.actuation.delay),
      lag_(plant.actuation.lag),
      velocity_filter_(plant.actuation.velocity_filter),
      late_(plant.actuation.late_start),
      latency_(value_or(plant.sensing.latency, trajectory::kJointStream, 0.0)),
      scale_(plant.actuation.feedforward_scale),
      continuous_(std::isinf(controller.rate_hz)) {
  const model::PlanarModel& model = plant.model;
  check_reference(controller, model);
  if (delay_ < 0.0 || lag_ < 0.0 || late_ < 0.0 || latency_ < 0.0 || velocity_filter_ < 0.0)
    throw InputError(
        "actuation: delay, lag, late start, filter of rates and latency of sensors can't be "
        "negative");

  now_.resize(model.motors.size());
  bool feedback = false;
  for (int k = 0; k < count_of(controller.reference.motors); ++k) {
    const std::string& joint = controller.reference.motors[k];
    const std::string rate = channel_name(joint, Quantity::velocity);
    const auto gain = [k](const Vector& gains, double scale) {
      return gains.size() == 0 ? 0.0 : gains[k] * scale;
    };

    Loop loop;
    loop.motor = model.motor_index(joint);
    loop.kp = gain(controller.kp, plant.actuation.gain_scale_p);
    loop.kd = gain(controller.kd, plant.actuation.gain_scale_d);
    loop.gear = model.motors[loop.motor].gear;
    loop.position_scale = value_or(plant.sensing.scale, joint, 1.0);
    loop.position_offset = value_or(plant.sensing.offset, joint, 0.0);
    loop.velocity_scale = value_or(plant.sensing.scale, rate, 1.0);
    loop.velocity_offset = value_or(plant.sensing.offset, rate, 0.0);
    feedback = feedback || loop.kp != 0.0 || loop.kd != 0.0;
    loops_.push_back(loop);
  }

  if (continuous_ && feedback &&
      (delay_ > 0.0 || lag_ > 0.0 || latency_ > 0.0 || velocity_filter_ > 0.0))
    throw InputError(
        "controller: feedback without a rate can't be delayed nor its rates filtered; give it a "
        "rate");
  if (continuous_ && lag_ > 0.0) lagged_ = lagged(controller.reference, lag_);
}

double ControllerState::read_instant(double k) const {
  return std::max(0.0, instant(k) - latency_);
}

double ControllerState::next_change(double t) const {
  if (!continuous_) {  // sampled
    const double read = read_instant(next_read_),
                 arrival = queue_.empty() ? kInfinity : queue_.front().time;
    return std::min(read, arrival);
  }
  const double shift = late_ + delay_;
  if (t < shift) return shift;
  // Borders of the feed-forward; with linear ones these are kinks.
  const Vector& time = reference().time;
  for (Eigen::Index k = std::max<Eigen::Index>(sample_, 0); k < time.size(); ++k)
    if (time[k] + shift > t) return time[k] + shift;
  const double end = reference().duration + shift;
  if (end > t) return end;
  const double landed =
      controller_.after_end == AfterEnd::pose ? end + controller_.landing_time : end;
  return landed > t ? landed : kInfinity;
}

void ControllerState::update(double t, const double* position, const double* velocity) {
  if (continuous_) {
    if (t >= late_ + delay_) waiting_ = false;
    find_segment(t - delay_ - late_);
    return;
  }
  while (read_instant(next_read_) <= t) {
    // The values are read now; the reference is that of the sample's own instant.
    queue_.push_back({instant(next_read_) + delay_, now_});
    find_segment(instant(next_read_) - late_);
    evaluate(instant(next_read_) - late_, position, filtered(velocity), queue_.back().commands);
    next_read_ += 1.0;
  }
  while (!queue_.empty() && queue_.front().time <= t) {
    now_ = queue_.front().commands;
    if (lag_ > 0.0) lag_behind(now_);
    queue_.pop_front();
    waiting_ = false;
  }
}

const double* ControllerState::filtered(const double* velocity) {
  if (velocity_filter_ == 0.0) return velocity;
  if (seen_.empty()) seen_.assign(velocity, velocity + now_.size());
  const double weight = 1.0 / (1.0 + velocity_filter_ * rate_);
  for (std::size_t m = 0; m < seen_.size(); ++m) seen_[m] += weight * (velocity[m] - seen_[m]);
  return seen_.data();
}

/// What the motors make of commands over the hold that begins.
void ControllerState::lag_behind(std::vector<Command>& commands) {
  const bool first = made_.empty();
  made_.resize(commands.size());
  for (std::size_t m = 0; m < commands.size(); ++m) {
    Command& command = commands[m];
    if (first) made_[m] = command.value;
    command.value = held_mean(lag_, 1.0 / rate_, command.value, made_[m]);
  }
}

const Command* ControllerState::commands(double t, const double* position, const double* velocity) {
  if (continuous_) evaluate(t - delay_ - late_, position, velocity, now_);
  return now_.data();
}

/// The part of the reference that holds from its time `at` on: its sample, and whether it has
/// ended.
void ControllerState::find_segment(double at) {
  const Reference& r = reference();
  ended_ = r.time.size() == 0 || (at >= r.duration && at > 0.0);
  while (sample_ + 1 < r.time.size() && r.time[sample_ + 1] <= at) ++sample_;
}

/// On the way from the reference's end to the pose to land in, or there.
ControllerState::Wanted ControllerState::landing(Eigen::Index row, double at) const {
  const Reference& r = reference();
  const double length = controller_.landing_time, pose = controller_.landing_pose[row];
  const double s = std::min(1.0, (at - r.duration) / length), c = 1.0 - s;
  const double from = r.position(row, sample_),
               rate = r.velocity.size() > 0 ? r.velocity(row, sample_) : 0.0;
  Wanted w;
  w.position =
      (1.0 + 2.0 * s) * c * c * from + s * c * c * length * rate + s * s * (3.0 - 2.0 * s) * pose;
  w.velocity = 6.0 * s * c * (pose - from) / length + c * (1.0 - 3.0 * s) * rate;
  return w;
}

ControllerState::Wanted ControllerState::wanted(Eigen::Index row, double at) const {
  const Reference& r = reference();
  if (ended_ && controller_.after_end == AfterEnd::pose) return landing(row, at);
  const Eigen::Index k = sample_, next = std::min(k + 1, r.time.size() - 1);
  const double length = r.time[next] - r.time[k];
  const double s = length > 0.0 ? (at - r.time[k]) / length : 0.0, c = s - 1.0;
  Wanted w;
  const bool moves = !ended_;
  if (r.feedforward.size() > 0 && (!ended_ || controller_.after_end == AfterEnd::repeat)) {
    w.feedforward = r.feedforward(row, k);
    if (r.linear) w.feedforward += s * (r.feedforward(row, next) - w.feedforward);
  }

  const bool rates = r.velocity.size() > 0;
  const double v0 = rates ? r.velocity(row, k) : 0.0, v1 = rates ? r.velocity(row, next) : 0.0;
  if (rates && moves) w.velocity = v0 + s * (v1 - v0);
  if (r.position.size() == 0) return w;
  const double p0 = r.position(row, k), p1 = r.position(row, next);

  // Cubic through positions and rates; straight where there are no rates.
  w.position = !moves || length == 0.0 || !rates
                   ? p0 + (moves ? s : 0.0) * (p1 - p0)
                   : (1.0 + 2.0 * s) * c * c * p0 + s * c * c * length * v0 +
                         s * s * (3.0 - 2.0 * s) * p1 + s * s * c * length * v1;
  return w;
}

void ControllerState::evaluate(double at, const double* position, const double* velocity,
                               std::vector<Command>& out) const {
  const Reference& r = reference();
  for (Command& command : out) command = {};
  if (r.time.size() == 0 || (ended_ && controller_.after_end == AfterEnd::relax)) return;
  for (int i = 0; i < count_of(loops_); ++i) {
    const Loop& loop = loops_[i];
    const int m = loop.motor;
    const Wanted w = wanted(i, at);
    double value = scale_ * w.feedforward;
    if (loop.kp != 0.0 && r.position.size() > 0)
      value += loop.kp * loop.gear *
               (w.position - (loop.position_scale * position[m] + loop.position_offset));
    if (loop.kd != 0.0)
      value += loop.kd * loop.gear *
               (w.velocity - (loop.velocity_scale * velocity[m] + loop.velocity_offset));
    out[m] = {true, value};
  }
}

}  // namespace jaculus::simulation::detail
