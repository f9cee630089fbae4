#include "solver/verify_motion.h"

#include <algorithm>
#include <cmath>

#include "jaculus/dynamics/rigid_body.h"

namespace jaculus::solver::detail {

namespace {
constexpr int kLedger = 6;          // feet x, z; drag x, z; motors' work; drag's work
constexpr int kMostSteps = 200000;  // of one call; a plan takes hundreds

/// Power of the motors' viscous friction at these rates, left and right [W]; dry friction they make
/// up for, so that it is in no balance.
double friction_power(const model::PlanarModel& model, const ConstVectorRef& v) {
  double power = 0.0;
  for (const model::PlanarMotor& motor : model.motors) {
    const double rate = model.joint_map.row(motor.body).dot(v);
    power -= motor.count * motor.viscous_friction * rate * rate;
  }
  return power;
}

}  // namespace

Motion78::Motion78(const components::Equations& equations, double tolerance)
    : equations_(equations),
      n_(equations.size()),
      state_(2 * n_ + kLedger, 0.0),
      stepper_(boost::numeric::odeint::make_controlled(tolerance, tolerance, Stepper())) {}

void Motion78::place(const ConstVectorRef& q, const ConstVectorRef& v) {
  std::copy_n(q.data(), n_, state_.begin());
  std::copy_n(v.data(), n_, state_.begin() + n_);
}

void Motion78::begin_phase(const std::vector<int>& feet) { point_.emplace(equations_, feet); }

bool Motion78::land() {
  components::EquationsPoint& p = *point_;
  if (!equations_.evaluate_impact(q(), v(), p)) return false;
  const dynamics::AbsoluteTree& tree = equations_.tree();
  dynamics::set_rates(tree, v(), p.motion);
  for (int k = 0; k < count_of(p.feet); ++k) {
    const Vec2 impulse = p.force.segment<2>(2 * k);
    impact_impulse_ += impulse;
    // The feet stop, so that the mean of the velocities before and after, which the impulse works
    // along, is half the one before.
    impact_work_ += 0.5 * impulse.dot(dynamics::foot_velocity(tree, p.motion, p.feet[k]));
  }
  for (int i = 0; i < n_; ++i) state_[n_ + i] += p.a[i];
  return true;
}

void Motion78::rates(const IntervalInput& input, const State& x, State& dx, double t) {
  const Eigen::Map<const Vector> q(x.data(), n_), v(x.data() + n_, n_);
  const Vector u = input.at(t);
  components::EquationsPoint& p = *point_;
  if (undefined_ || !q.allFinite() || !v.allFinite() || !equations_.evaluate(q, v, u, p)) {
    undefined_ = true;
    std::fill(dx.begin(), dx.end(), 0.0);
    return;
  }
  Eigen::Map<Vector> out(dx.data(), 2 * n_ + kLedger);
  out.head(n_) = v;
  out.segment(n_, n_) = p.a;
  Vec2 feet = Vec2::Zero();
  for (int k = 0; k < p.force.size(); k += 2) feet += p.force.segment<2>(k);
  out.segment<2>(2 * n_) = feet;
  out.segment<2>(2 * n_ + 2) = equations_.drag_force(p);
  out[2 * n_ + 4] = v.dot(equations_.tree().input_map * u) + friction_power(equations_.model(), v);
  out[2 * n_ + 5] = equations_.drag_power(p);
}

bool Motion78::advance(const IntervalInput& input, double from, double to) {
  const auto system = [&](const State& x, State& dx, double t) { rates(input, x, dx, t); };
  double t = from;
  for (int tries = 0; t < to; ++tries) {
    const bool last = step_ >= to - t;
    double dt = last ? to - t : step_, at = t;
    if (tries > kMostSteps || (!last && dt < 1e-12 * input.length)) return false;

    before_ = state_;
    undefined_ = false;
    const auto result = stepper_.try_step(system, state_, at, dt);

    const bool finite = std::all_of(state_.begin(), state_.end(),
                                    [](double value) { return std::isfinite(value); });

    if (undefined_ || !finite) {
      state_ = before_;
      step_ = 0.25 * (last ? to - t : step_);
    } else if (result == boost::numeric::odeint::success) {
      ++steps_;
      t = last ? to : at;  // a border is met exactly
      step_ = last ? std::max(step_, dt) : dt;
    } else {
      step_ = dt;
    }
  }
  return true;
}

Ledger Motion78::ledger() const {
  const Eigen::Map<const Vector> sums(state_.data() + 2 * n_, kLedger);
  return {sums.head<2>() + impact_impulse_, sums.segment<2>(2), sums[4], sums[5], impact_work_};
}

std::optional<Totals> totals(const components::Equations& equations, const ConstVectorRef& q,
                             const ConstVectorRef& v) {
  const dynamics::AbsoluteTree& tree = equations.tree();
  dynamics::Motion motion(tree);
  if (!dynamics::set_configuration(tree, q, motion)) return std::nullopt;
  dynamics::set_rates(tree, v, motion);
  Totals sums{dynamics::linear_momentum(tree, motion),
              dynamics::kinetic_energy(tree, motion, v) + dynamics::potential_energy(tree, motion)};
  for (int i = 0; i < 2; ++i)
    if (!equations.model().base_free[i]) sums.momentum[i] = 0.0;
  return sums;
}

}  // namespace jaculus::solver::detail
