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
// where pdd = J A + V^T d2p V is the point's acceleration.

#include <vector>

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

  int n = 0;                    ///< generalised coordinates
  int N = 0;                    ///< absolute coordinates
  int nd = 0;                   ///< dependent joints
  Matrix P;                     ///< N x n
  Matrix P_d;                   ///< N x nd
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
struct PointColumns {
  int count = 0;
  int index[kMaxColumns];
  double x[kMaxColumns], z[kMaxColumns];

  void clear() { count = 0; }
  void add(int i, double cx, double cz) {
    index[count] = i;
    x[count] = cx;
    z[count] = cz;
    ++count;
  }
  [[nodiscard]] Vec2 times(const Vector& v) const;  ///< sum of columns times v
  /// out += scale * columns^T w
  void add_transposed(const Vec2& w, double scale, Vector& out) const;
};

/// Sines and cosines of all absolute angles at one configuration.
struct Pose {
  Vector Y;                            ///< N absolute coordinates
  Vector cosine;                       ///< N, at angle indices
  Vector sine;                         ///< N
  void set(const AbsoluteTree& tree);  ///< fills cosine and sine from Y
  /// The same where `moved` (N) isn't zero.
  void set_moved(const ConstVectorRef& moved);
};

Vec2 position(const Path& path, const Pose& pose);
void jacobian_columns(const Path& path, const Pose& pose, PointColumns& J);
/// Adds D(X) to the vectors of `out`, whose columns are in the order jacobian_columns() made.
void add_D(const Path& path, const Pose& pose, const Vector& X, double scale, PointColumns& out);
void add_E(const Path& path, const Pose& pose, const Vector& V, double scale, PointColumns& out);
/// V^T d2p V, the part of the acceleration that is quadratic in the rates.
Vec2 quadratic(const Path& path, const Pose& pose, const Vector& V);
void add_H(const Path& path, const Pose& pose, const Vec2& w, Matrix& out);
void add_T(const Path& path, const Pose& pose, const Vec2& w, const Vector& X, Matrix& out);
void add_F(const Path& path, const Pose& pose, const Vec2& w, const Vector& V, Matrix& out);

}  // namespace jaculus::dynamics
