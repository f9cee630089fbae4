// Viscous friction of the motors in the equations of motion: -B b W v on the right-hand side, W the
// rows of the joint map at the motors. Linear, so that it has no part in second derivatives. The
// dry part is the motor's to make up for (motor.h).

#include "jaculus/components/equations.h"

namespace jaculus::components {

template <class S>
void Equations::add_friction(EquationsPointOf<S>& p) const {
  for (const int m : rubbing_) {
    const auto row = model_.joint_map.row(model_.motors[m].body);
    S rate = S(0.0);
    for (int j = 0; j < tree_.n; ++j) rate += S(row[j]) * p.v[j];

    const S torque = rate * S(-model_.motors[m].viscous_friction);
    for (int i = 0; i < tree_.n; ++i) p.adjoint[i] += torque * S(tree_.input_map(i, m));
  }
}

template <class S>
void Equations::add_friction_derivatives(EquationsPointOf<S>& p) const {
  const int n = tree_.n;
  for (const int m : rubbing_) {
    const auto row = model_.joint_map.row(model_.motors[m].body);
    const double slope = -model_.motors[m].viscous_friction;
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) p.Z(i, n + j) += S(slope * row[j] * tree_.input_map(i, m));
  }
}

#define JACULUS_INSTANTIATE(S)                                          \
  template void Equations::add_friction<S>(EquationsPointOf<S>&) const; \
  template void Equations::add_friction_derivatives<S>(EquationsPointOf<S>&) const;

JACULUS_INSTANTIATE(double)
JACULUS_INSTANTIATE(Lanes)
#undef JACULUS_INSTANTIATE

}  // namespace jaculus::components
