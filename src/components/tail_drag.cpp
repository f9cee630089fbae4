#include "jaculus/components/tail_drag.h"

#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <cassert>
#include <cmath>

namespace jaculus::components {
namespace {

// Integrals over a strip of l^j times the law g(u) and, where asked, its derivatives by u.
struct Moments {
  std::array<double, 2> g{};   // l^0, l^1
  std::array<double, 3> g1{};  // l^0 .. l^2
  std::array<double, 4> g2{};  // l^0 .. l^3
};

// The law g(u) = u sqrt(u^2 + eps^2) with its derivatives.
struct Law {
  double u, r, g, g1, g2;
  Law(double speed, double eps2) : u(speed), r(std::sqrt(speed * speed + eps2)) {
    g = u * r;
    if (r > 0.0) {
      const double c = u / r;
      g1 = r + u * c;
      g2 = c * (3.0 - c * c);
    } else {
      g1 = g2 = 0.0;
    }
  }
  // First antiderivative of g.
  [[nodiscard]] double first() const { return r * r * r / 3.0; }
};

// Second antiderivative of g at p less at q,
//   (u r^3/4 + 3/8 eps^2 (u r + eps^2 asinh(u/eps)))/3,
// with asinh(x) - asinh(y) = asinh(x sqrt(1 + y^2) - y sqrt(1 + x^2)).
double second_between(const Law& p, const Law& q, double eps2) {
  const double up = p.u * p.r, uq = q.u * q.r;
  const double angle = std::asinh((p.u * q.r - q.u * p.r) / eps2);
  return ((up * p.r * p.r - uq * q.r * q.r) / 4.0 + 0.375 * eps2 * (up - uq + eps2 * angle)) / 3.0;
}

// What is asked of the law: its values, or its derivatives as well.
enum class Order { value, derivatives };

DragLoad load_from(const Moments& m, double k) {
  DragLoad load;
  load.force = -k * m.g[0];
  load.moment = -k * m.g[1];
  load.d << -k * m.g1[0], -k * m.g1[1], -k * m.g1[1], -k * m.g1[2];
  load.force_dd << -k * m.g2[0], -k * m.g2[1], -k * m.g2[1], -k * m.g2[2];
  load.moment_dd << -k * m.g2[1], -k * m.g2[2], -k * m.g2[2], -k * m.g2[3];
  return load;
}

// Adds sign * Int_a^b of the polynomials that u|u| and its derivatives are where u keeps one sign.
template <Order order>
void add_one_signed(double a, double b, double s, double omega, double sign, Moments& m) {
  std::array<double, 4> p{};  // Int_a^b l^j dl = (b^(j+1) - a^(j+1)) / (j+1)
  double pa = a, pb = b;
  for (int j = 0; j < 4; ++j, pa *= a, pb *= b) p[j] = (pb - pa) / (j + 1);
  m.g[0] += sign * (s * s * p[0] + 2.0 * s * omega * p[1] + omega * omega * p[2]);
  m.g[1] += sign * (s * s * p[1] + 2.0 * s * omega * p[2] + omega * omega * p[3]);
  if constexpr (order == Order::value) return;
  for (std::size_t j = 0; j < 3; ++j) m.g1[j] += 2.0 * sign * (s * p[j] + omega * p[j + 1]);
  for (std::size_t j = 0; j < 4; ++j) m.g2[j] += 2.0 * sign * p[j];
}

// Equation 8, signed, in closed form.
template <Order order>
Moments exact_moments(double a, double b, double s, double omega) {
  Moments m;
  const auto sign_on = [&](double l) {
    const double u = s + omega * l;
    return u > 0.0 ? 1.0 : (u < 0.0 ? -1.0 : 0.0);
  };
  const double turn = omega != 0.0 ? -s / omega : a;
  if (turn > a && turn < b) {
    add_one_signed<order>(a, turn, s, omega, omega > 0.0 ? -1.0 : 1.0, m);
    add_one_signed<order>(turn, b, s, omega, omega > 0.0 ? 1.0 : -1.0, m);
  } else {
    add_one_signed<order>(a, b, s, omega, sign_on(0.5 * (a + b)), m);
  }
  return m;
}

// The same integrals of the smoothed law over xi in [-1, 1], u = c + delta xi, with xi^j in place
// of l^j.
template <Order order>
Moments quadrature_moments(double c, double delta, double eps2) {
  using Rule = boost::math::quadrature::gauss<double, 15>;
  Moments m;
  const auto add = [&](double xi, double weight) {
    const Law law(c + delta * xi, eps2);
    double w = weight;
    if constexpr (order == Order::value) {
      m.g[0] += w * law.g;
      m.g[1] += w * xi * law.g;
      return;
    }
    for (std::size_t j = 0; j < 4; ++j, w *= xi) {
      if (j < 2) m.g[j] += w * law.g;
      if (j < 3) m.g1[j] += w * law.g1;
      m.g2[j] += w * law.g2;
    }
  };
  add(0.0, Rule::weights()[0]);
  for (std::size_t i = 1; i < Rule::abscissa().size(); ++i) {
    add(Rule::abscissa()[i], Rule::weights()[i]);
    add(-Rule::abscissa()[i], Rule::weights()[i]);
  }
  return m;
}

// By parts: Int xi^n f' = [xi^n f]/delta - n/delta Int xi^(n-1) f, going down to the
// antiderivatives of g.
template <Order order>
Moments elementary_moments(double c, double delta, double eps2) {
  const Law p(c + delta, eps2);
  const Law q(c - delta, eps2);
  const double inv = 1.0 / delta;
  Moments m;
  m.g[0] = (p.first() - q.first()) * inv;
  m.g[1] = (p.first() + q.first() - second_between(p, q, eps2) * inv) * inv;
  if constexpr (order == Order::value) return m;
  m.g1[0] = (p.g - q.g) * inv;
  m.g1[1] = (p.g + q.g - m.g[0]) * inv;
  m.g1[2] = (p.g - q.g - 2.0 * m.g[1]) * inv;
  m.g2[0] = (p.g1 - q.g1) * inv;
  m.g2[1] = (p.g1 + q.g1 - m.g1[0]) * inv;
  m.g2[2] = (p.g1 - q.g1 - 2.0 * m.g1[1]) * inv;
  m.g2[3] = (p.g1 + q.g1 - 3.0 * m.g1[2]) * inv;
  return m;
}

// From powers of xi to powers of l = mid + half xi, times dl = half dxi.
template <std::size_t N>
std::array<double, N> shifted(const std::array<double, N>& x, double mid, double half) {
  std::array<double, N> y{};
  y[0] = x[0];
  y[1] = mid * x[0] + half * x[1];
  if constexpr (N > 2) y[2] = mid * mid * x[0] + 2.0 * mid * half * x[1] + half * half * x[2];
  if constexpr (N > 3) {
    y[3] = mid * mid * mid * x[0] + 3.0 * mid * mid * half * x[1] + 3.0 * mid * half * half * x[2] +
           half * half * half * x[3];
  }
  for (double& v : y) v *= half;
  return y;
}

template <Order order>
Moments smoothed_moments(double a, double b, double s, double omega, double eps) {
  const double mid = 0.5 * (a + b);
  const double half = 0.5 * (b - a);
  const double c = s + omega * mid;
  const double delta = omega * half;
  // The law's branch points lie at xi = (-c +- i eps)/delta. At a distance of 2 or more the rule's
  // error falls by (2 + sqrt 3)^2 a point; nearer, delta is large enough for the closed form not to
  // cancel.
  const bool slow_variation = c * c + eps * eps >= 4.0 * delta * delta;
  const Moments xi = slow_variation ? quadrature_moments<order>(c, delta, eps * eps)
                                    : elementary_moments<order>(c, delta, eps * eps);
  if constexpr (order == Order::value) return {shifted(xi.g, mid, half), {}, {}};
  return {shifted(xi.g, mid, half), shifted(xi.g1, mid, half), shifted(xi.g2, mid, half)};
}

Moments point_moments(double distance, double s, double omega, double eps) {
  const Law law(s + omega * distance, eps * eps);
  const double d = distance;
  return {{law.g, d * law.g},
          {law.g1, d * law.g1, d * d * law.g1},
          {law.g2, d * law.g2, d * d * law.g2, d * d * d * law.g2}};
}

DragLoad rotation_load(const model::PlanarDrag& drag, double omega, double eps) {
  const double b =
      rotation_drag_factor(drag.density, drag.coefficient, drag.width, drag.start, drag.end);
  const double eps_omega = eps / drag.end;
  const Law law(omega, eps_omega * eps_omega);
  DragLoad load;
  load.moment = -b * law.g;
  load.d(1, 1) = -b * law.g1;
  load.moment_dd(1, 1) = -b * law.g2;
  return load;
}

template <Order order>
DragLoad load_of(const model::PlanarDrag& drag, double s, double omega, double smoothing) {
  assert(smoothing >= 0.0);
  const double k = 0.5 * drag.density * drag.coefficient;
  switch (drag.kind) {
    case model::DragKind::none:
      return {};
    case model::DragKind::rotation:
      return rotation_load(drag, omega, smoothing);
    case model::DragKind::point:
      return load_from(point_moments(drag.point_distance, s, omega, smoothing),
                       k * drag.point_area);
    case model::DragKind::distributed:
      break;
  }
  if (drag.end <= drag.start) return {};
  const double a = drag.start, b = drag.end;
  return load_from(smoothing > 0.0 ? smoothed_moments<order>(a, b, s, omega, smoothing)
                                   : exact_moments<order>(a, b, s, omega),
                   k * drag.width);
}

}  // namespace

Vec2 drag_normal(const model::PlanarDrag& drag, double phi) {
  const double c = std::cos(phi);
  const double s = std::sin(phi);
  return {-s * drag.direction.x() + c * drag.direction.y(),
          -c * drag.direction.x() - s * drag.direction.y()};
}

double rotation_drag_factor(double density, double coefficient, double width, double start,
                            double end) {
  // end^4 - start^4 in factors, so that a short strip far out does not cancel.
  const double fourth = (end - start) * (end + start) * (end * end + start * start);
  return 0.125 * density * coefficient * width * fourth;
}

DragLoad drag_load(const model::PlanarDrag& drag, double s, double omega, double smoothing) {
  return load_of<Order::derivatives>(drag, s, omega, smoothing);
}

DragForce drag_force(const model::PlanarDrag& drag, double s, double omega, double smoothing) {
  const DragLoad load = load_of<Order::value>(drag, s, omega, smoothing);
  return {load.force, load.moment};
}

/// One lane at a time: each may be another case of the law.
DragLoadOf<Lanes> drag_load(const model::PlanarDrag& drag, const Lanes& s, const Lanes& omega,
                            double smoothing) {
  DragLoadOf<Lanes> load;
  for (int k = 0; k < kLanes; ++k) {
    const DragLoad one = drag_load(drag, lane(s, k), lane(omega, k), smoothing);
    set_lane(load.force, k, one.force);
    set_lane(load.moment, k, one.moment);
    for (int i = 0; i < 4; ++i) {
      set_lane(load.d.data()[i], k, one.d.data()[i]);
      set_lane(load.force_dd.data()[i], k, one.force_dd.data()[i]);
      set_lane(load.moment_dd.data()[i], k, one.moment_dd.data()[i]);
    }
  }
  return load;
}

}  // namespace jaculus::components
