// Friction of the motors in the equations of motion: B tau_f(W v) on the right-hand side, W the
// rows of the joint map at the motors. With y the first n rows of K^-T mu,
//   d(B tau_f)/dv         = B diag(tau_f') W,
//   d2(mu . (a, f))/dv2  += sum_m (y . B_m) tau_f''_m W_m^T W_m.

#include "jaculus/components/equations.h"
#include "jaculus/components/motor.h"

namespace jaculus::components {

namespace {

template <class S>
struct Friction {
  S value, d_rate, d_rate2;
};

/// Torque of a motor's friction at the rate of its joint, with derivatives.
template <class S>
Friction<S> friction_at(const model::PlanarModel& model, int motor, const VectorOf<S>& v) {
  S rate = S(0.0);
  for (int i = 0; i < count_of(v); ++i)
    rate += S(model.joint_map(model.motors[motor].body, i)) * v[i];

  Friction<S> friction;
  for (int k = 0; k < lanes_of<S>; ++k) {
    const MotorFriction one = motor_friction(model.motors[motor], lane(rate, k));
    set_lane(friction.value, k, one.value);
    set_lane(friction.d_rate, k, one.d_rate);
    set_lane(friction.d_rate2, k, one.d_rate2);
  }
  return friction;
}

}  // namespace

template <class S>
void Equations::add_friction(EquationsPointOf<S>& p) const {
  for (const int m : rubbing_) {
    const S value = friction_at(model_, m, p.v).value;
    for (int i = 0; i < tree_.n; ++i) p.adjoint[i] += value * S(tree_.input_map(i, m));
  }
}

template <class S>
void Equations::add_friction_derivatives(EquationsPointOf<S>& p) const {
  const int n = tree_.n;
  for (const int m : rubbing_) {
    const S slope = friction_at(model_, m, p.v).d_rate;
    for (int j = 0; j < n; ++j) {
      const S by_rate = slope * S(model_.joint_map(model_.motors[m].body, j));
      for (int i = 0; i < n; ++i) p.Z(i, n + j) += by_rate * S(tree_.input_map(i, m));
    }
  }
}

template <class S>
void Equations::add_friction_hessian(const EquationsPointOf<S>& p, MatrixOf<S>& H) const {
  const int n = tree_.n;
  for (const int m : rubbing_) {
    S weight = S(0.0);
    for (int i = 0; i < n; ++i) weight += p.adjoint[i] * S(tree_.input_map(i, m));
    weight *= friction_at(model_, m, p.v).d_rate2;

    const auto row = model_.joint_map.row(model_.motors[m].body);
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) H(n + i, n + j) += weight * S(row[i] * row[j]);
  }
}

#define JACULUS_INSTANTIATE(S)                                                      \
  template void Equations::add_friction<S>(EquationsPointOf<S>&) const;             \
  template void Equations::add_friction_derivatives<S>(EquationsPointOf<S>&) const; \
  template void Equations::add_friction_hessian<S>(const EquationsPointOf<S>&, MatrixOf<S>&) const;

JACULUS_INSTANTIATE(double)
JACULUS_INSTANTIATE(Lanes)
#undef JACULUS_INSTANTIATE

}  // namespace jaculus::components
