#pragma once
// The re-integrated motion: state (q, v) and a ledger of impulses and work, advanced by
// Runge-Kutta-Fehlberg 7(8).

#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/generation/generation_controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/generation/generation_runge_kutta_fehlberg78.hpp>
#include <boost/numeric/odeint/stepper/generation/make_controlled.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <optional>
#include <vector>

#include "jaculus/components/equations.h"

namespace jaculus::solver::detail {

/// The input over one interval: linear from `first` to `last`, equal where it is held.
struct IntervalInput {
  Vector first, last;   ///< n_u
  double length = 0.0;  ///< [s]
  [[nodiscard]] Vector at(double t) const { return first + (t / length) * (last - first); }
};

/// Impulses and work since the motion's start.
struct Ledger {
  Vec2 feet = Vec2::Zero();  ///< [N s]
  Vec2 drag = Vec2::Zero();  ///< [N s]
  double motor_work = 0.0;   ///< less the motors' own friction [J]
  double drag_work = 0.0;    ///< [J]
  double impact_work = 0.0;  ///< [J]
};

class Motion78 {
 public:
  Motion78(const components::Equations& equations, double tolerance);

  /// Sets the state; the ledger stays.
  void place(const ConstVectorRef& q, const ConstVectorRef& v);
  void begin_phase(const std::vector<int>& feet);
  /// A plastic impact of the phase's feet. False where it is not defined.
  bool land();
  /// Integrates from `from` to `to`, times within the interval. False where that is impossible; the
  /// state is then the last good one.
  bool advance(const IntervalInput& input, double from, double to);
  /// Evaluates the equations at the present state with input u. False where they are not defined.
  bool observe(const ConstVectorRef& u) { return equations_.evaluate(q(), v(), u, *point_); }

  [[nodiscard]] Eigen::Map<const Vector> q() const { return {state_.data(), n_}; }
  [[nodiscard]] Eigen::Map<const Vector> v() const { return {state_.data() + n_, n_}; }
  [[nodiscard]] components::EquationsPoint& point() { return *point_; }
  [[nodiscard]] Ledger ledger() const;
  [[nodiscard]] int steps() const { return steps_; }

 private:
  using State = std::vector<double>;
  using Stepper = boost::numeric::odeint::runge_kutta_fehlberg78<State>;
  void rates(const IntervalInput& input, const State& x, State& dx, double t);

  const components::Equations& equations_;
  int n_;
  State state_, before_;
  std::optional<components::EquationsPoint> point_;
  boost::numeric::odeint::result_of::make_controlled<Stepper>::type stepper_;
  Vec2 impact_impulse_ = Vec2::Zero();
  double impact_work_ = 0.0;
  double step_ = 1e-3;  ///< last size that the error control asked for [s]
  bool undefined_ = false;
  int steps_ = 0;
};

/// Momentum along the free directions of the base (others zero) [N s] and energy [J].
struct Totals {
  Vec2 momentum;
  double energy;
};
/// At a state; nothing where the loops can't close.
std::optional<Totals> totals(const components::Equations& equations, const ConstVectorRef& q,
                             const ConstVectorRef& v);

}  // namespace jaculus::solver::detail
