#include "jaculus/testbed/trials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "jaculus/core/error.h"
#include "jaculus/core/tasks.h"
#include "jaculus/model/robot.h"
#include "testbed/commands.h"
#include "testbed/mjcf.h"

namespace jaculus::testbed {
namespace {

using Random = std::mt19937_64;

double value_of(const std::map<std::string, double>& values, const std::string& key, double otherwise) {
  const auto found = values.find(key);
  return found == values.end() ? otherwise : found->second;
}

/// What the dataset asks for, as commands; the pose it states wins over the plan's.
PlanCommands commands_of(const Dataset& asked, const RobotFiles& files) {
  PlanCommands out;
  const StatedController& stated = asked.controller;
  if (asked.plan) {
    out = plan_commands(*asked.plan, files, stated.quantity, asked.folder / "plan.csv");
  } else {
    if (!asked.script) throw InputError("the experiment has neither plan nor input; allowed: one of the two");
    out.commands.quantity = asked.script->quantity;
    out.commands.motors = asked.script->joints;
    out.commands.time = asked.script->time;
    out.commands.feedforward = asked.script->values;
    out.duration = asked.script->time[asked.script->time.size() - 1];
    for (const std::string& motor : out.commands.motors) {
      if (std::find(files.planar_motors.begin(), files.planar_motors.end(), motor) != files.planar_motors.end())
        continue;
      throw InputError(fmt::format("input: '{}' is no motor of the robot '{}'", motor, files.name));
    }
    if (asked.script->quantity == "torque") {
      for (std::size_t i = 0; i < out.commands.motors.size(); ++i) {
        const auto drive = std::find_if(files.drives.begin(), files.drives.end(),
                                        [&](const Drive& d) { return d.planar == out.commands.motors[i]; });
        out.commands.feedforward.row(static_cast<Eigen::Index>(i)) /= drive->motor.gear * drive->motor.efficiency;
      }
    }
  }
  out.commands.rate_hz = stated.rate_hz;
  out.commands.relax_after_end = stated.after_end == "relax";
  out.commands.repeat_after_end = stated.after_end == "repeat" || asked.script.has_value();
  const auto gain = [](const std::map<std::string, StatedGain>& gains, const std::string& joint) {
    auto found = gains.find(joint);
    if (found == gains.end()) found = gains.find("*");
    return found == gains.end() ? 0.0 : found->second.range.lower;
  };
  for (const std::string& motor : out.commands.motors) {
    out.commands.kp[motor] = gain(stated.kp, motor);
    out.commands.kd[motor] = gain(stated.kd, motor);
  }
  for (const auto& [name, value] : asked.initial) out.start[name] = value;
  return out;
}

/// One trial's measuring: the recording as each stream sees it.
class Observer {
 public:
  Observer(const Recording& recording, const Changes& changes, const TrialSpec& spec, double end, Random& random)
      : r_(recording), changes_(changes), spec_(spec), end_(end), random_(random) {}

  Stream mocap() {
    const SensorSpec& s = spec_.sensors;
    Stream stream = begin("mocap", s.mocap_rate_hz);
    const Vector x = base(0).array() - r_.base(0, 0), z = base(1), pitch = base(2).array() - r_.base(2, 0);
    add(stream, "x", "m", value_of(changes_.scale, "x", 1.0) * x, s.mocap_position);
    add(stream, "z", "m", value_of(changes_.scale, "z", 1.0) * z, s.mocap_position);
    add(stream, "pitch", "rad", value_of(changes_.scale, "pitch", 1.0) * pitch, s.mocap_angle);
    if (s.mocap_lost > 0.0 && !spec_.exact) lose(stream, s.mocap_lost);
    return stream;
  }

  Stream joints() {
    const SensorSpec& s = spec_.sensors;
    Stream stream = begin("joints", s.joints_rate_hz);
    std::vector<std::string> planar;
    for (const std::string& name : r_.motor_of) {
      if (std::find(planar.begin(), planar.end(), name) == planar.end()) planar.push_back(name);
    }
    for (const std::string& name : planar) add_joint(stream, name);
    if (s.electric && r_.voltage.cwiseAbs().maxCoeff() > 0.0) {
      for (const std::string& name : planar) {
        add(stream, name + "_current", "A", mean(name, [&](Eigen::Index i) { return plain(r_.current.row(i)); }),
            s.ammeter);
        add(stream, name + "_duty", "-", mean(name, [&](Eigen::Index i) { return plain(r_.duty.row(i)); }), 0.0);
      }
      add(stream, "bus_voltage", "V", plain(r_.bus_voltage.transpose()), s.voltmeter);
    }
    if (s.imu) {
      add(stream, "imu_pitch", "rad", base(2), s.imu_angle);
      add(stream, "imu_pitch_velocity", "rad/s", plain(r_.base_rate.row(2)), s.imu_rate);
    }
    return stream;
  }

 private:
  Stream begin(const std::string& name, double rate) {
    std::uniform_real_distribution<double> phase(0.0, 1.0);
    std::normal_distribution<double> shift(0.0, spec_.clock_scatter);
    // The clock's zero is off by `shift_`; the first sample falls anywhere in a period.
    const double first = spec_.exact ? 0.0 : phase(random_) / rate;
    clock_ = spec_.exact ? 0.0 : shift(random_);
    Stream stream;
    stream.name = name;
    stream.rate_hz = rate;
    const auto samples = static_cast<Eigen::Index>(std::floor((end_ - first) * rate + 1e-6)) + 1;
    stream.time.resize(samples);
    for (Eigen::Index k = 0; k < samples; ++k) stream.time[k] = first + static_cast<double>(k) / rate;
    moment_ = stream.time.array() - clock_ - value_of(changes_.latency, name, 0.0);
    stream.values.resize(0, samples);
    return stream;
  }

  [[nodiscard]] Vector base(Eigen::Index row) const {
    return sample(r_.time, r_.base.row(row).transpose(), r_.base_rate.row(row).transpose(), moment_);
  }

  [[nodiscard]] Vector plain(const Eigen::Ref<const Eigen::RowVectorXd>& values) const {
    return sample(r_.time, values.transpose(), moment_);
  }

  /// Over the sides of a planar joint.
  template <class Function>
  [[nodiscard]] Vector mean(const std::string& planar, Function&& of) const {
    Vector sum = Vector::Zero(moment_.size());
    int count = 0;
    for (std::size_t i = 0; i < r_.motor_of.size(); ++i) {
      if (r_.motor_of[i] != planar) continue;
      sum += of(static_cast<Eigen::Index>(i));
      ++count;
    }
    return sum / count;
  }

  void add_joint(Stream& stream, const std::string& name) {
    const SensorSpec& s = spec_.sensors;
    const double scale = value_of(changes_.scale, name, 1.0), offset = value_of(changes_.joint_offset, name, 0.0);
    std::normal_distribution<double> normal;
    const Vector angle = mean(name, [&](Eigen::Index i) {
      Vector seen = scale * sample(r_.time, r_.position.row(i).transpose(), r_.velocity.row(i).transpose(), moment_);
      seen.array() += offset;
      if (spec_.exact) return seen;
      for (double& q : seen) q = s.encoder_step * std::round((q + s.encoder * normal(random_)) / s.encoder_step);
      return seen;
    });
    append(stream, name, "rad", angle);
    if (!s.rates) return;
    const Vector rate = mean(name, [&](Eigen::Index i) {
      Vector seen = scale * plain(r_.velocity.row(i));
      if (spec_.exact) return seen;
      for (double& v : seen) v += s.tachometer * normal(random_);
      return seen;
    });
    append(stream, name + "_velocity", "rad/s", rate);
  }

  void add(Stream& stream, const std::string& name, const std::string& unit, Vector values, double noise) {
    std::normal_distribution<double> normal;
    if (!spec_.exact && noise > 0.0) {
      for (double& v : values) v += noise * normal(random_);
    }
    append(stream, name, unit, values);
  }

  static void append(Stream& stream, const std::string& name, const std::string& unit, const Vector& values) {
    stream.channels.push_back(name);
    stream.units.push_back(unit);
    stream.values.conservativeResize(stream.values.rows() + 1, Eigen::NoChange);
    stream.values.row(stream.values.rows() - 1) = values.transpose();
  }

  /// Markers hidden for one to five samples at a time.
  void lose(Stream& stream, double share) {
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::uniform_int_distribution<int> length(1, 5);
    for (Eigen::Index k = 1; k < stream.values.cols();) {
      if (unit(random_) > share / 3.0) {
        ++k;
        continue;
      }
      for (int i = length(random_); i > 0 && k < stream.values.cols(); --i) stream.values.col(k++).setConstant(kNaN);
    }
  }

  const Recording& r_;
  const Changes& changes_;
  const TrialSpec& spec_;
  double end_, clock_ = 0.0;
  Vector moment_;  ///< when each sample of the present stream was really taken [s]
  Random& random_;
};

bool base_fixed(const Dataset& asked, const RobotFiles& files) {
  return asked.experiment == "tail_bench" || !files.floating;
}

/// Plays a trial, from whose generator the observer then draws.
Recording play_trial(const Dataset& asked, const RobotFiles& files, const PlanCommands& plan, const Changes& changes,
                     const TrialSpec& spec, Random& random) {
  std::normal_distribution<double> normal;
  PlayOptions options;
  options.floor = asked.experiment == "leap";
  options.base_fixed = base_fixed(asked, files);
  options.stops = !asked.stops.empty();
  options.start = plan.start;
  options.duration = plan.duration + spec.after + 0.01;
  for (const auto& [joint, offset] : spec.start_offset) {
    options.start[joint] += offset;
    options.level = options.floor;
  }
  if (!spec.exact) {
    for (const std::string& motor : files.planar_motors) options.start[motor] += spec.pose_scatter * normal(random);
    // Nobody sets a joint beyond its stop.
    for (const auto& [joint, stop] : asked.stops)
      options.start[joint] = std::clamp(options.start[joint], stop.range.lower, stop.range.upper);
    options.level = options.floor;
    options.sensors = {spec.sensors.encoder_step, spec.sensors.encoder, spec.sensors.tachometer, random()};
  }
  Recording recording = play(files, changes, plan.commands, options, Numerics{});
  if (recording.diverged) {
    throw std::runtime_error(fmt::format("the MuJoCo robot was lost at {:.4f} s", recording.end_time));
  }
  return recording;
}

/// By how much motors of one planar joint part, until the commands end.
double most_apart(const Recording& r, double end) {
  const auto count = std::upper_bound(r.time.begin(), r.time.end(), end) - r.time.begin();
  double most = 0.0;
  for (Eigen::Index i = 1; i < r.position.rows(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (r.motor_of[at] == r.motor_of[at - 1])
      most = std::max(most, (r.position.row(i) - r.position.row(i - 1)).head(count).cwiseAbs().maxCoeff());
  }
  return most;
}

Trial one_trial(const Dataset& asked, const RobotFiles& files, const PlanCommands& plan, const Changes& changes,
                const TrialSpec& spec, int index, double& legs_apart) {
  Random random(task_seed(spec.seed, static_cast<std::uint64_t>(index)));
  const Recording recording = play_trial(asked, files, plan, changes, spec, random);
  legs_apart = std::max(legs_apart, most_apart(recording, plan.duration));
  const double end = plan.duration + spec.after;
  Observer observer(recording, changes, spec, end, random);
  Trial trial;
  trial.name = fmt::format("trial_{:02}", index + 1);
  const bool held = base_fixed(asked, files);
  if (spec.sensors.mocap && !held) trial.streams.push_back(observer.mocap());
  if (spec.sensors.joints || held) trial.streams.push_back(observer.joints());
  return trial;
}

}  // namespace

Dataset run_trials(const Dataset& asked, const Changes& changes, const TrialSpec& spec, double* legs_apart) {
  const RobotFiles files = read_robot_files(find_robot(asked.robot, asked.folder));
  const PlanCommands plan = commands_of(asked, files);
  Dataset out = asked;
  out.trials.clear();
  double apart = 0.0;
  for (int i = 0; i < spec.trials; ++i) out.trials.push_back(one_trial(asked, files, plan, changes, spec, i, apart));
  if (legs_apart != nullptr) *legs_apart = apart;
  return out;
}

double channel_floor(const std::string& channel, const std::string& unit, const SensorSpec& s) {
  const double sides = channel.starts_with("tail") ? 1.0 : 2.0;
  if (channel == "x" || channel == "z") return s.mocap_position;
  if (channel == "pitch") return s.mocap_angle;
  if (channel == "imu_pitch") return s.imu_angle;
  if (channel == "imu_pitch_velocity") return s.imu_rate;
  if (unit == "rad") return std::hypot(s.encoder, s.encoder_step / std::sqrt(12.0)) / std::sqrt(sides);
  if (unit == "rad/s") return s.tachometer / std::sqrt(sides);
  return kNaN;  // currents and the like are inputs of the motion rather than the motion
}

Vector bends(const Vector& y) {
  const Eigen::Index n = y.size();
  Vector own = Vector::Zero(n), most = own;
  if (n > 2) own.segment(1, n - 2) = (y.tail(n - 2) - 2.0 * y.segment(1, n - 2) + y.head(n - 2)).cwiseAbs();
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index from = std::max<Eigen::Index>(0, k - 1), to = std::min(k + 1, n - 1);
    most[k] = own.segment(from, to - from + 1).maxCoeff();
  }
  return most;
}

namespace {

/// Mean square of a difference in noise floors. A sample beside a jump says when rather than how much: its floor is half of what the run
/// bends there.
double mean_square(const Vector& was, const Vector& is, double floor) {
  const Vector most = bends(was).cwiseMax(bends(is));
  return ((is - was).array().square() / (floor * floor + 0.25 * most.array().square())).mean();
}

}  // namespace

double gap(const Dataset& a, const Dataset& b, const SensorSpec& sensors) {
  double sum = 0.0;
  int channels = 0;
  for (std::size_t t = 0; t < a.trials.size(); ++t) {
    for (const Stream& stream : a.trials[t].streams) {
      const Stream* other = b.trials.at(t).stream(stream.name);
      for (std::size_t c = 0; c < stream.channels.size(); ++c) {
        const double floor = channel_floor(stream.channels[c], stream.units[c], sensors);
        if (std::isnan(floor)) continue;
        const auto row = static_cast<Eigen::Index>(c);
        sum += mean_square(stream.values.row(row).transpose(), other->values.row(row).transpose(), floor);
        ++channels;
      }
    }
  }
  return channels == 0 ? 0.0 : std::sqrt(sum / channels);
}

}  // namespace jaculus::testbed
