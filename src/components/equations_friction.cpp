// Friction of the motors in the equations of motion: B tau_f(W v) on the right-hand side, W the
// rows of the joint map at the motors. With y the first n rows of K^-T mu,
//   d(B tau_f)/dv         = B diag(tau_f') W,
//   d2(mu . (a, f))/dv2  += sum_m (y . B_m) tau_f''_m W_m^T W_m.

#include "jaculus/components/equations.h"
#include "jaculus/components/motor.h"

namespace jaculus::components {

namespace {

/// Rates of a motor's joint by those of the coordinates.
auto rate_row(const model::PlanarModel& model, int motor) {
  return model.joint_map.row(model.motors[motor].body);
}

MotorFriction friction_at(const model::PlanarModel& model, int motor, const Vector& v) {
  return motor_friction(model.motors[motor], rate_row(model, motor).dot(v));
}

}  // namespace

void Equations::add_friction(EquationsPoint& p) const {
  for (const int m : rubbing_)
    p.rhs0.head(tree_.n) += friction_at(model_, m, p.v).value * tree_.input_map.col(m);
}

void Equations::add_friction_derivatives(EquationsPoint& p) const {
  const int n = tree_.n;
  for (const int m : rubbing_) {
    p.rhs.topRows(n).middleCols(n, n).noalias() +=
        friction_at(model_, m, p.v).d_rate * tree_.input_map.col(m) * rate_row(model_, m);
  }
}

void Equations::add_friction_hessian(const EquationsPoint& p, Matrix& H) const {
  const int n = tree_.n;
  for (const int m : rubbing_) {
    const double weight =
        p.adjoint.head(n).dot(tree_.input_map.col(m)) * friction_at(model_, m, p.v).d_rate2;
    H.block(n, n, n, n).noalias() += weight * rate_row(model_, m).transpose() * rate_row(model_, m);
  }
}

}  // namespace jaculus::components
