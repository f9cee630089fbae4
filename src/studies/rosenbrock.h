#pragma once
// One step of a stiffly accurate, L-stable Rosenbrock method of order 4 with an embedded result of
// order 3, for autonomous systems of a size known at compile time, without allocation.
//
//   (I/(h gamma) - J) g_i = f(x + sum_j a_ij g_j) + (1/h) sum_j c_ij g_j,   i = 1..6,   J = df/dx
//   x_new = x + sum_j a_5j g_j + g_5 + g_6,   error estimate g_6
//
// The coefficients are those of RODAS (Hairer and Wanner, Solving Ordinary Differential Equations
// II, section IV.7), taken from Boost.Odeint. The first N of the states feed back; the last Q are
// mere integrals of them (their columns of J are zero), so only an N x N matrix is inverted.

#include <Eigen/Core>
#include <Eigen/LU>
#include <boost/numeric/odeint/stepper/rosenbrock4.hpp>

namespace jaculus::studies::detail {

template <int N, int Q>
using StateOf = Eigen::Matrix<double, N + Q, 1>;

/// A system offers `enum { N, Q }`, `State rhs(const State&)` and `Matrix<double, N + Q, N>
/// jacobian(const State&)`.
template <class System>
class RosenbrockStep {
 public:
  static constexpr int N = System::N;
  static constexpr int Q = System::Q;
  using State = StateOf<N, Q>;
  using Jacobian = Eigen::Matrix<double, N + Q, N>;

  /// Prepares steps that start from x: one right-hand side and one Jacobian, however often the size
  /// h is changed.
  RosenbrockStep(const System& system, const State& x)
      : system_(system), x_(x), f_(system.rhs(x)), jacobian_(system.jacobian(x)) {}

  [[nodiscard]] const State& derivative() const { return f_; }

  /// The state after a step of size h, and the error estimate.
  State step(double h, State& error) const {
    const auto& k = coefficients();
    const double inv_h = 1.0 / h;
    const Solver solve(*this, inv_h / k.gamma);
    const State g1 = solve(f_);
    const State g2 = solve(system_.rhs(x_ + k.a21 * g1) + (inv_h * k.c21) * g1);
    const State g3 =
        solve(system_.rhs(x_ + k.a31 * g1 + k.a32 * g2) + inv_h * (k.c31 * g1 + k.c32 * g2));
    const State g4 = solve(system_.rhs(x_ + k.a41 * g1 + k.a42 * g2 + k.a43 * g3) +
                           inv_h * (k.c41 * g1 + k.c42 * g2 + k.c43 * g3));
    State x = x_ + k.a51 * g1 + k.a52 * g2 + k.a53 * g3 + k.a54 * g4;
    const State g5 =
        solve(system_.rhs(x) + inv_h * (k.c51 * g1 + k.c52 * g2 + k.c53 * g3 + k.c54 * g4));
    x += g5;
    error = solve(system_.rhs(x) +
                  inv_h * (k.c61 * g1 + k.c62 * g2 + k.c63 * g3 + k.c64 * g4 + k.c65 * g5));
    return x + error;
  }

 private:
  using Coefficients = boost::numeric::odeint::default_rosenbrock_coefficients<double>;
  static const Coefficients& coefficients() {
    static const Coefficients k;
    return k;
  }

  class Solver {
   public:
    Solver(const RosenbrockStep& step, double shift)
        : jacobian_(step.jacobian_), inv_shift_(1.0 / shift) {
      Eigen::Matrix<double, N, N> w = -jacobian_.template topRows<N>();
      w.diagonal().array() += shift;
      inverse_ = w.inverse();
    }
    State operator()(const State& r) const {
      State g;
      g.template head<N>().noalias() = inverse_ * r.template head<N>();
      if constexpr (Q > 0) {
        g.template tail<Q>() =
            inv_shift_ *
            (r.template tail<Q>() + jacobian_.template bottomRows<Q>() * g.template head<N>());
      }
      return g;
    }

   private:
    const Jacobian& jacobian_;
    double inv_shift_;
    Eigen::Matrix<double, N, N> inverse_;
  };

  const System& system_;
  State x_;
  State f_;
  Jacobian jacobian_;
};

}  // namespace jaculus::studies::detail
