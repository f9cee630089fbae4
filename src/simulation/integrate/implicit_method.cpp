#include "simulation/integrate/implicit_method.h"

#include <algorithm>
#include <boost/numeric/odeint/stepper/rosenbrock4.hpp>
#include <cmath>
#include <limits>

namespace jaculus::simulation::detail {

namespace {

/// Of a state's size, or of 1 where that is larger, by which it is moved for a slope.
const double kMove = std::sqrt(std::numeric_limits<double>::epsilon());
/// Of a step's length, over which the slope in time is taken.
constexpr double kLater = 1e-4;

/// Coefficients by stage, then by the stage before it. Odeint's d4 lacks its sign (Hairer and
/// Wanner's is -0.0362): with it the order falls to 1 where f depends on time.
struct Coefficients {
  const boost::numeric::odeint::default_rosenbrock_coefficients<double> k;
  std::array<double, 6> time{0.0, k.c2, k.c3, k.c4, 1.0, 1.0};
  std::array<double, 6> slope{k.d1, k.d2, k.d3, -k.d4, 0.0, 0.0};
  std::array<std::array<double, 5>, 6> a{{{},
                                          {k.a21},
                                          {k.a31, k.a32},
                                          {k.a41, k.a42, k.a43},
                                          {k.a51, k.a52, k.a53, k.a54},
                                          {k.a51, k.a52, k.a53, k.a54, 1.0}}};
  std::array<std::array<double, 5>, 6> c{{{},
                                          {k.c21},
                                          {k.c31, k.c32},
                                          {k.c41, k.c42, k.c43},
                                          {k.c51, k.c52, k.c53, k.c54},
                                          {k.c61, k.c62, k.c63, k.c64, k.c65}}};
  std::array<double, 5> square{k.d21, k.d22, k.d23, k.d24, k.d25};
  std::array<double, 5> cube{k.d31, k.d32, k.d33, k.d34, k.d35};
};

const Coefficients& coefficients() {
  static const Coefficients all;
  return all;
}

Eigen::Map<Vector> mapped(State& state) {
  return {state.data(), static_cast<Eigen::Index>(state.size())};
}
Eigen::Map<const Vector> mapped(const State& state) {
  return {state.data(), static_cast<Eigen::Index>(state.size())};
}

}  // namespace

void ImplicitMethod::set_slopes(const RightHandSide& f, const Step& step) {
  const auto n = static_cast<Eigen::Index>(step.y.size());
  by_state_.resize(n, n);
  at_ = step.y;
  rate_.resize(step.y.size());
  for (std::size_t j = 0; j < at_.size(); ++j) {
    at_[j] += kMove * std::max(1.0, std::abs(step.y[j]));
    const double moved = at_[j] - step.y[j];
    f(step.t, at_, rate_);
    by_state_.col(static_cast<Eigen::Index>(j)) = (mapped(rate_) - mapped(step.dydt)) / moved;
    at_[j] = step.y[j];
  }

  const double later = kLater * step.length;
  f(step.t + later, at_, rate_);
  by_time_ = (mapped(rate_) - mapped(step.dydt)) / later;
}

void ImplicitMethod::take(const RightHandSide& f, Step& step, State& error) {
  const Coefficients& k = coefficients();
  const double h = step.length;
  set_slopes(f, step);
  by_state_ = -by_state_;
  by_state_.diagonal().array() += 1.0 / (k.k.gamma * h);
  factors_.compute(by_state_);

  rate_ = step.dydt;
  for (std::size_t i = 0; i < g_.size(); ++i) {
    if (i > 0) {
      mapped(at_) = mapped(step.y);
      for (std::size_t j = 0; j < i; ++j) mapped(at_) += k.a[i][j] * g_[j];
      f(step.t + k.time[i] * h, at_, rate_);
    }
    g_[i] = mapped(rate_) + h * k.slope[i] * by_time_;
    for (std::size_t j = 0; j < i; ++j) g_[i] += k.c[i][j] / h * g_[j];
    g_[i] = factors_.solve(g_[i]);
  }

  mapped(step.y_end) = mapped(at_) + g_.back();
  mapped(error) = g_.back();
  f(step.t + h, step.y_end, step.dydt_end);
}

void ImplicitMethod::dense(const Step& step, double t, State& out) const {
  const Coefficients& k = coefficients();
  const double s = (t - step.t) / step.length, rest = 1.0 - s;
  mapped(out) = rest * mapped(step.y) + s * mapped(step.y_end);
  for (std::size_t j = 0; j < k.square.size(); ++j)
    mapped(out) += s * rest * (k.square[j] + s * k.cube[j]) * g_[j];
}

}  // namespace jaculus::simulation::detail
