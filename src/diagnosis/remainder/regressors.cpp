#include "diagnosis/remainder/regressors.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "jaculus/dynamics/rigid_body.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kSameInstant = 1e-6;  // [s]
constexpr double kVaries = 1e-6;       ///< of its size, below which a function is a constant
constexpr double kOscillates = 0.25;   ///< of boxes, that must pass less than half of a period
constexpr double kHalfCycles = 0.5;    ///< over the whole range, from one period to the next
constexpr std::size_t kMostPeriods = 400;

/// The motion of one coordinate through a box, a sample each.
struct BoxPath {
  Vector position, speed, torque, weight, sine, cosine;
  double time = 0.0, acceleration = 0.0;
  Vector other_speed, other_acceleration;  ///< means, a coordinate each
  Vector channels;                         ///< means of logged channels; NaN where there are none
};

template <class Function>
double mean_of(const Vector& samples, Function&& value) {
  return path_mean(samples.size(), [&](Eigen::Index k) { return value(samples[k]); });
}

/// Logged channels that a force may follow, by name.
std::vector<std::string> followed_channels(const Problem& all) {
  std::vector<std::string> names;
  for (const ObservedDataset& observed : all.observations.datasets)
    for (const trajectory::Trial& trial : observed.dataset.trials)
      for (const trajectory::Stream& stream : trial.streams)
        for (const std::string& name : stream.channels)
          if ((name == "bus_voltage" || name.ends_with("temperature")) && index_of(names, name) < 0)
            names.push_back(name);
  return names;
}

/// Mean of a channel over a box; NaN where it has no sample there.
double channel_mean(const trajectory::Trial& trial, const std::string& name, const MotionBox& box) {
  double sum = 0.0, count = 0.0;
  for (const trajectory::Stream& stream : trial.streams) {
    const int channel = stream.channel(name);
    if (channel < 0) continue;
    const auto first = std::lower_bound(stream.time.begin(), stream.time.end(), box.start);
    for (auto i = first - stream.time.begin(); i < stream.time.size(); ++i) {
      if (stream.time[i] >= box.start + box.length) break;
      if (!std::isfinite(stream.values(channel, i))) continue;
      sum += stream.values(channel, i);
      count += 1.0;
    }
  }
  return count > 0.0 ? sum / count : kNaN;
}

/// Weights and directions of gravity along a box's path.
void add_gravity(const model::PlanarModel& model, const MotionBox& box, int coordinate,
                 BoxPath& path) {
  const dynamics::AbsoluteTree tree(model);
  dynamics::Motion motion(tree);
  const int body = std::max(0, model.body_of_joint(model.coordinates[coordinate].name));
  for (Eigen::Index k = 0; k < box.q.cols(); ++k) {
    if (!set_configuration(tree, box.q.col(k), motion)) continue;
    set_rates(tree, Vector::Zero(model.size()), motion);
    path.weight[k] = bias(tree, motion)[coordinate];
    path.sine[k] = motion.pose.sine[tree.angle_index(body)];
    path.cosine[k] = motion.pose.cosine[tree.angle_index(body)];
  }
}

BoxPath path_through(const ObservedDataset& observed, const MotionBox& box, int coordinate,
                     const std::vector<std::string>& channels) {
  const model::PlanarModel& model = observed.model;
  const Eigen::Index samples = box.q.cols();
  const int motor = model.motor_index(model.coordinates[coordinate].name);

  BoxPath path;
  path.position = box.q.row(coordinate).transpose();
  path.speed = box.v.row(coordinate).transpose();
  path.torque = Vector::Zero(samples);
  if (motor >= 0) path.torque = model.motors[motor].count * box.torque.row(motor).transpose();
  path.weight = path.sine = path.cosine = Vector::Zero(samples);
  add_gravity(model, box, coordinate, path);
  path.time = box.start + 0.5 * box.length;
  path.acceleration = box.model_acceleration[coordinate];
  path.other_speed = box.mean_rate;
  path.other_acceleration = box.model_acceleration;

  path.channels.resize(count_of(channels));
  for (int c = 0; c < count_of(channels); ++c)
    path.channels[c] = channel_mean(observed.dataset.trials[box.trial], channels[c], box);
  return path;
}

/// A group's functions as means over one box.
using GroupValues = std::function<Vector(const BoxPath&)>;

/// Columns of mean square 1; nothing where a function has no values or is next to nothing.
void add_group(Regressor regressor, const std::string& of, const std::vector<BoxPath>& paths,
               const GroupValues& values, std::vector<RegressorGroup>& groups) {
  RegressorGroup group{regressor, of, {}, {}};
  for (std::size_t k = 0; k < paths.size(); ++k) {
    const Vector row = values(paths[k]);
    if (k == 0) group.columns.resize(std::ssize(paths), row.size());
    group.columns.row(static_cast<Eigen::Index>(k)) = row.transpose();
  }
  if (!group.columns.allFinite()) return;

  // The first function is the group's own, a constant beside it its zero.
  const Vector first = group.columns.col(0);
  const double size = std::sqrt(first.squaredNorm() / static_cast<double>(first.size()));
  const double varies = (first.array() - first.mean()).matrix().norm();
  if (!(size > 0.0)) return;
  if (regressor != Regressor::constant && varies <= kVaries * first.norm()) return;
  group.scale = (group.columns.colwise().squaredNorm() / static_cast<double>(first.size()))
                    .cwiseSqrt()
                    .cwiseMax(kVaries * size)
                    .transpose();
  group.columns *= group.scale.cwiseInverse().asDiagonal();
  groups.push_back(std::move(group));
}

Vector one(double value) { return Vector::Constant(1, value); }

/// Usual speed of a coordinate, root mean square [rad/s or m/s].
double usual_speed(const std::vector<BoxPath>& paths) {
  double squares = 0.0;
  for (const BoxPath& path : paths) squares += mean_of(path.speed, [](double v) { return v * v; });
  return std::sqrt(squares / static_cast<double>(paths.size()));
}

/// Groups that are about the joint alone.
void add_own(const std::vector<BoxPath>& paths, double rest, std::vector<RegressorGroup>& groups) {
  const auto sign = [rest](double v) { return std::tanh(v / rest); };
  const auto against = [sign](const Vector& speed, const Vector& load) {
    return path_mean(speed.size(),
                     [&](Eigen::Index k) { return std::abs(load[k]) * sign(speed[k]); });
  };
  const auto mean = [](const Vector& samples) {
    return mean_of(samples, [](double v) { return v; });
  };

  const std::vector<std::pair<Regressor, GroupValues>> own = {
      {Regressor::constant, [](const BoxPath&) { return one(1.0); }},
      {Regressor::sign_of_speed, [&](const BoxPath& p) { return one(mean_of(p.speed, sign)); }},
      {Regressor::speed, [&](const BoxPath& p) { return one(mean(p.speed)); }},
      {Regressor::speed_squared,
       [](const BoxPath& p) {
         return one(mean_of(p.speed, [](double v) { return std::abs(v) * v; }));
       }},
      {Regressor::motor_torque, [&](const BoxPath& p) { return one(mean(p.torque)); }},
      {Regressor::torque_friction,
       [&](const BoxPath& p) { return one(against(p.speed, p.torque)); }},
      {Regressor::weight_friction,
       [&](const BoxPath& p) { return one(against(p.speed, p.weight)); }},
      {Regressor::position, [&](const BoxPath& p) { return Vec2(mean(p.position), 1.0); }},
      {Regressor::gravity_direction,
       [&](const BoxPath& p) { return Vec2(mean(p.sine), mean(p.cosine)); }},
      {Regressor::acceleration, [](const BoxPath& p) { return one(p.acceleration); }},
      {Regressor::time, [](const BoxPath& p) { return Vec2(p.time, 1.0); }}};
  for (const auto& [regressor, values] : own) add_group(regressor, "", paths, values, groups);
}

/// Groups that are about other joints and logged channels.
void add_others(const std::vector<BoxPath>& paths, const model::PlanarModel& model, int coordinate,
                const std::vector<std::string>& channels, std::vector<RegressorGroup>& groups) {
  for (int j = 0; j < model.size(); ++j) {
    if (j == coordinate) continue;
    const std::string& name = model.coordinates[j].name;
    add_group(
        Regressor::other_speed, name, paths,
        [j](const BoxPath& p) { return one(p.other_speed[j]); }, groups);
    add_group(
        Regressor::other_acceleration, name, paths,
        [j](const BoxPath& p) { return one(p.other_acceleration[j]); }, groups);
  }
  for (int c = 0; c < count_of(channels); ++c)
    add_group(
        Regressor::channel, channels[c], paths,
        [c](const BoxPath& p) { return Vec2(p.channels[c], 1.0); }, groups);
}

}  // namespace

PlaceRegressors regressors_of(const Problem& all, const std::vector<std::vector<MotionBox>>& boxes,
                              const std::string& coordinate) {
  const std::vector<std::string> channels = followed_channels(all);
  PlaceRegressors out;
  out.boxes.name = coordinate;
  std::vector<BoxPath> paths;
  std::vector<double> forces;
  const model::PlanarModel* model = nullptr;
  int run = -1;

  for (int d = 0; d < count_of(boxes); ++d) {
    const ObservedDataset& observed = all.observations.datasets[d];
    const int own = observed.model.coordinate_index(coordinate);
    if (own < 0) continue;
    if (model == nullptr) model = &observed.model;
    if (observed.model.size() != model->size()) continue;
    const MotionBox* before = nullptr;
    for (const MotionBox& box : boxes[d]) {
      const bool follows = before != nullptr && before->trial == box.trial &&
                           std::abs(before->start + before->length - box.start) < kSameInstant;
      if (!follows) ++run;
      before = &box;
      out.boxes.run.push_back(run);
      forces.push_back(box.force[own]);
      paths.push_back(path_through(observed, box, own, channels));
    }
  }
  if (paths.empty()) return out;

  const int own = model->coordinate_index(coordinate);
  out.boxes.angular = model->coordinates[own].angular;
  out.boxes.force = Eigen::Map<const Vector>(forces.data(), std::ssize(forces));
  for (const BoxPath& path : paths) out.boxes.position.push_back(path.position);
  out.boxes.rest = all.settings.rest_speed * usual_speed(paths);
  if (out.boxes.rest > 0.0) add_own(paths, out.boxes.rest, out.groups);
  add_others(paths, *model, own, channels, out.groups);
  return out;
}

Matrix periodic_columns(const PlaceBoxes& boxes, double period) {
  const double rate = 2.0 * std::numbers::pi / period;
  Matrix columns(std::ssize(boxes.position), 2);
  for (Eigen::Index k = 0; k < columns.rows(); ++k) {
    const Vector& q = boxes.position[k];
    columns(k, 0) = mean_of(q, [rate](double x) { return std::sin(rate * x); });
    columns(k, 1) = mean_of(q, [rate](double x) { return std::cos(rate * x); });
  }
  return columns;
}

std::vector<double> periods_of(const PlaceBoxes& boxes) {
  double low = kInfinity, high = -kInfinity;
  std::vector<double> passed;
  for (const Vector& q : boxes.position) {
    low = std::min(low, q.minCoeff());
    high = std::max(high, q.maxCoeff());
    passed.push_back(q.maxCoeff() - q.minCoeff());
  }
  const double range = high - low;
  if (!(range > 0.0)) return {};

  const auto quick = passed.begin() +
                     static_cast<std::ptrdiff_t>(kOscillates * static_cast<double>(passed.size()));
  std::nth_element(passed.begin(), quick, passed.end());
  const double shortest = 2.0 * *quick, step = kHalfCycles / range;
  std::vector<double> periods;
  for (double frequency = 2.0 / range; frequency * shortest <= 1.0; frequency += step) {
    if (periods.size() >= kMostPeriods) break;
    periods.push_back(1.0 / frequency);
  }
  return periods;
}

}  // namespace jaculus::diagnosis
