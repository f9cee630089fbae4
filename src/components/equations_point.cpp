// Scratch of the equations of motion, sized once for a robot and the feet in contact.

#include "jaculus/components/equations.h"

namespace jaculus::components {

Equations::Equations(const model::PlanarModel& model, double smoothing)
    : model_(model), tree_(model), smoothing_(smoothing) {
  for (int m = 0; m < count_of(model.motors); ++m)
    if (model.motors[m].viscous_friction != 0.0) rubbing_.push_back(m);
}

namespace {

template <class S>
std::vector<DragPointOf<S>> drags_of(const Equations& equations) {
  std::vector<DragPointOf<S>> drags;
  for (int k = 0; k < count_of(equations.model().drags); ++k) {
    const model::PlanarDrag& drag = equations.model().drags[k];
    if (drag.kind == model::DragKind::none || drag.coefficient == 0.0) continue;

    DragPointOf<S>& flow = drags.emplace_back();
    flow.drag = k;
    const dynamics::AbsoluteTree& tree = equations.tree();
    const dynamics::Pose pose{tree.Y_0, Vector::Zero(tree.N), Vector::Zero(tree.N)};
    dynamics::PointColumns J;
    dynamics::jacobian_columns(tree.origin[drag.body], pose, J);
    flow.index.assign(J.index, J.index + J.count);
    flow.index.push_back(dynamics::AbsoluteTree::angle_index(drag.body));
    flow.s_Y = flow.s_V = flow.slip_Y = std::vector<S>(flow.index.size(), S(0.0));
  }
  return drags;
}

}  // namespace

template <class S>
EquationsPointOf<S>::EquationsPointOf(const Equations& equations,
                                      const std::vector<int>& feet_in_contact)
    : feet(feet_in_contact),
      motion(equations.tree()),
      saddle(equations.tree().n, 2 * count_of(feet_in_contact)),
      drags(drags_of<S>(equations)) {
  const dynamics::AbsoluteTree& tree = equations.tree();
  const int N = tree.N, n = tree.n, nd = tree.nd;
  const int m = 2 * count_of(feet), w = 2 * n + equations.inputs();
  const auto zeros = [](int rows, int columns) {
    return MatrixOf<S>::Constant(rows, columns, 0.0);
  };

  q = v = a = zeros(n, 1);
  force = zeros(m, 1);
  Z = zeros(n + m, w);
  mass = zeros(n, n);

  A = A_feet = r = nu = g_Y = g_V = zeros(N, 1);
  loop_force = kappa_l = chi_0 = chi_1 = zeros(nd, 1);
  M = Res_Y = Res_V = YY = YV = VV = YA = zeros(N, N);
  MG = zeros(N, n);
  J_f = F_Y = F_V = zeros(m, N);
  J_G = zeros(m, n);
  L_Y = L_V = zeros(nd, N);
  chain = zeros(N, 2 * n);
  D_feet = zeros(N, m);
  D_loops = zeros(N, nd);

  d_loops = loop_w = balance = zeros(nd, 2 * n);
  PMG = zeros(nd, n);
  PMG_t = zeros(n, nd);
  PMP = C_d_inverse_t = zeros(nd, nd);
  JP = zeros(m, nd);
  JP_t = zeros(nd, m);

  adjoint = zeros(n + m, 1);
  GY = GV = XV = zeros(n, N);
  GD = GA = GAP = zeros(n, nd);
  left = zeros(n, n + m);
  qq = qv = vv = zeros(n, n);
  nw = zeros(n, w);
}

template struct EquationsPointOf<double>;
template struct EquationsPointOf<Lanes>;

}  // namespace jaculus::components
