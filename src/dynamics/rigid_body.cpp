#include "jaculus/dynamics/rigid_body.h"

#include <Eigen/LU>
#include <cassert>

namespace jaculus::dynamics {

template <class S>
JACULUS_WIDE void add_bodies(const AbsoluteTree& tree, const MotionOf<S>& motion,
                             const VectorOf<S>& A, MatrixOf<S>& mass, VectorOf<S>& residual,
                             PointColumnsOf<S>& J) {
  for (int b = 0; b < count_of(tree.com); ++b) {
    const int phi = AbsoluteTree::angle_index(b);
    const S m = S(tree.mass[b]), inertia = S(tree.inertia[b]);
    mass(phi, phi) += inertia;
    residual[phi] += inertia * A[phi];
    if (tree.mass[b] == 0.0) continue;

    jacobian_columns(tree.com[b], motion.pose, J);
    for (int j = 0; j < J.count; ++j) {
      const S x = m * J.x[j], z = m * J.z[j];
      S* column = mass.col(J.index[j]).data();
      for (int i = 0; i < J.count; ++i) column[J.index[i]] += J.x[i] * x + J.z[i] * z;
    }
    Vec2Of<S> acceleration = J.times(A) + quadratic(tree.com[b], motion.pose, motion.V);
    acceleration.y() += S(tree.gravity);
    J.add_transposed(acceleration, tree.mass[b], residual);
  }
}

template void add_bodies<double>(const AbsoluteTree&, const Motion&, const Vector&, Matrix&,
                                 Vector&, PointColumns&);
template void add_bodies<Lanes>(const AbsoluteTree&, const MotionOf<Lanes>&, const VectorOf<Lanes>&,
                                MatrixOf<Lanes>&, VectorOf<Lanes>&, PointColumnsOf<Lanes>&);

Matrix mass_matrix(const AbsoluteTree& tree, const Motion& motion) {
  Matrix M = Matrix::Zero(tree.N, tree.N);
  Vector unused = Vector::Zero(tree.N);
  PointColumns J;
  add_bodies<double>(tree, motion, Vector::Zero(tree.N), M, unused, J);
  return motion.G.transpose() * M * motion.G + tree.armature;
}

Vector bias(const AbsoluteTree& tree, const Motion& motion) {
  Matrix unused = Matrix::Zero(tree.N, tree.N);
  Vector r = Vector::Zero(tree.N);
  PointColumns J;
  add_bodies(tree, motion, motion.gamma, unused, r, J);
  return motion.G.transpose() * r;
}

Matrix foot_jacobian(const AbsoluteTree& tree, const Motion& motion, const std::vector<int>& feet) {
  Matrix in_absolute = Matrix::Zero(2 * count_of(feet), tree.N);
  PointColumns J;
  for (int f = 0; f < count_of(feet); ++f) {
    const int row = 2 * f;
    jacobian_columns(tree.feet[feet[f]], motion.pose, J);
    for (int k = 0; k < J.count; ++k) {
      in_absolute(row, J.index[k]) += J.x[k];
      in_absolute(row + 1, J.index[k]) += J.z[k];
    }
  }
  return in_absolute * motion.G;
}

Vec2 foot_position(const AbsoluteTree& tree, const Motion& motion, int foot) {
  return position(tree.feet[foot], motion.pose);
}

Vec2 foot_velocity(const AbsoluteTree& tree, const Motion& motion, int foot) {
  PointColumns J;
  jacobian_columns(tree.feet[foot], motion.pose, J);
  return J.times(motion.V);
}

Vec2 point_acceleration(const PointSum& point, const Motion& motion, const Vector& a) {
  const Vector A = motion.G * a + motion.gamma;
  PointColumns J;
  Vec2 sum = Vec2::Zero();
  for (const WeightedPath& part : point) {
    jacobian_columns(part.path, motion.pose, J);
    sum += part.weight * (J.times(A) + quadratic(part.path, motion.pose, motion.V));
  }
  return sum;
}

Vector inverse_dynamics(const AbsoluteTree& tree, const Motion& motion, const Vector& a,
                        const std::vector<int>& feet, const Vector& force) {
  assert(a.size() == tree.n && force.size() == 2 * count_of(feet));
  return mass_matrix(tree, motion) * a + bias(tree, motion) -
         foot_jacobian(tree, motion, feet).transpose() * force;
}

namespace {

/// Solves [M -J^T; J 0] (x, f) = (top, bottom).
ContactSolution solve_contact(const Matrix& M, const Matrix& J, const Vector& top,
                              const Vector& bottom) {
  const Eigen::Index n = M.rows(), m = J.rows();
  Matrix K = Matrix::Zero(n + m, n + m);
  K.topLeftCorner(n, n) = M;
  K.topRightCorner(n, m) = -J.transpose();
  K.bottomLeftCorner(m, n) = J;
  Vector right(n + m);
  right << top, bottom;
  const Eigen::FullPivLU<Matrix> lu(K);
  if (!K.allFinite() || !lu.isInvertible()) return {};
  const Vector solution = lu.solve(right);
  return {true, solution.head(n), solution.tail(m)};
}

}  // namespace

ContactSolution forward_dynamics(const AbsoluteTree& tree, const Motion& motion,
                                 const Vector& generalised_force, const std::vector<int>& feet) {
  Vector bottom(2 * count_of(feet));
  for (int f = 0; f < count_of(feet); ++f) {
    bottom.segment<2>(2 * f) =
        -point_acceleration(foot_point(tree, feet[f]), motion, Vector::Zero(tree.n));
  }
  return solve_contact(mass_matrix(tree, motion), foot_jacobian(tree, motion, feet),
                       generalised_force - bias(tree, motion), bottom);
}

ContactSolution plastic_impact(const AbsoluteTree& tree, const Motion& motion, const Vector& v,
                               const std::vector<int>& feet) {
  const Matrix M = mass_matrix(tree, motion);
  return solve_contact(M, foot_jacobian(tree, motion, feet), M * v,
                       Vector::Zero(2 * count_of(feet)));
}

Vec2 centre_of_mass(const AbsoluteTree& tree, const Motion& motion) {
  return point_position(centre_of_mass_point(tree), motion);
}

Vec2 centre_of_mass_velocity(const AbsoluteTree& tree, const Motion& motion) {
  return point_velocity(centre_of_mass_point(tree), motion);
}

Vec2 linear_momentum(const AbsoluteTree& tree, const Motion& motion) {
  return tree.total_mass * centre_of_mass_velocity(tree, motion);
}

double angular_momentum(const AbsoluteTree& tree, const Motion& motion, const Vec2& about) {
  PointColumns J;
  double sum = 0.0;
  for (int b = 0; b < count_of(tree.com); ++b) {
    jacobian_columns(tree.com[b], motion.pose, J);
    const Vec2 r = position(tree.com[b], motion.pose) - about, velocity = J.times(motion.V);
    sum += tree.mass[b] * (r.y() * velocity.x() - r.x() * velocity.y());
    sum += tree.inertia[b] * motion.V[AbsoluteTree::angle_index(b)];
  }
  return sum;
}

double angular_momentum(const AbsoluteTree& tree, const Motion& motion) {
  // Momentum about a point fixed at the centre of mass: its own motion adds nothing there.
  return angular_momentum(tree, motion, centre_of_mass(tree, motion));
}

double kinetic_energy(const AbsoluteTree& tree, const Motion& motion, const Vector& v) {
  PointColumns J;
  double twice = v.dot(tree.armature * v);
  for (int b = 0; b < count_of(tree.com); ++b) {
    jacobian_columns(tree.com[b], motion.pose, J);
    const double turn = motion.V[AbsoluteTree::angle_index(b)];
    twice += tree.mass[b] * J.times(motion.V).squaredNorm() + tree.inertia[b] * turn * turn;
  }
  return 0.5 * twice;
}

double potential_energy(const AbsoluteTree& tree, const Motion& motion) {
  double sum = 0.0;
  for (std::size_t b = 0; b < tree.com.size(); ++b)
    sum += tree.mass[b] * tree.gravity * position(tree.com[b], motion.pose).y();
  return sum;
}

}  // namespace jaculus::dynamics
