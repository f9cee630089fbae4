#include "report/render/motion_channels.h"

#include <Eigen/QR>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <set>

namespace jaculus::report {
namespace {

constexpr double kDetermined = 1e-6;

/// Instants at which the figure is drawn: those of the longest channel of a coordinate or joint, or
/// evenly spaced ones where these are too many.
std::vector<double> frame_times(const std::vector<const MotionChannel*>& used, int most) {
  const MotionChannel* longest = nullptr;
  double first = kInfinity, last = -kInfinity;
  for (const MotionChannel* channel : used) {
    if (channel->time.empty()) continue;
    if (longest == nullptr || channel->time.size() > longest->time.size()) longest = channel;
    first = std::min(first, channel->time.front());
    last = std::max(last, channel->time.back());
  }
  if (longest == nullptr) return {};
  if (count_of(longest->time) <= most) return longest->time;
  std::vector<double> times;
  for (int k = 0; k < most; ++k) times.push_back(first + (last - first) * k / (most - 1));
  return times;
}

/// How coordinates follow from channels: direct ones, then the others from joints.
struct CoordinateMap {
  std::vector<const MotionChannel*> direct;  ///< n; null where there is no such channel
  std::vector<std::pair<int, const MotionChannel*>> joints;  ///< body and channel
  std::vector<int> open;                                     ///< coordinates that joints must give
  Matrix from_joints;                                        ///< open x joints
  std::vector<bool> known;                                   ///< n
};

const MotionChannel* find(const MotionChannels& channels, const std::string& name) {
  const auto found = channels.find(name);
  return found == channels.end() ? nullptr : &found->second;
}

CoordinateMap map_coordinates(const model::PlanarModel& model, const MotionChannels& channels,
                              const std::string& suffix) {
  CoordinateMap map;
  const int n = model.size();
  map.known.assign(n, false);
  for (int i = 0; i < n; ++i) {
    map.direct.push_back(find(channels, model.coordinates[i].name + suffix));
    map.known[i] = map.direct[i] != nullptr;
    if (!map.known[i]) map.open.push_back(i);
  }

  const std::set<int> dependent(model.dependent.begin(), model.dependent.end());
  for (int b = 1; b < count_of(model.bodies); ++b) {
    const MotionChannel* channel = find(channels, model.bodies[b].joint + suffix);
    if (channel != nullptr && !dependent.contains(b)) map.joints.emplace_back(b, channel);
  }

  if (map.open.empty() || map.joints.empty()) return map;
  Matrix A(map.joints.size(), map.open.size());
  for (int r = 0; r < count_of(map.joints); ++r)
    for (int c = 0; c < count_of(map.open); ++c)
      A(r, c) = model.joint_map(map.joints[r].first, map.open[c]);
  map.from_joints = A.completeOrthogonalDecomposition().pseudoInverse();
  // the identity's rows stand for coordinates that the joints determine
  const Matrix seen = map.from_joints * A;
  for (int c = 0; c < count_of(map.open); ++c) {
    Vector row = seen.row(c).transpose();
    row[c] -= 1.0;
    map.known[map.open[c]] = row.norm() < kDetermined;
  }
  return map;
}

/// Coordinates (or their rates, without offsets) at t; unknown ones keep `filler`.
Vector coordinates_at(const model::PlanarModel& model, const CoordinateMap& map,
                      const Vector& filler, bool rates, double t) {
  Vector q = filler;
  for (Eigen::Index i = 0; i < q.size(); ++i)
    if (const MotionChannel* channel = map.direct[i]) q[i] = channel_at(*channel, t);
  if (map.from_joints.size() == 0) return q;

  Vector theta(map.joints.size());
  for (int r = 0; r < count_of(map.joints); ++r) {
    const auto& [body, channel] = map.joints[r];
    double value = channel_at(*channel, t) - (rates ? 0.0 : model.joint_offset[body]);
    for (Eigen::Index i = 0; i < q.size(); ++i)
      if (map.direct[i] != nullptr && model.joint_map(body, i) != 0.0)
        value -= model.joint_map(body, i) * q[i];
    theta[r] = value;
  }

  const Vector open = map.from_joints * theta;
  for (int c = 0; c < count_of(map.open); ++c)
    if (map.known[map.open[c]]) q[map.open[c]] = open[c];
  return q;
}

/// A posture for what is not known, so that loops close.
Vector filler_posture(const model::PlanarModel& model) {
  Vector q = Vector::Zero(model.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Bounds& range = model.coordinates[i].range;
    if (std::isfinite(range.lower) && std::isfinite(range.upper))
      q[i] = 0.5 * (range.lower + range.upper);
  }
  return q;
}

/// Rates by differences over neighbours.
Matrix differences(const Matrix& q, const std::vector<double>& time) {
  Matrix v = Matrix::Zero(q.rows(), q.cols());
  for (Eigen::Index k = 0; k < q.cols(); ++k) {
    const Eigen::Index a = std::max<Eigen::Index>(0, k - 1),
                       b = std::min<Eigen::Index>(q.cols() - 1, k + 1);
    const double span = time[b] - time[a];
    if (span > 0.0) v.col(k) = (q.col(b) - q.col(a)) / span;
  }
  return v;
}

}  // namespace

MotionChannels motion_channels(const trajectory::Table& plan) {
  MotionChannels channels;
  const int time = plan.column("time");
  assert(time >= 0);
  const Vector t = plan.values.col(time);
  for (int c = 0; c < count_of(plan.columns); ++c) {
    if (c == time) continue;
    const Vector values = plan.values.col(c);
    channels[plan.columns[c].name] = {{t.begin(), t.end()}, {values.begin(), values.end()}};
  }
  return channels;
}

MotionChannels motion_channels(const trajectory::Trial& trial) {
  MotionChannels channels;
  for (const trajectory::Stream& stream : trial.streams) {
    for (int c = 0; c < count_of(stream.channels); ++c) {
      const Vector values = stream.values.row(c).transpose();
      channels.try_emplace(
          stream.channels[c],
          MotionChannel{{stream.time.begin(), stream.time.end()}, {values.begin(), values.end()}});
    }
  }
  return channels;
}

double channel_at(const MotionChannel& channel, double t) {
  const std::vector<double>& time = channel.time;
  if (time.empty() || t < time.front() - 1e-9 || t > time.back() + 1e-9) return kNaN;
  const auto after =
      static_cast<std::size_t>(std::upper_bound(time.begin(), time.end(), t) - time.begin());
  if (after == 0) return channel.value.front();
  const std::size_t i = after - 1;
  if (after == time.size() || time[i] == t) return channel.value[i];
  const double share = (t - time[i]) / (time[after] - time[i]);
  return channel.value[i] + share * (channel.value[after] - channel.value[i]);
}

CoordinateFrames coordinate_frames(const model::PlanarModel& model, const MotionChannels& channels,
                                   int most_frames) {
  const CoordinateMap map = map_coordinates(model, channels, "");
  const CoordinateMap rates = map_coordinates(model, channels, "_velocity");
  std::vector<const MotionChannel*> used;
  for (const MotionChannel* channel : map.direct)
    if (channel != nullptr) used.push_back(channel);
  for (const auto& [body, channel] : map.joints) used.push_back(channel);
  CoordinateFrames frames;
  frames.time = frame_times(used, most_frames);
  frames.known = map.known;
  const Vector filler = filler_posture(model), still = Vector::Zero(model.size());
  const auto count = std::ssize(frames.time);
  frames.q.resize(model.size(), count);
  frames.v.resize(model.size(), count);
  bool all_rates = true;
  for (std::size_t i = 0; i < map.known.size(); ++i)
    all_rates = all_rates && (rates.known[i] || !map.known[i]);

  for (Eigen::Index k = 0; k < count; ++k) {
    const double t = frames.time[k];
    frames.q.col(k) = coordinates_at(model, map, filler, false, t);
    if (all_rates) frames.v.col(k) = coordinates_at(model, rates, still, true, t);
  }

  if (!all_rates) frames.v = differences(frames.q, frames.time);
  for (const char* base : {"x", "z", "pitch"}) {
    const int i = model.coordinate_index(base);
    if (i < 0 || map.known[i]) continue;
    frames.q.row(i).setZero();
    // drawn all the same, where stick_figure.h says
    frames.known[i] = true;
    if (base[0] == 'z') frames.height_known = false;
  }

  return frames;
}

std::vector<bool> known_bodies(const model::PlanarModel& model, const std::vector<bool>& known) {
  std::vector<bool> bodies(model.bodies.size(), true);
  for (std::size_t i = 0; i < 3 && i < known.size(); ++i)
    if (model.base_free[0] || model.base_free[1] || model.base_free[2])
      bodies[0] = bodies[0] && known[i];

  // Roots of dependent links come before them; a loop's links need both roots.
  for (int round = 0; round < 2; ++round) {
    for (int b = 1; b < count_of(bodies); ++b) {
      bool given = bodies[model.bodies[b].parent];
      for (Eigen::Index i = 0; i < model.joint_map.cols(); ++i)
        if (model.joint_map(b, i) != 0.0) given = given && known[i];
      bodies[b] = given;
    }
    for (const model::PlanarLoop& loop : model.loops) {
      const std::size_t a = loop.body_a, b = loop.body_b;
      const bool roots = bodies[model.bodies[a].parent] && bodies[model.bodies[b].parent];
      bodies[a] = roots;
      bodies[b] = roots;
    }
  }

  return bodies;
}

}  // namespace jaculus::report
