#include "model/sides.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "jaculus/model/tolerances.h"

namespace jaculus::model {
namespace {

constexpr double kSame = 1e-6;  ///< relative

class Comparison {
 public:
  explicit Comparison(const PairReading& reading) : reading_(reading) {}

  /// `far`: from where on the two can't stand for one; between, `taken` is done.
  void compare(const char* what, const char* unit, double a, double b, double scale, double far,
               const std::string& taken) const {
    const double off = std::abs(a - b);
    if (off <= kSame * scale || a == b) return;
    const PairSpec& pair = reading_.pair;
    const std::string fault =
        fmt::format("'{}' and '{}' differ in {}: {:.10g} and {:.10g}{}{}; allowed: the same",
                    pair.left, pair.right, what, a, b, *unit ? " " : "", unit);
    if (off > far || reading_.assumptions.strict()) throw pair.node.error(fault);
    reading_.assumptions.assume(reading_.line, fault, taken);
  }

 private:
  const PairReading& reading_;
};

}  // namespace

Bounds compare_sides(const PairReading& reading, const Side& left, const Side& right) {
  const Comparison pair(reading);
  const PlanarBody& a = left.body;
  const PlanarBody& b = right.body;
  const double place = Tolerances{}.com;          // a builder's 2 mm
  const double zero = Tolerances{}.encoder_zero;  // a joint's zero
  const std::string lefts = "the left one's";
  const std::string added = "added as they are";

  pair.compare("kind (0 revolute, 1 prismatic)", "", static_cast<double>(a.kind),
               static_cast<double>(b.kind), 1.0, 0.0, "");
  pair.compare("mass", "kg", a.mass, b.mass, a.mass, kInfinity, added);
  pair.compare("joint position x", "m", a.origin.x(), b.origin.x(), 1.0, place, lefts);
  pair.compare("joint position z", "m", a.origin.y(), b.origin.y(), 1.0, place, lefts);
  pair.compare("zero angle", "rad", a.angle_offset, b.angle_offset, 1.0, zero, lefts);
  pair.compare("direction of the axis", "", a.sign, b.sign, 1.0, kInfinity,
               "the right angle is minus the left one");
  pair.compare("direction of the slide, x", "", a.axis.x(), b.axis.x(), 1.0, zero, lefts);
  pair.compare("direction of the slide, z", "", a.axis.y(), b.axis.y(), 1.0, zero, lefts);
  pair.compare("centre of mass x", "m", a.com.x(), b.com.x(), 1.0, kInfinity, added);
  pair.compare("centre of mass z", "m", a.com.y(), b.com.y(), 1.0, kInfinity, added);
  pair.compare("pitch inertia", "kg m^2", a.inertia, b.inertia, a.inertia, kInfinity, added);

  const bool opposite = a.sign != b.sign;
  const Bounds& r = right.range;
  const Bounds mirrored = opposite ? Bounds{-r.upper, -r.lower} : r;
  const std::string common = "what both have";
  pair.compare("lower limit", "", left.range.lower, mirrored.lower, 1.0, kInfinity, common);
  pair.compare("upper limit", "", left.range.upper, mirrored.upper, 1.0, kInfinity, common);

  const Bounds both{std::max(left.range.lower, mirrored.lower),
                    std::min(left.range.upper, mirrored.upper)};
  if (both.lower > both.upper) {
    throw reading.pair.node.error(
        fmt::format("'{}' and '{}' have no angle that both may have; allowed: ranges that overlap",
                    reading.pair.left, reading.pair.right));
  }
  return both;
}

void add_side(PlanarBody& left, const PlanarBody& right) {
  const double mass = left.mass + right.mass;
  const Vec2 apart = right.com - left.com;
  // parallel axes: m_l m_r / (m_l + m_r) |c_r - c_l|^2; zero, exactly, where the sides are alike
  left.inertia += right.inertia + left.mass * right.mass / mass * apart.squaredNorm();
  const Vec2 squares = left.mass * left.spread.cwiseAbs2() + right.mass * right.spread.cwiseAbs2() +
                       left.mass * right.mass / mass * apart.cwiseAbs2();
  left.spread = (squares / mass).cwiseSqrt();
  left.com += right.mass / mass * apart;
  left.mass = mass;
}

}  // namespace jaculus::model
