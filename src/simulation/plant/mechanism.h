#pragma once
// Kinematics, mass matrix and bias of a planar robot for forward simulation: the physics of
// dynamics/rigid_body.h without derivatives, in a form made for speed (fixed storage, no
// allocation, no trigonometry beyond one sine and cosine a joint).
//
// Body by body from the base, with the absolute angle phi, e(r) = R(phi) r, e' = dR/dphi r = (e_z,
// -e_x) and rows over the n coordinates w = dphi/dq, J = dp/dq of the body's frame:
//     revolute    w_b = w_p + sign theta_q,  J_b = J_p + e'_p(origin) w_p
//     prismatic   w_b = w_p,                 J_b = J_p + e'_p(origin + axis l) w_p + R axis theta_q
//     loop        the pin is the intersection of two circles about the roots of its two links a and
//                 b (closed form, on the stated branch); with their arms r:
//                 [e'(r_a) -e'(r_b)] (w_a, w_b) = J_b - J_a,  the same for accelerations.
// The accelerations at zero generalised acceleration ("bias") follow from the same recursion with
// -e(r) omega^2. Then
//     M = sum m J_c^T J_c + I w^T w + armature,    h = sum m J_c^T (a_c - g) + I w^T alpha.
// tests/simulation holds these against dynamics/rigid_body.h.
//
// Hinges of compliant transmissions are further coordinates behind those of the model: hinge k
// turns its link beyond its motor.

#include <array>
#include <vector>

#include "jaculus/simulation/plant.h"

namespace jaculus::simulation::detail {

/// Most coordinates that a plant may have, hinges included.
inline constexpr int kMaxSize = 24;
using Row = std::array<double, kMaxSize>;

/// Of the first n values of each, in their order.
inline double dot(const Row& a, const double* b, int n) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

/// Indices of coordinates, rising.
struct Columns {
  std::size_t count = 0;
  std::array<std::size_t, kMaxSize> index{};
  [[nodiscard]] const std::size_t* begin() const { return index.data(); }
  [[nodiscard]] const std::size_t* end() const { return index.data() + count; }
};

/// Of these values of each: of a row's that are not zero.
inline double dot(const Row& a, const Columns& columns, const double* b) {
  double sum = 0.0;
  for (const std::size_t i : columns) sum += a[i] * b[i];
  return sum;
}

/// A body's frame at one state.
struct Frame {
  double c = 1.0, s = 0.0;    ///< cosine and sine of the absolute angle
  double px = 0.0, pz = 0.0;  ///< origin [m]
  double vx = 0.0, vz = 0.0;  ///< its velocity [m/s]
  double ax = 0.0, az = 0.0;  ///< its acceleration at zero generalised acceleration [m/s^2]
  double omega = 0.0;         ///< [rad/s]
  double alpha = 0.0;         ///< angular acceleration at zero generalised acceleration [rad/s^2]
  Columns columns;            ///< coordinates that move it, the base's x and z aside
  Row w{}, jx{}, jz{};        ///< d(angle)/dq, d(origin)/dq
};

/// A point fixed to a body at one state.
struct PointState {
  double px, pz, vx, vz, ax, az;
  Row jx, jz;
};

/// A joint's value, rate and gradient.
struct JointState {
  double value, rate, bias;
  Row row;
};

/// A hinge behind a motor.
struct Hinge {
  int motor = -1;          ///< index in model.motors
  int body = -1;           ///< the link
  int coordinate = -1;     ///< its index, n_model + k
  double half_play = 0.0;  ///< of its dead band [rad]
};

class Mechanism {
 public:
  explicit Mechanism(const Plant& plant);

  int n = 0;        ///< coordinates, hinges included
  int n_model = 0;  ///< coordinates of the model
  std::vector<Hinge> hinges;
  std::vector<Row> motor_row;          ///< d(joint angle on the motor's side)/dq, a motor
  std::vector<Columns> motor_columns;  ///< those of them that are not zero

  /// Sets frames at q, v (n each). False where a loop can't close.
  bool set(const double* q, const double* v);
  /// The mass matrix, column by column with stride kMaxSize, lower triangle; and the bias force h.
  void assemble(double* mass, double* bias) const;

  [[nodiscard]] const Frame& frame(int body) const { return frames_[body]; }
  void point(int body, const Vec2& position, PointState& out) const;
  /// A joint that is no base joint; `q` as given to set(). A dependent joint's value is within
  /// (-pi, pi].
  void joint(int body, const double* q, const double* v, JointState& out) const;
  /// Joint angle on the motor's side and its rate.
  [[nodiscard]] double motor_angle(int motor, const double* q) const;
  [[nodiscard]] double motor_rate(int motor, const double* v) const;
  [[nodiscard]] double weight() const { return total_mass_ * gravity_; }  ///< [N]

 private:
  struct Step {
    bool loop;
    int index;
  };
  struct Body {
    int parent;
    bool prismatic, dependent;
    Vec2 origin, axis, com;
    double offset, cos_offset, sin_offset, sign, mass, inertia, joint_offset;
    Row map{};
    Columns columns{};  ///< of the map, those that are not zero
  };
  /// Inertia that turns with a motor's side of a hinge, taken from the link where the model has no
  /// rotor of its own.
  struct Spin {
    int body;
    double inertia;
    Row row{};
  };

  void add_transmissions(const Plant& plant);
  void add_step_order(const model::PlanarModel& model);
  void find_columns();
  void add_spins(double* mass, double* bias) const;
  void set_base(const double* q, const double* v);
  void set_joint(int b, const double* q, const double* v);
  bool close_loop(const model::PlanarLoop& loop);
  void place(const Frame& parent, const Vec2& r, Frame& out) const;

  std::vector<Body> bodies_;
  std::vector<Frame> frames_;
  std::vector<Step> order_;
  std::vector<model::PlanarLoop> loops_;
  std::vector<Spin> spins_;
  std::vector<double> motor_offset_, armature_;
  std::array<int, 3> base_{-1, -1, -1};
  Eigen::Vector3d base_pose_;
  double gravity_ = 0.0, gravity_x_ = 0.0, gravity_z_ = 0.0;  ///< size, and along -x and -z
  double total_mass_ = 0.0;
};

}  // namespace jaculus::simulation::detail
