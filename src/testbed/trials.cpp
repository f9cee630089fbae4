#include "jaculus/testbed/trials.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "jaculus/core/error.h"
#include "jaculus/core/tasks.h"
#include "jaculus/model/robot.h"
#include "jaculus/testbed/playback.h"
#include "testbed/clutter.h"
#include "testbed/commands.h"
#include "testbed/drives.h"
#include "testbed/joint_laws.h"
#include "testbed/loop.h"
#include "testbed/mjcf.h"
#include "testbed/sensor_noise.h"

namespace jaculus::testbed {
namespace {

using Random = std::mt19937_64;

/// One trial's measuring: the recording as each stream sees it.
class Observer {
 public:
  Observer(const Recording& recording, const RobotFiles& files, const Changes& changes,
           const TrialSpec& spec, double end, Random& random)
      : r_(recording), files_(files), changes_(changes), spec_(spec), end_(end), random_(random) {}

  trajectory::Stream mocap() {
    const SensorSpec& s = spec_.sensors;
    trajectory::Stream stream = begin(trajectory::kMocapStream, s.mocap_rate_hz);
    Vector x = base(0), z = base(1);
    const Vector angle = base(2), pitch = angle.array() - r_.base(2, 0);
    const double rest = seen(r_.base.col(0)).x();
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const Vec2 place = seen({x[k], z[k], angle[k]});
      x[k] = place.x() - rest;
      z[k] = place.y();
    }
    add(stream, "x", "m", value_of(changes_.scale, "x", 1.0) * x, s.mocap_position);
    add(stream, "z", "m", value_of(changes_.scale, "z", 1.0) * z, s.mocap_position);
    add(stream, "pitch", "rad", value_of(changes_.scale, "pitch", 1.0) * pitch, s.mocap_angle);
    if (s.mocap_lost > 0.0 && !spec_.exact) lose(stream, s.mocap_lost);
    return stream;
  }

  trajectory::Stream joints() {
    const SensorSpec& s = spec_.sensors;
    trajectory::Stream stream = begin(trajectory::kJointStream, s.joints_rate_hz);
    std::vector<std::string> planar;
    for (const std::string& name : r_.motor_of) {
      if (std::find(planar.begin(), planar.end(), name) == planar.end()) planar.push_back(name);
    }

    for (const std::string& name : planar) add_joint(stream, name);
    if (s.electric && r_.voltage.cwiseAbs().maxCoeff() > 0.0) {
      for (const std::string& name : planar) {
        add_current(stream, name);
        add(stream, channel_name(name, trajectory::Quantity::duty), "-",
            mean(name, [&](Eigen::Index i) { return plain(r_.duty.row(i)); }), 0.0);
      }
      add(stream, "bus_voltage", "V", plain(r_.bus_voltage.transpose()), s.voltmeter);
    }

    if (s.torque)
      for (const std::string& name : planar) add_torque(stream, name);
    if (s.imu) {
      add(stream, "imu_pitch", "rad", base(2), s.imu_angle);
      add(stream, "imu_pitch_velocity", "rad/s", plain(r_.base_rate.row(2)), s.imu_rate);
    }
    if (s.joints_lost > 0.0 && !spec_.exact) lose(stream, s.joints_lost);
    return stream;
  }

 private:
  /// x, z of what motion capture tracks on a base at x, z, pitch, on axes as they are tilted.
  [[nodiscard]] Vec2 seen(const Eigen::Vector3d& base) const {
    const Vec2 point = Eigen::Rotation2D<double>(-base[2]) * changes_.tracked_point;
    return Eigen::Rotation2D<double>(changes_.mocap_tilt) * (base.head<2>() + point);
  }

  trajectory::Stream begin(const std::string& name, double rate) {
    std::uniform_real_distribution<double> phase(0.0, 1.0);
    std::normal_distribution<double> shift(0.0, spec_.clock_scatter);
    // The clock's zero is off by `shift_`; the first sample falls anywhere in a period.
    const double first = spec_.exact ? 0.0 : phase(random_) / rate;
    clock_ = spec_.exact ? 0.0 : shift(random_);
    trajectory::Stream stream;
    stream.name = name;
    stream.rate_hz = rate;
    const Eigen::Index samples = std::lround(std::floor((end_ - first) * rate + 1e-6)) + 1;
    stream.time.resize(samples);
    for (Eigen::Index k = 0; k < samples; ++k)
      stream.time[k] = first + static_cast<double>(k) / rate;
    moment_ =
        (1.0 - draw_drift()) * stream.time.array() - clock_ - value_of(changes_.latency, name, 0.0);
    stream.values.resize(0, samples);
    return stream;
  }

  /// By how much the present stream's clock runs fast [-].
  double draw_drift() {
    const double sd = spec_.sensors.clock_drift;
    return spec_.exact || sd == 0.0 ? 0.0 : std::normal_distribution<double>(0.0, sd)(random_);
  }

  [[nodiscard]] Vector base(Eigen::Index row) const {
    return sample(r_.time, r_.base.row(row).transpose(), r_.base_rate.row(row).transpose(),
                  moment_);
  }

  [[nodiscard]] Vector plain(const Eigen::Ref<const Eigen::RowVectorXd>& values) const {
    return sample(r_.time, values.transpose(), moment_);
  }

  /// Over the sides of a planar joint.
  template <class Function>
  [[nodiscard]] Vector mean(const std::string& planar, Function&& of) const {
    Vector sum = Vector::Zero(moment_.size());
    int count = 0;
    for (int i = 0; i < count_of(r_.motor_of); ++i) {
      if (r_.motor_of[i] != planar) continue;
      sum += of(i);
      ++count;
    }
    return sum / count;
  }

  [[nodiscard]] Vector angle_of(Eigen::Index i) const {
    return sample(r_.time, r_.position.row(i).transpose(), r_.velocity.row(i).transpose(), moment_);
  }

  /// What an encoder out of true reads too much by a law, of the angle or of the rate.
  [[nodiscard]] Vector misread(Eigen::Index i, decltype(&misreading) law) const {
    const JointSize size = size_of(files_, files_.drives[i]);
    const auto at = [&](double q) { return law(changes_.outside.joints, size, q); };
    return angle_of(i).unaryExpr(at);
  }

  void add_joint(trajectory::Stream& stream, const std::string& name) {
    const SensorSpec& s = spec_.sensors;
    const double scale = value_of(changes_.scale, name, 1.0),
                 offset = value_of(changes_.joint_offset, name, 0.0);
    const double dt = 1.0 / s.joints_rate_hz;
    std::vector<Vector> read;  // of each side
    const Vector angle = mean(name, [&](Eigen::Index i) {
      Vector seen = scale * angle_of(i);
      seen.array() += offset + files_.drives[i].encoder_zero;
      seen += misread(i, &misreading);
      if (!spec_.exact) {
        add_noise(seen, s.encoder, dt, s.shape, random_);
        quantise(seen, s.encoder_step);
      }
      read.push_back(seen);
      return seen;
    });
    append(stream, name, "rad", angle);
    add_apart(stream, name, read);
    if (!s.rates) return;

    const Vector rate = mean(name, [&](Eigen::Index i) {
      const Vector of_rate = scale + misread(i, &misreading_rate).array();
      Vector seen = of_rate.cwiseProduct(plain(r_.velocity.row(i)));
      if (!spec_.exact) add_noise(seen, s.tachometer, dt, s.shape, random_);
      return seen;
    });
    append(stream, channel_name(name, trajectory::Quantity::velocity), "rad/s", rate);
  }

  /// What encoders of both sides differ by, of a joint that has two.
  static void add_apart(trajectory::Stream& stream, const std::string& name,
                        const std::vector<Vector>& read) {
    if (read.size() != 2) return;
    append(stream, channel_name(name, trajectory::Quantity::apart), "rad", read[0] - read[1]);
  }

  void add_current(trajectory::Stream& stream, const std::string& name) {
    const SensorSpec& s = spec_.sensors;
    Vector current = mean(name, [&](Eigen::Index i) {
      return Vector(files_.drives[i].current_scale * plain(r_.current.row(i)));
    });
    if (!spec_.exact) low_pass(current, s.ammeter_filter, 1.0 / s.joints_rate_hz);
    add(stream, channel_name(name, trajectory::Quantity::current), "A", current, s.ammeter);
    if (!spec_.exact) quantise_last(stream, s.ammeter_step);
  }

  /// Torque at the joint, as a driver works it out of its current.
  void add_torque(trajectory::Stream& stream, const std::string& name) {
    const SensorSpec& s = spec_.sensors;
    Vector torque = mean(name, [&](Eigen::Index i) {
      const Drive& drive = files_.drives[i];
      return Vector(drive.current_scale * believed_torque(drive, i));
    });
    const double most = torque.cwiseAbs().maxCoeff();
    if (!spec_.exact) low_pass(torque, s.ammeter_filter, 1.0 / s.joints_rate_hz);
    add(stream, channel_name(name, trajectory::Quantity::torque), "N m", torque,
        s.torque_noise * most);
    if (!spec_.exact) quantise_last(stream, s.torque_step * most);
  }

  /// Torque at the joint that a motor believed to be as its files say makes of its current; of an
  /// ideal one, what it was told.
  [[nodiscard]] Vector believed_torque(const Drive& drive, Eigen::Index i) const {
    const model::PlanarMotor& motor = drive.motor;
    if (motor.ideal()) {
      const double own = value_of(changes_.joint_torque_constant, drive.planar, 1.0);
      return plain(r_.torque.row(i)) / (changes_.torque_constant * own * drive.constant);
    }

    const Vector current = plain(r_.current.row(i));
    return motor.gear * motor.efficiency *
           current.unaryExpr([&](double one) { return torque_of_current(motor, one); });
  }

  static void quantise_last(trajectory::Stream& stream, double step) {
    Vector values = stream.values.bottomRows<1>().transpose();
    quantise(values, step);
    stream.values.bottomRows<1>() = values.transpose();
  }

  void add(trajectory::Stream& stream, const std::string& name, const std::string& unit,
           Vector values, double noise) {
    if (!spec_.exact) add_noise(values, noise, 1.0 / stream.rate_hz, spec_.sensors.shape, random_);
    append(stream, name, unit, values);
  }

  static void append(trajectory::Stream& stream, const std::string& name, const std::string& unit,
                     const Vector& values) {
    stream.channels.push_back(name);
    stream.units.push_back(unit);
    stream.values.conservativeResize(stream.values.rows() + 1, Eigen::NoChange);
    stream.values.row(stream.values.rows() - 1) = values.transpose();
  }

  /// Markers hidden for one to five samples at a time.
  void lose(trajectory::Stream& stream, double share) {
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::uniform_int_distribution<int> length(1, 5);
    for (Eigen::Index k = 1; k < stream.values.cols();) {
      if (unit(random_) > share / 3.0) {
        ++k;
        continue;
      }
      for (int i = length(random_); i > 0 && k < stream.values.cols(); --i)
        stream.values.col(k++).setConstant(kNaN);
    }
  }

  const Recording& r_;
  const RobotFiles& files_;
  const Changes& changes_;
  const TrialSpec& spec_;
  double end_, clock_ = 0.0;
  Vector moment_;  ///< when each sample of the present stream was really taken [s]
  Random& random_;
};

bool base_fixed(const trajectory::Dataset& asked, const RobotFiles& files) {
  return asked.experiment == trajectory::ExperimentKind::tail_bench || !files.floating;
}

/// Plays a trial, from whose generator the observer then draws.
Recording play_trial(const trajectory::Dataset& asked, const RobotFiles& files,
                     const PlanCommands& plan, const Changes& changes, const TrialSpec& spec,
                     Random& random) {
  std::normal_distribution<double> normal;
  PlayOptions options;
  options.floor = asked.experiment == trajectory::ExperimentKind::leap;
  options.base_fixed = base_fixed(asked, files);
  options.stops = !asked.stops.empty();
  options.start = plan.start;
  options.duration = plan.duration + spec.after + 0.01;
  for (const auto& [joint, offset] : spec.start_offset) {
    options.start[joint] += offset;
    options.level = options.floor;
  }

  if (!spec.exact) {
    for (const std::string& motor : files.planar_motors)
      options.start[motor] += spec.pose_scatter * normal(random);
    // Nobody sets a joint beyond its stop.
    for (const auto& [joint, stop] : asked.stops)
      options.start[joint] = std::clamp(options.start[joint], stop.range.lower, stop.range.upper);
    options.level = options.floor;
    options.sensors = {spec.sensors.encoder_step, spec.sensors.encoder, spec.sensors.tachometer,
                       random()};
  }

  Recording recording = play(files, changes, plan.commands, options, Numerics{});
  if (recording.diverged) {
    throw LostRobot(fmt::format("the MuJoCo robot was lost at {:.4f} s", recording.end_time));
  }

  return recording;
}

/// By how much motors of one planar joint part, until the commands end.
double most_apart(const Recording& r, double end) {
  const auto count = std::upper_bound(r.time.begin(), r.time.end(), end) - r.time.begin();
  double most = 0.0;
  for (Eigen::Index i = 1; i < r.position.rows(); ++i) {
    const std::size_t at = i;
    if (r.motor_of[at] == r.motor_of[at - 1])
      most = std::max(
          most, (r.position.row(i) - r.position.row(i - 1)).head(count).cwiseAbs().maxCoeff());
  }
  return most;
}

trajectory::Trial one_trial(const trajectory::Dataset& asked, const RobotFiles& files,
                            const PlanCommands& plan, const Changes& changes, const TrialSpec& spec,
                            int index, double& legs_apart) {
  Random random(task_seed(spec.seed, index));
  const Recording recording = play_trial(asked, files, plan, changes, spec, random);
  legs_apart = std::max(legs_apart, most_apart(recording, plan.duration));
  const double end = plan.duration + spec.after;
  Observer observer(recording, files, changes, spec, end, random);
  trajectory::Trial trial;
  trial.name = fmt::format("trial_{:02}", index + 1);
  const bool held = base_fixed(asked, files);
  if (spec.sensors.mocap && !held) trial.streams.push_back(observer.mocap());
  if (spec.sensors.joints || held) trial.streams.push_back(observer.joints());
  return trial;
}

}  // namespace

trajectory::Dataset run_trials(const trajectory::Dataset& asked, const Changes& changes,
                               const TrialSpec& spec, double* legs_apart) {
  const RobotFiles believed = read_robot_files(model::find_robot(asked.robot, asked.folder));
  const PlanCommands plan = dataset_commands(asked, believed, spec);
  const RobotFiles real =
      spec.clutter_seed
          ? cluttered(believed, draw_clutter(believed, believed.tolerances, *spec.clutter_seed))
          : believed;

  trajectory::Dataset out = asked;
  out.trials.clear();
  // What was commanded is no part of a log that itself says what drove the joints.
  if (asked.controller.kind == trajectory::ControllerKind::measured) out.script.reset();
  double apart = 0.0;
  for (int i = 0; i < spec.trials; ++i)
    out.trials.push_back(one_trial(asked, real, plan, changes, spec, i, apart));
  if (legs_apart != nullptr) *legs_apart = apart;
  return out;
}

}  // namespace jaculus::testbed
