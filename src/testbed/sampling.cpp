#include <algorithm>

#include "jaculus/testbed/playback.h"

namespace jaculus::testbed {

Vector sample(const Vector& time, const Vector& value, const Vector& rate, const Vector& at) {
  Vector out(at.size());
  const auto last = time.size() - 1;
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    const double t = std::clamp(at[i], time[0], time[last]);
    const auto next = std::upper_bound(time.begin(), time.end(), t) - time.begin();
    const Eigen::Index k = std::clamp<Eigen::Index>(next - 1, 0, std::max<Eigen::Index>(0, last - 1));
    const double h = time[k + 1] - time[k], s = (t - time[k]) / h, c = 1.0 - s;
    out[i] = (1.0 + 2.0 * s) * c * c * value[k] + s * s * (3.0 - 2.0 * s) * value[k + 1] +
             h * s * c * (c * rate[k] - s * rate[k + 1]);
  }
  return out;
}

Vector sample(const Vector& time, const Vector& value, const Vector& at) {
  Vector out(at.size());
  const auto last = time.size() - 1;
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    const double t = std::clamp(at[i], time[0], time[last]);
    const auto next = std::upper_bound(time.begin(), time.end(), t) - time.begin();
    const Eigen::Index k = std::clamp<Eigen::Index>(next - 1, 0, std::max<Eigen::Index>(0, last - 1));
    const double s = (t - time[k]) / (time[k + 1] - time[k]);
    out[i] = value[k] + s * (value[k + 1] - value[k]);
  }
  return out;
}

}  // namespace jaculus::testbed
