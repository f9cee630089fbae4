#pragma once
// Planar kinematics in absolute coordinates.
//
// Absolute coordinates Y (size N): x, z of the base, the absolute angle phi_b of every body, the
// displacement l_j of every prismatic joint. They depend on the generalised coordinates q (n) and
// the dependent joints d (nd) by a constant map:
//     Y = P q + P_d d + Y_0.
// In them a point is a sum of segments, so that every derivative of any order is a line of
// trigonometry:
//     p = (x, z) + sum_s R(phi_s) r_s  [+ l_j R(phi_s) e_j for a prismatic joint].
//
// Derivatives of p, with contraction by a weight w (2) and rates X, V (N), e' = dR/dphi e:
//     J        = dp/dY                                       (2 x N)
//     D(X)     = d(J X)/dY                                   (2 x N)
//     E(V)     = d(V^T d2p V)/dY                             (2 x N)
//       so d(pdd)/dY = D(A) + E(V), d(pdd)/dV = 2 D(V)
//     H(w)     = d2(w.p)/dY2                                 (N x N)
//     T(w, X)  = d2(w.J X)/dY2                               (N x N)
//     F(w, V)  = d2(w.V^T d2p V)/dY2                         (N x N)
// where pdd = J A + V^T d2p V is the point's acceleration. Columns 0 and 1 of J are the base's
// translation, which none of the others depends on: D and E are zero there.
//
// S is the scalar: double for one configuration, Lanes for four at once (core/lanes.h).

#include <vector>

#include "jaculus/core/column_pattern.h"
#include "jaculus/model/planar.h"

namespace jaculus::dynamics {

/// One term of a point's position: R(phi) vector, or l R(phi) vector where `slider` is set.
struct Segment {
  int angle = 0;               ///< absolute index of phi
  int slider = -1;             ///< absolute index of l, or -1
  Vec2 vector = Vec2::Zero();  ///< in the body's frame [m], unit vector for a slider
};

/// A point of the robot as segments from the base's translation outwards.
using Path = std::vector<Segment>;

/// A loop in absolute coordinates: both paths end at the same pin.
struct LoopPaths {
  Path a, b;                ///< to the pin by either side
  Path anchor_a, anchor_b;  ///< to the joints of the two dependent bodies
  Vec2 arm_a, arm_b;        ///< pin in the frames of the dependent bodies [m]
  int body_a = 0, body_b = 0;
  double branch = 1.0;
};

/// The robot's tree unrolled into absolute coordinates. Immutable once built.
struct AbsoluteTree {
  explicit AbsoluteTree(const model::PlanarModel& model);

  int n = 0;   ///< generalised coordinates
  int N = 0;   ///< absolute coordinates
  int nd = 0;  ///< dependent joints
  Matrix P;    ///< N x n
  Matrix P_d;  ///< N x nd
  ColumnPattern P_pattern, P_d_pattern;
  /// Of what depends on the coordinates by way of the dependent joints as well: G of
  /// loop_closure.h, and X, which has rows of dependent bodies alone.
  ColumnPattern G_pattern, X_pattern;
  Vector Y_0;                   ///< N
  std::vector<double> mass;     ///< of each body [kg]
  std::vector<double> inertia;  ///< of each body about its centre of mass [kg m^2]
  std::vector<Path> com;        ///< of each body
  std::vector<Path> origin;     ///< of each body's frame
  std::vector<Path> feet;
  std::vector<LoopPaths> loops;
  Matrix armature;   ///< n x n, reflected rotor inertia [kg m^2]
  Matrix input_map;  ///< n x u: generalised force = input_map * joint torque of one motor
  /// bodies x n, joint values: theta = joint_row_q q + joint_row_d d + joint_0
  Matrix joint_row_q;
  Matrix joint_row_d;         ///< bodies x nd
  Vector joint_0;             ///< bodies
  std::vector<int> cyclic;    ///< coordinates that enter no dynamics: x and z of a free base
  double gravity = kGravity;  ///< along -z [m/s^2]
  double total_mass = 0.0;    ///< [kg]

  [[nodiscard]] static int angle_index(int body) { return 2 + body; }
  [[nodiscard]] Path path_to(const model::PlanarModel& model, int body, const Vec2& point) const;
};

/// Largest number of columns a point may depend on: base translation, then at most two a segment.
inline constexpr int kMaxColumns = 64;

/// Columns of one point's derivatives, sparse: `count` absolute indices, each with a planar vector.
template <class S>
struct PointColumnsOf {
  int count = 0;
  int index[kMaxColumns];
  S x[kMaxColumns], z[kMaxColumns];

  void clear() { count = 0; }
  void add(int i, const S& cx, const S& cz) {
    index[count] = i;
    x[count] = cx;
    z[count] = cz;
    ++count;
  }
  /// Takes over which columns there are, with zeros.
  void take_pattern(const PointColumnsOf& from);
  [[nodiscard]] Vec2Of<S> times(const VectorOf<S>& v) const;  ///< sum of columns times v
  /// out += scale * columns^T w
  void add_transposed(const Vec2Of<S>& w, double scale, VectorOf<S>& out) const;
};
using PointColumns = PointColumnsOf<double>;

/// Sines and cosines of all absolute angles at one configuration.
template <class S>
struct PoseOf {
  VectorOf<S> Y;                       ///< N absolute coordinates
  VectorOf<S> cosine;                  ///< N, at angle indices
  VectorOf<S> sine;                    ///< N
  void set(const AbsoluteTree& tree);  ///< fills cosine and sine from Y
  void set_angle(int i);               ///< fills the two of one absolute index
};
using Pose = PoseOf<double>;

/// A weight or a scale, which does not settle what S is.
template <class S>
using Vec2Arg = const std::type_identity_t<Vec2Of<S>>&;

template <class S>
Vec2Of<S> position(const Path& path, const PoseOf<S>& pose);
template <class S>
void jacobian_columns(const Path& path, const PoseOf<S>& pose, PointColumnsOf<S>& J);
/// Adds D(X) to the vectors of `out`, whose columns are in the order jacobian_columns() made.
template <class S>
void add_D(const Path& path, const PoseOf<S>& pose, const VectorOf<S>& X, double scale,
           PointColumnsOf<S>& out);
template <class S>
void add_E(const Path& path, const PoseOf<S>& pose, const VectorOf<S>& V, double scale,
           PointColumnsOf<S>& out);
/// V^T d2p V, the part of the acceleration that is quadratic in the rates.
template <class S>
Vec2Of<S> quadratic(const Path& path, const PoseOf<S>& pose, const VectorOf<S>& V);
template <class S>
void add_H(const Path& path, const PoseOf<S>& pose, Vec2Arg<S> w, MatrixOf<S>& out);
template <class S>
void add_T(const Path& path, const PoseOf<S>& pose, Vec2Arg<S> w, const VectorOf<S>& X,
           MatrixOf<S>& out);
template <class S>
void add_F(const Path& path, const PoseOf<S>& pose, Vec2Arg<S> w, const VectorOf<S>& V,
           MatrixOf<S>& out);

}  // namespace jaculus::dynamics
