#pragma once
// Shared aliases and the conventions of the whole library, written once.
//
// Units: SI throughout (m, kg, s, rad, N, N m, A, V).
// World frame: x forward, z up, y left. The sagittal plane is x-z; a planar vector is (x, z).
// Angles: pitch and every joint angle turn about +y (REP-103), so positive pitch is nose-down:
//   R(phi) = [ cos phi  sin phi ]      maps a body vector (x, z) into the world.
//            [-sin phi  cos phi ]
// Frame suffixes on names: p_W is expressed in the world, v_B in the body; R_WB maps B to W.
// A planar leg stands for the left and the right one: masses and foot forces are sums over both,
// torques, currents and voltages are those of one motor.

#include <Eigen/Core>
#include <algorithm>
#include <cassert>
#include <limits>

namespace jaculus {

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;
using VectorRef = Eigen::Ref<Vector>;
using ConstVectorRef = Eigen::Ref<const Vector>;
using MatrixRef = Eigen::Ref<Matrix>;
using ConstMatrixRef = Eigen::Ref<const Matrix>;

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Closed interval of a quantity, in the quantity's own SI unit; infinite ends mean "no bound".
struct Bounds {
  double lower = -kInfinity;
  double upper = kInfinity;

  [[nodiscard]] bool fixed() const { return lower == upper; }
  [[nodiscard]] bool contains(double v) const { return v >= lower && v <= upper; }
};

/// Number of elements of a container, string or Eigen vector, as the int that everything is indexed
/// by here. Misuse: more elements than an int holds.
template <class Container>
[[nodiscard]] int count_of(const Container& container) {
  assert(static_cast<std::size_t>(container.size()) <= std::numeric_limits<int>::max());
  return static_cast<int>(container.size());
}

/// Position of the first element equal to `value`, -1 where there is none.
template <class Container, class Value>
[[nodiscard]] int index_of(const Container& container, const Value& value) {
  const auto found = std::find(container.begin(), container.end(), value);
  return found == container.end() ? -1 : static_cast<int>(found - container.begin());
}

/// Standard gravity [m/s^2].
inline constexpr double kGravity = 9.81;

}  // namespace jaculus
