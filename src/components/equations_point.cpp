// Scratch of the equations of motion, sized once for a robot and the feet in contact.

#include "jaculus/components/equations.h"
#include "jaculus/components/motor.h"

namespace jaculus::components {

Equations::Equations(const model::PlanarModel& model, double smoothing)
    : model_(model), tree_(model), smoothing_(smoothing) {
  for (int m = 0; m < count_of(model.motors); ++m)
    if (rubs(model.motors[m])) rubbing_.push_back(m);
}

EquationsPoint::EquationsPoint(const Equations& equations, const std::vector<int>& feet_in_contact)
    : feet(feet_in_contact), motion(equations.tree()) {
  const dynamics::AbsoluteTree& tree = equations.tree();
  const int N = tree.N, n = tree.n, nd = tree.nd, nu_in = equations.inputs();
  const int m = 2 * count_of(feet), w = 2 * n + nu_in;

  q = v = a = Vector::Zero(n);
  force = Vector::Zero(m);
  Z = rhs = Matrix::Zero(n + m, w);

  A = A_feet = r = nu = g_Y = g_V = chi_scratch = Vector::Zero(N);
  loop_force = kappa_l = chi_0 = chi_1 = Vector::Zero(nd);
  M = Res_Y = Res_V = YY = YV = VV = YA = NN1 = NN2 = Matrix::Zero(N, N);
  J_f = F_Y = F_V = Matrix::Zero(m, N);
  L_Y = L_V = Matrix::Zero(nd, N);

  K = Matrix::Zero(n + m, n + m);
  Gamma = dA = S_Y = Nw = Matrix::Zero(N, w);
  d_loop_force = loop_w = Matrix::Zero(nd, w);
  rhs0 = adjoint = Vector::Zero(n + m);
  MG = Nn = Nn2 = Matrix::Zero(N, n);
  MP_d = Matrix::Zero(N, nd);
  P_dt = tree.P_d.transpose();
  J_ft = Matrix::Zero(N, m);
  nw = Matrix::Zero(n, w);
  qq = qv = Matrix::Zero(n, n);

  lu = Eigen::PartialPivLU<Matrix>(n + m);
}

}  // namespace jaculus::components
