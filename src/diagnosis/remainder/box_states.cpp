#include "diagnosis/remainder/box_states.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace jaculus::diagnosis {
namespace {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// Samples of a channel near a time.
struct Near {
  std::vector<double> apart, value;  ///< [s], [unit]
};

Near near(const trajectory::Stream* stream, int channel, double t, double half_width) {
  Near out;
  if (stream == nullptr) return out;
  const auto first = std::lower_bound(stream->time.begin(), stream->time.end(), t - half_width);
  for (auto i = first - stream->time.begin(); i < stream->time.size(); ++i) {
    if (stream->time[i] > t + half_width) break;
    if (!std::isfinite(stream->values(channel, i))) continue;
    out.apart.push_back(stream->time[i] - t);
    out.value.push_back(stream->values(channel, i));
  }
  return out;
}

/// Normal equations of a parabola in s/half_width.
struct Normal {
  Mat3 matrix = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  double squares = 0.0;
  int rows = 0;

  void add(const Vec3& row, double value, double weight) {
    matrix += weight * row * row.transpose();
    right += weight * value * row;
    squares += weight * value * value;
    ++rows;
  }
};

Normal positions(const Near& samples, double half_width, double weight) {
  Normal normal;
  for (std::size_t i = 0; i < samples.apart.size(); ++i) {
    const double s = samples.apart[i] / half_width;
    normal.add({1.0, s, s * s}, samples.value[i], weight);
  }
  return normal;
}

void add_rates(const Near& samples, double half_width, double weight, Normal& normal) {
  for (std::size_t i = 0; i < samples.apart.size(); ++i) {
    const double s = samples.apart[i] / half_width;
    normal.add(Vec3(0.0, 1.0, 2.0 * s) / half_width, samples.value[i], weight);
  }
}

/// Mean and slope of a rate about a time, with what the line leaves.
struct Line {
  double value = kNaN, left = 0.0, value_variance = kNaN;  ///< variance for a scatter of one
  int freedom = 0;
};

Line line_of(const Near& samples) {
  const auto n = static_cast<double>(samples.apart.size());
  Line line;
  if (n < 3.0) return line;
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Vec2 right = Vec2::Zero();
  double squares = 0.0;
  for (std::size_t i = 0; i < samples.apart.size(); ++i) {
    const Vec2 row(1.0, samples.apart[i]);
    normal += row * row.transpose();
    right += samples.value[i] * row;
    squares += samples.value[i] * samples.value[i];
  }
  const Eigen::Matrix2d inverse = normal.inverse();
  const Vec2 fit = inverse * right;
  line.value = fit[0];
  line.left = std::max(0.0, squares - right.dot(fit));
  line.value_variance = inverse(0, 0);
  line.freedom = static_cast<int>(samples.apart.size()) - 2;
  return line;
}

/// One coordinate of one trial.
struct Track {
  const trajectory::Stream *position = nullptr, *rate = nullptr;
  int position_channel = -1, rate_channel = -1;
  double position_weight = 1.0, rate_weight = 0.0;  ///< 1/scatter^2; of the rate 0: not used
};

Track track_of(const trajectory::Trial& trial, const std::string& coordinate) {
  Track track;
  for (const trajectory::Stream& stream : trial.streams) {
    if (const int c = stream.channel(coordinate); c >= 0 && track.position == nullptr)
      track.position = &stream, track.position_channel = c;
    if (const int c = stream.channel(coordinate + "_velocity"); c >= 0 && track.rate == nullptr)
      track.rate = &stream, track.rate_channel = c;
  }
  return track;
}

/// Weights by both channels' scatter about their own curves.
void set_weights(const std::vector<double>& times, double half_width, const Settings& settings,
                 Track& track) {
  double left = 0.0, freedom = 0.0, rate_left = 0.0, rate_freedom = 0.0;
  std::vector<std::pair<double, Vec2>> apart;  // rate less slope, variances of both
  for (const double t : times) {
    const Normal own =
        positions(near(track.position, track.position_channel, t, half_width), half_width, 1.0);
    if (own.rows < settings.window_start_samples) continue;
    const Mat3 inverse = own.matrix.inverse();
    const Vec3 fit = inverse * own.right;
    left += std::max(0.0, own.squares - own.right.dot(fit));
    freedom += own.rows - 3;
    const Line line = line_of(near(track.rate, track.rate_channel, t, half_width));
    if (!std::isfinite(line.value)) continue;
    rate_left += line.left;
    rate_freedom += line.freedom;
    apart.emplace_back(line.value - fit[1] / half_width,
                       Vec2(inverse(1, 1) / (half_width * half_width), line.value_variance));
  }
  if (!(left > 0.0) || !(freedom > 0.0)) return;
  track.position_weight = freedom / left;
  if (!(rate_left > 0.0) || !(rate_freedom > 0.0)) return;

  const double scatter = rate_left / rate_freedom;
  double squares = 0.0, expected = 0.0;
  for (const auto& [difference, variances] : apart) {
    squares += difference * difference;
    expected += variances[0] / track.position_weight + variances[1] * scatter;
  }
  if (squares <= settings.rates_agree * expected) track.rate_weight = 1.0 / scatter;
}

/// Position and rate at a time; NaN where there are too few samples.
Vec2 state_at(const Track& track, double t, double half_width, const Settings& settings) {
  const Near own = near(track.position, track.position_channel, t, half_width);
  if (count_of(own.apart) < settings.window_start_samples) return Vec2::Constant(kNaN);
  Normal normal = positions(own, half_width, track.position_weight);
  if (track.rate_weight > 0.0)
    add_rates(near(track.rate, track.rate_channel, t, half_width), half_width, track.rate_weight,
              normal);
  const Vec3 fit = normal.matrix.ldlt().solve(normal.right);
  return {fit[0], fit[1] / half_width};
}

}  // namespace

std::vector<BoxState> box_states(const ObservedDataset& observed, double half_width,
                                 const Settings& settings) {
  const int n = observed.model.size();
  std::vector<BoxState> states(observed.segments.size(), {Vector(n), Vector(n)});
  for (int t = 0; t < count_of(observed.dataset.trials); ++t) {
    std::vector<int> own;
    std::vector<double> times;
    for (int s = 0; s < count_of(observed.segments); ++s) {
      if (observed.segments[s].trial != t) continue;
      own.push_back(s);
      times.push_back(observed.segments[s].start);
    }
    for (int i = 0; i < n; ++i) {
      Track track = track_of(observed.dataset.trials[t], observed.model.coordinates[i].name);
      if (track.position != nullptr) set_weights(times, half_width, settings, track);
      for (std::size_t k = 0; k < own.size(); ++k) {
        const Vec2 state = track.position != nullptr
                               ? state_at(track, times[k], half_width, settings)
                               : Vec2(Vec2::Constant(kNaN));
        states[own[k]].q[i] = state[0];
        states[own[k]].v[i] = state[1];
      }
    }
  }

  for (BoxState& state : states)
    if (!state.q.allFinite() || !state.v.allFinite()) state = {};
  return states;
}

double pattern_box(const std::vector<ObservedDataset>& datasets, const Settings& settings) {
  double slowest = 0.0;
  for (const ObservedDataset& observed : datasets) {
    for (const trajectory::Trial& trial : observed.dataset.trials) {
      for (const model::Coordinate& coordinate : observed.model.coordinates) {
        const Track track = track_of(trial, coordinate.name);
        if (track.position == nullptr || track.position->time.size() < 2) continue;
        const Vector& time = track.position->time;
        slowest = std::max(
            slowest, (time[time.size() - 1] - time[0]) / static_cast<double>(time.size() - 1));
      }
    }
  }
  const double wanted = settings.pattern_rows * slowest;
  return std::min(settings.force_box, std::max(settings.pattern_box, wanted));
}

}  // namespace jaculus::diagnosis
