#include "jaculus/trajectory/leap_speed.h"

#include <cassert>
#include <cmath>
#include <vector>

namespace jaculus::trajectory {
namespace {

struct Speeds {
  std::vector<double> time, speed;
};

Speeds smoothed_speeds(const Vector& time, const Vector& x, const Vector& y) {
  assert(x.size() == time.size() && (y.size() == 0 || y.size() == time.size()));
  std::vector<double> t, s;
  double x0 = 0.0, y0 = 0.0;

  for (Eigen::Index k = 0; k < time.size(); ++k) {
    const double lateral = y.size() == 0 ? 0.0 : y[k];
    if (std::isnan(x[k]) || std::isnan(lateral)) continue;
    if (t.empty()) {
      x0 = x[k];
      y0 = lateral;
    }
    t.push_back(time[k]);
    s.push_back(std::hypot(x[k] - x0, lateral - y0));
  }

  Speeds out;
  if (t.size() < 3) return out;

  std::vector<double> raw(t.size() - 1);
  for (std::size_t k = 0; k + 1 < t.size(); ++k) raw[k] = (s[k + 1] - s[k]) / (t[k + 1] - t[k]);

  for (std::size_t k = 0; k < raw.size(); ++k) {
    double sum = raw[k];
    int count = 1;
    if (k > 0) sum += raw[k - 1], ++count;
    if (k + 1 < raw.size()) sum += raw[k + 1], ++count;
    out.time.push_back(t[k]);
    out.speed.push_back(sum / count);
  }

  return out;
}

std::optional<std::size_t> start_index(const Speeds& speeds) {
  constexpr double kResting = 0.005, kMoving = 0.1;
  std::optional<std::size_t> rest;
  for (std::size_t k = 0; k < speeds.speed.size(); ++k) {
    if (speeds.speed[k] > kMoving) return rest;
    if (speeds.speed[k] < kResting) rest = k;
  }
  return std::nullopt;
}

}  // namespace

std::optional<double> leap_start(const Vector& time, const Vector& x, const Vector& y) {
  const Speeds speeds = smoothed_speeds(time, x, y);
  const auto start = start_index(speeds);
  if (!start) return std::nullopt;
  return speeds.time[*start];
}

std::optional<LeapSpeed> leap_speed(const Vector& time, const Vector& x, const Vector& y,
                                    double duration) {
  assert(duration > 0.0);
  const Speeds speeds = smoothed_speeds(time, x, y);
  const auto start = start_index(speeds);
  if (!start) return std::nullopt;
  const double end = speeds.time[*start] + duration;
  for (std::size_t k = *start; k + 1 < speeds.time.size(); ++k) {
    if (speeds.time[k + 1] < end) continue;
    const double share = (end - speeds.time[k]) / (speeds.time[k + 1] - speeds.time[k]);
    const double v = speeds.speed[k] + share * (speeds.speed[k + 1] - speeds.speed[k]);
    return LeapSpeed{speeds.time[*start], v, v / duration};
  }
  return std::nullopt;
}

}  // namespace jaculus::trajectory
