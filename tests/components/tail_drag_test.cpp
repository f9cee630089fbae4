#include "jaculus/components/tail_drag.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <random>
#include <vector>

namespace jaculus::components {
namespace {

model::PlanarDrag scoop() {
  model::PlanarDrag d;
  d.coefficient = 2.0;
  d.width = 0.18;
  d.start = 0.6;
  d.end = 1.0;
  d.point_distance = 0.8;
  d.point_area = 0.4 * 0.18;
  return d;
}

struct StripState {
  double s, omega;
};

// Random states: plain, reversing along the strip, nearly uniform flow, nearly still.
std::vector<StripState> states(const model::PlanarDrag& drag, int count) {
  std::mt19937 rng(20210401);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<StripState> out;
  for (int i = 0; i < count; ++i) {
    const double omega = 30.0 * unit(rng);
    const double turn = drag.start + (drag.end - drag.start) * 0.5 * (1.0 + unit(rng));
    switch (i % 5) {
      case 0:
        out.push_back({8.0 * unit(rng), omega});
        break;
      case 1:
        out.push_back({-omega * turn, omega});
        break;
      case 2:
        out.push_back({8.0 * unit(rng), 1e-3 * omega});
        break;
      case 3:
        out.push_back({1e-3 * unit(rng), 1e-4 * omega});
        break;
      default:
        out.push_back({-omega * turn + 0.02 * unit(rng), omega});
        break;
    }
  }
  return out;
}

// Int l^j f(s + omega l) dl by adaptive Gauss-Kronrod on pieces that shrink geometrically towards
// the place where the flow turns: a kink or a near one between its nodes would deceive the rule's
// own error estimate.
double quadrature(const model::PlanarDrag& d, const StripState& x, int j, const auto& f) {
  std::vector<double> cuts{d.start, d.end};
  const double turn = -x.s / x.omega;
  for (double step = 1e-7; step < 4.0; step *= 3.0) {
    for (double cut : {turn - step, turn, turn + step}) {
      if (cut > d.start && cut < d.end) cuts.push_back(cut);
    }
  }
  std::sort(cuts.begin(), cuts.end());
  const auto integrand = [&](double l) { return std::pow(l, j) * f(x.s + x.omega * l); };
  double sum = 0.0;
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    if (cuts[i] <= cuts[i - 1]) continue;
    sum += boost::math::quadrature::gauss_kronrod<double, 31>::integrate(integrand, cuts[i - 1],
                                                                         cuts[i], 6, 1e-11);
  }
  return sum;
}

TEST(TailDrag, ForceAloneIsThatOfTheLoad) {
  for (const model::DragKind kind : {model::DragKind::none, model::DragKind::rotation,
                                     model::DragKind::point, model::DragKind::distributed}) {
    model::PlanarDrag drag = scoop();
    drag.kind = kind;
    for (const double smoothing : {0.0, 0.02}) {
      for (const StripState& x : states(drag, 100)) {
        const DragLoad load = drag_load(drag, x.s, x.omega, smoothing);
        const DragForce force = drag_force(drag, x.s, x.omega, smoothing);
        EXPECT_DOUBLE_EQ(force.force, load.force);
        EXPECT_DOUBLE_EQ(force.moment, load.moment);
      }
    }
  }
}

TEST(TailDrag, EquationEightEqualsAdaptiveQuadrature) {
  for (double start : {0.0, 0.6, 0.97}) {
    model::PlanarDrag d = scoop();
    d.start = start;
    const double k = 0.5 * d.density * d.coefficient * d.width;
    int reversing = 0;
    for (const StripState& x : states(d, 250)) {
      const DragLoad load = drag_load(d, x.s, x.omega, 0.0);
      const auto law = [](double u) { return u * std::abs(u); };
      const auto slope = [](double u) { return 2.0 * std::abs(u); };
      const double u = std::max(std::abs(x.s + x.omega * d.start), std::abs(x.s + x.omega * d.end));
      const double scale = k * (d.end - d.start);
      EXPECT_NEAR(load.force, -k * quadrature(d, x, 0, law), 1e-10 * scale * u * u);
      EXPECT_NEAR(load.moment, -k * quadrature(d, x, 1, law), 1e-10 * scale * u * u);
      EXPECT_NEAR(load.d(0, 0), -k * quadrature(d, x, 0, slope), 1e-10 * scale * u);
      EXPECT_NEAR(load.d(1, 0), -k * quadrature(d, x, 1, slope), 1e-10 * scale * u);
      EXPECT_NEAR(load.d(0, 1), load.d(1, 0), 1e-15);
      EXPECT_NEAR(load.d(1, 1), -k * quadrature(d, x, 2, slope), 1e-10 * scale * u);
      reversing += (x.s + x.omega * d.start) * (x.s + x.omega * d.end) < 0.0 ? 1 : 0;
    }
    EXPECT_GT(reversing, 80);
  }
}

TEST(TailDrag, WithoutTranslationEquationEightIsEquationTwo) {
  model::PlanarDrag d = scoop();
  model::PlanarDrag rotation = d;
  rotation.kind = model::DragKind::rotation;
  // 1/8 * 1.225 * 2 * 0.18 * (1 - 0.6^4) * 25^2, and against the motion.
  const double expected = -0.125 * 1.225 * 2.0 * 0.18 * (1.0 - 0.1296) * 625.0;
  EXPECT_NEAR(drag_load(d, 0.0, 25.0, 0.0).moment, expected, 1e-12);
  EXPECT_NEAR(drag_load(rotation, 3.0, 25.0, 0.0).moment, expected, 1e-12);
  EXPECT_NEAR(drag_load(rotation, 3.0, -25.0, 0.0).moment, -expected, 1e-12);
  EXPECT_EQ(drag_load(rotation, 3.0, 25.0, 0.0).force, 0.0);
  EXPECT_EQ(drag_load(rotation, 3.0, 25.0, 0.0).d(1, 0), 0.0);
}

TEST(TailDrag, PointForceActsAtItsDistance) {
  model::PlanarDrag d = scoop();
  d.kind = model::DragKind::point;
  const double u = 1.5 + 0.8 * 20.0;
  const DragLoad load = drag_load(d, 1.5, 20.0, 0.0);
  EXPECT_NEAR(load.force, -0.5 * 1.225 * 2.0 * 0.072 * u * u, 1e-12);
  EXPECT_NEAR(load.moment, 0.8 * load.force, 1e-12);
  EXPECT_EQ(drag_load(d, -1.5, -20.0, 0.0).force, -load.force);
}

TEST(TailDrag, SmoothedLawEqualsAdaptiveQuadrature) {
  for (double start : {0.0, 0.6}) {
    model::PlanarDrag d = scoop();
    d.start = start;
    const double k = 0.5 * d.density * d.coefficient * d.width;
    for (double eps : {1e-3, 0.05, 1.0}) {
      const auto r = [eps](double u) { return std::sqrt(u * u + eps * eps); };
      const auto g = [&](double u) { return u * r(u); };
      const auto g1 = [&](double u) { return r(u) + u * u / r(u); };
      const auto g2 = [&](double u) { return u / r(u) * (3.0 - u * u / (r(u) * r(u))); };
      for (const StripState& x : states(d, 60)) {
        const DragLoad load = drag_load(d, x.s, x.omega, eps);
        const double u = eps + std::abs(x.s) + std::abs(x.omega);
        EXPECT_NEAR(load.force, -k * quadrature(d, x, 0, g), 1e-12 * k * u * u);
        EXPECT_NEAR(load.moment, -k * quadrature(d, x, 1, g), 1e-12 * k * u * u);
        EXPECT_NEAR(load.d(0, 0), -k * quadrature(d, x, 0, g1), 1e-11 * k * u);
        EXPECT_NEAR(load.d(0, 1), -k * quadrature(d, x, 1, g1), 1e-11 * k * u);
        EXPECT_NEAR(load.d(1, 0), load.d(0, 1), 1e-15);
        EXPECT_NEAR(load.d(1, 1), -k * quadrature(d, x, 2, g1), 1e-11 * k * u);
        EXPECT_NEAR(load.force_dd(0, 0), -k * quadrature(d, x, 0, g2), 1e-9 * k);
        EXPECT_NEAR(load.force_dd(0, 1), -k * quadrature(d, x, 1, g2), 1e-9 * k);
        EXPECT_NEAR(load.force_dd(1, 1), -k * quadrature(d, x, 2, g2), 1e-9 * k);
        EXPECT_NEAR(load.moment_dd(1, 1), -k * quadrature(d, x, 3, g2), 1e-9 * k);
        EXPECT_EQ(load.moment_dd(0, 0), load.force_dd(0, 1));
        EXPECT_EQ(load.moment_dd(0, 1), load.force_dd(1, 1));
        EXPECT_EQ(load.moment_dd, load.moment_dd.transpose());
      }
    }
  }
}

TEST(TailDrag, DerivativesOfEveryKindAgreeWithDifferences) {
  const double eps = 0.3, h = 1e-3;
  for (model::DragKind kind : {model::DragKind::distributed, model::DragKind::point,
                               model::DragKind::rotation, model::DragKind::none}) {
    model::PlanarDrag d = scoop();
    d.kind = kind;
    for (const StripState& x : states(d, 100)) {
      const DragLoad load = drag_load(d, x.s, x.omega, eps);
      for (int j = 0; j < 2; ++j) {
        const auto at = [&](double step) {
          return drag_load(d, x.s + (j == 0 ? step : 0.0), x.omega + (j == 1 ? step : 0.0), eps);
        };
        const DragLoad a = at(h), b = at(-h), aa = at(2 * h), bb = at(-2 * h);
        const auto slope = [&](const auto& f) {
          return (8.0 * (f(a) - f(b)) - (f(aa) - f(bb))) / (12.0 * h);
        };
        EXPECT_NEAR(load.d(0, j), slope([](const DragLoad& l) { return l.force; }), 1e-9);
        EXPECT_NEAR(load.d(1, j), slope([](const DragLoad& l) { return l.moment; }), 1e-9);
        for (int i = 0; i < 2; ++i) {
          EXPECT_NEAR(load.force_dd(i, j), slope([i](const DragLoad& l) { return l.d(0, i); }),
                      1e-9);
          EXPECT_NEAR(load.moment_dd(i, j), slope([i](const DragLoad& l) { return l.d(1, i); }),
                      1e-9);
        }
      }
    }
  }
}

TEST(TailDrag, SmoothingErrsByNoMoreThanTheStatedBound) {
  for (model::DragKind kind :
       {model::DragKind::distributed, model::DragKind::point, model::DragKind::rotation}) {
    model::PlanarDrag d = scoop();
    d.kind = kind;
    const double rho_c = 0.5 * d.density * d.coefficient;
    const double k = rho_c * d.width;
    for (double eps : {1e-3, 0.05, 0.5}) {
      double force_bound = k * eps * eps * (d.end - d.start) / 2.0;
      double moment_bound = k * eps * eps * (d.end * d.end - d.start * d.start) / 4.0;
      if (kind == model::DragKind::point) {
        force_bound = rho_c * d.point_area * eps * eps / 2.0;
        moment_bound = d.point_distance * force_bound;
      } else if (kind == model::DragKind::rotation) {
        moment_bound =
            k * (std::pow(d.end, 4) - std::pow(d.start, 4)) * eps * eps / (8.0 * d.end * d.end);
      }
      double worst = 0.0;
      for (const StripState& x : states(d, 300)) {
        const DragLoad smooth = drag_load(d, x.s, x.omega, eps);
        const DragLoad exact = drag_load(d, x.s, x.omega, 0.0);
        EXPECT_LE(std::abs(smooth.force - exact.force), force_bound + 1e-12);
        EXPECT_LE(std::abs(smooth.moment - exact.moment), moment_bound + 1e-12);
        worst = std::max(worst, std::abs(smooth.moment - exact.moment));
      }
      EXPECT_GT(worst, 0.5 * moment_bound - 1e-12);  // the bound is not idle
    }
  }
}

TEST(TailDrag, AtRestThereIsNoLoadAndNoNaN) {
  for (model::DragKind kind :
       {model::DragKind::distributed, model::DragKind::point, model::DragKind::rotation}) {
    model::PlanarDrag d = scoop();
    d.kind = kind;
    for (double eps : {0.0, 0.01}) {
      const DragLoad load = drag_load(d, 0.0, 0.0, eps);
      EXPECT_EQ(load.force, 0.0);
      EXPECT_EQ(load.moment, 0.0);
      EXPECT_TRUE(load.d.allFinite() && load.force_dd.allFinite() && load.moment_dd.allFinite());
    }
  }
}

TEST(TailDrag, NormalPointsWhereTheTailMoves) {
  model::PlanarDrag d = scoop();
  d.direction = Vec2(0.6, 0.8);
  const auto tip = [&](double phi) {
    Mat2 r;
    r << std::cos(phi), std::sin(phi), -std::sin(phi), std::cos(phi);
    return Vec2(r * d.direction);
  };
  for (double phi : {-2.0, 0.0, 0.7}) {
    const Vec2 difference = (tip(phi + 1e-5) - tip(phi - 1e-5)) / 2e-5;
    EXPECT_LT((drag_normal(d, phi) - difference).norm(), 1e-9);
  }
  d.direction = Vec2(0.0, 1.0);
  EXPECT_LT((drag_normal(d, 0.3) - Vec2(std::cos(0.3), -std::sin(0.3))).norm(), 1e-15);
}

}  // namespace
}  // namespace jaculus::components
