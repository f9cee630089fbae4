// The stop. MuJoCo's limit is an oscillator a = -2 zeta v - r (time in 1/w) that only pushes. From
// r = 0, v = -1 it pushes until a = 0, and the speed then is the restitution e(zeta). With s =
// sqrt|1 - zeta^2|
//   zeta < 1:  t = (pi - atan2(2 zeta s, 1 - 2 zeta^2) )/s if taken in (0, pi),
//     v = -exp(-zeta t)(cos st - zeta/s sin st)
//   zeta > 1:  t = ln(l2/l1)/s,  v = (l1 exp(-l1 t) - l2 exp(-l2 t))/(2 s),  l1, l2 = zeta -+ s
// e(1) = exp(-2), and e falls to 0 only as 1/zeta^2: a stop without restitution gets zeta = 3, e =
// 0.024.

#include <cmath>
#include <numbers>

#include "testbed/mjcf.h"

namespace jaculus::testbed {

double restitution_of_damping_ratio(double ratio) {
  const double s = std::sqrt(std::abs(1.0 - ratio * ratio));
  if (s < 1e-6) return std::exp(-2.0);
  if (ratio < 1.0) {
    const double t =
        (std::numbers::pi - std::atan2(2.0 * ratio * s, 1.0 - 2.0 * ratio * ratio)) / s;
    return -std::exp(-ratio * t) * (std::cos(s * t) - ratio / s * std::sin(s * t));
  }
  const double slow = ratio - s, fast = ratio + s;
  const double t = std::log(fast / slow) / s;
  return (slow * std::exp(-slow * t) - fast * std::exp(-fast * t)) / (2.0 * s);
}

double damping_ratio_of_restitution(double restitution) {
  double low = 0.0, high = 3.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (restitution_of_damping_ratio(middle) > restitution ? low : high) = middle;
  }
  return high;
}

}  // namespace jaculus::testbed
