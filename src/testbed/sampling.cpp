#include <algorithm>

#include "jaculus/testbed/playback.h"

namespace jaculus::testbed {
namespace {

struct Place {
  double time;         ///< held at the ends of the grid
  Eigen::Index index;  ///< of the sample before it
};

Place locate(const Vector& grid, double time) {
  const auto last = grid.size() - 1;
  const double held = std::clamp(time, grid[0], grid[last]);
  const auto next = std::upper_bound(grid.begin(), grid.end(), held) - grid.begin();
  return {held, std::clamp<Eigen::Index>(next - 1, 0, std::max<Eigen::Index>(0, last - 1))};
}

}  // namespace

Vector sample(const Vector& time, const Vector& value, const Vector& rate, const Vector& at) {
  Vector out(at.size());
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    const auto [t, k] = locate(time, at[i]);
    const double h = time[k + 1] - time[k], s = (t - time[k]) / h, c = 1.0 - s;
    out[i] = (1.0 + 2.0 * s) * c * c * value[k] + s * s * (3.0 - 2.0 * s) * value[k + 1] +
             h * s * c * (c * rate[k] - s * rate[k + 1]);
  }
  return out;
}

Vector sample(const Vector& time, const Vector& value, const Vector& at) {
  Vector out(at.size());
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    const auto [t, k] = locate(time, at[i]);
    const double s = (t - time[k]) / (time[k + 1] - time[k]);
    out[i] = value[k] + s * (value[k + 1] - value[k]);
  }
  return out;
}

}  // namespace jaculus::testbed
