#pragma once
// The sagittal-plane model: a tree of bodies on revolute or prismatic joints, closed by loops, on a
// floating, sliding or fixed base. Left and right parts that move alike are lumped (masses and
// inertias added).
//
// Absolute angle of body b with parent p:        phi_b = phi_p + offset_b + sign_b * theta_b
//                                                (prismatic: phi_b = phi_p + offset_b)
// Position of its frame:                         p_b = p_p + R(phi_p) (origin_b + axis_b * theta_b)
//                                                (axis_b = 0 if revolute)
// Joint values from generalised coordinates:     theta = joint_map * q + joint_offset,
//                                                dependent joints aside.
// Dependent joints follow from the loops: point_a on body_a coincides with point_b on body_b.

#include <array>
#include <string>
#include <vector>

#include "jaculus/core/types.h"

namespace jaculus::model {

enum class JointKind { revolute, prismatic };

/// A joint in space that a planar joint stands for: of the robot's file, or of what robot.yaml
/// attaches.
struct FileJoint {
  std::string name;
  double sign = 1.0;      ///< its value is `sign` times the planar joint's [-]
  bool attached = false;  ///< by robot.yaml; the file doesn't have it
};

/// A joint of the robot's file that stands still in the plane.
struct HeldJoint {
  std::string joint;
  double value = 0.0;   ///< [rad or m]
  bool slides = false;  ///< along a line
};

/// One planar body and the joint that carries it. Body 0 is the base; its joint fields are unused.
struct PlanarBody {
  std::string name;   ///< link name; where lumped, that of its pair or else of the left one
  std::string joint;  ///< joint name; where lumped, that of its pair
  int parent = -1;    ///< index of the parent body, always smaller than its own
  JointKind kind = JointKind::revolute;
  Vec2 origin = Vec2::Zero();  ///< joint position in the parent's frame [m]
  double angle_offset = 0.0;   ///< angle to the parent at joint zero [rad]
  double sign = 1.0;           ///< +1 where the joint's axis is +y, -1 where it is -y
  Vec2 axis = Vec2::Zero();    ///< prismatic: unit direction in the parent's frame
  double mass = 0.0;           ///< sum over the lumped parts [kg]
  Vec2 com = Vec2::Zero();     ///< centre of mass in the body frame [m]
  /// pitch inertia about the centre of mass, sum over the lumped parts [kg m^2]
  double inertia = 0.0;
  /// How far the file's mass lies from its centre, root mean square along x and z of the body frame
  /// [m]; a size: what moves or scales masses leaves it. Zero in models that no file made.
  Vec2 spread = Vec2::Zero();
  int count = 1;  ///< how many spatial bodies it stands for
  /// joints of the file that `joint` stands for, the left one first; empty where the file has none
  std::vector<FileJoint> file_joints = {};
};

/// A point fixed to a body: foot, tail tip, clearance point.
struct PlanarPoint {
  std::string name;
  int body = 0;                  ///< index of the body
  Vec2 position = Vec2::Zero();  ///< in the body frame [m]
  int count = 1;                 ///< how many spatial points it stands for (left and right foot: 2)
};

/// A loop closure: two points that coincide, and the two joints whose values follow from it.
struct PlanarLoop {
  std::string name;
  int body_a = 0;               ///< carries the first dependent joint at its root
  Vec2 point_a = Vec2::Zero();  ///< [m]
  int body_b = 0;               ///< carries the second dependent joint at its root
  Vec2 point_b = Vec2::Zero();  ///< [m]
  /// The branch: sign of cross(anchor_b - anchor_a, pin - anchor_a), cross(u, v) = u_z v_x - u_x
  /// v_z, where anchor_a and anchor_b are the origins of body_a and body_b; taken from the
  /// configuration of the URDF's zero or stated in robot.yaml.
  double branch = 1.0;
};

/// One generalised coordinate.
struct Coordinate {
  /// "x", "z", "pitch", a joint's name, or a name from robot.yaml's `coordinates`
  std::string name;
  bool angular = true;  ///< rad where true, m otherwise
  Bounds range;         ///< the joint's range as the robot has it [rad or m]
};

/// A motor at a joint; one of `count` alike. An ideal one is a torque (or force) without electrical
/// data: torque_constant, resistance and saturation are 0, its voltage is infinite.
struct PlanarMotor {
  std::string joint;               ///< the joint it turns, also its name in every table
  int body = 0;                    ///< body that the joint carries
  int count = 1;                   ///< left and right: 2
  double torque_constant = 0.0;    ///< k_t, before the gear [N m/A], equally V s/rad
  double resistance = 0.0;         ///< winding R [ohm]
  double saturation_linear = 0.0;  ///< i = linear * tau + cubic * tau^3, before the gear [A/(N m)]
  double saturation_cubic = 0.0;   ///< [A/(N m)^3]
  double voltage = 0.0;            ///< of the bus, as the robot has it [V]
  double current_limit = kInfinity;  ///< of the driver [A]
  double torque_limit = kInfinity;   ///< before the gear [N m]
  double gear = 1.0;                 ///< G, motor turns a joint turn [-]
  double efficiency = 1.0;           ///< motor torque = joint torque / (G * efficiency) [-]
  /// adds G^2 times it at the joint; zero where the link's inertia holds it [kg m^2]
  double rotor_inertia = 0.0;
  double speed_limit = kInfinity;  ///< plans keep below, before the gear [rad/s]
  double viscous_friction = 0.0;   ///< of motor, gear and bearing at the joint [N m s/rad]
  double dry_friction = 0.0;       ///< the same, whatever the speed [N m]

  [[nodiscard]] bool ideal() const { return resistance == 0.0; }
};

enum class DragKind { none, distributed, point, rotation };

/// Aerodynamic drag of a tail: a strip from `start` to `end` along `direction` of its body
/// (equations 1, 2 and 8 of Norby et al. 2021).
struct PlanarDrag {
  std::string name;                 ///< path prefix in overrides: "tail" in tail.drag.coefficient
  int body = 0;                     ///< body that carries it; its frame's origin is the pivot
  Vec2 direction = Vec2(0.0, 1.0);  ///< unit vector along the tail in the body frame
  DragKind kind = DragKind::distributed;
  double density = 1.225;       ///< of air [kg/m^3]
  double coefficient = 0.0;     ///< C_D [-]
  double width = 0.0;           ///< w [m]
  double start = 0.0;           ///< L0, shaft without drag [m]
  double end = 0.0;             ///< L [m]
  double point_distance = 0.0;  ///< of a point force from the pivot [m]
  double point_area = 0.0;      ///< of a point force [m^2]
  Vec2 wind_W = Vec2::Zero();   ///< velocity of the air [m/s]
};

/// Linear range on one joint that is no coordinate of its own.
struct JointRange {
  std::string joint;
  int body = 0;
  Bounds range;  ///< [rad or m]
};

/// The planar robot. A value; build it with read_robot (robot.h), change it with lock().
struct PlanarModel {
  /// whether x, z, pitch of the base are coordinates
  std::array<bool, 3> base_free{true, true, true};
  /// x, z [m], pitch [rad] of the base where not free
  Eigen::Vector3d base_pose = Eigen::Vector3d::Zero();
  std::vector<PlanarBody> bodies;
  std::vector<PlanarLoop> loops;
  /// bodies whose joint follows from a loop: body_a, body_b of each loop in order
  std::vector<int> dependent;
  std::vector<PlanarPoint> feet;
  std::vector<PlanarPoint> points;  ///< other named points
  std::vector<Coordinate>
      /// n generalised coordinates: free ones of x, z, pitch, then the independent ones
      coordinates;
  /// bodies x n: theta = joint_map q + joint_offset; zero rows for base and dependent joints
  Matrix joint_map;
  Vector joint_offset;  ///< bodies [rad or m]
  std::vector<PlanarMotor> motors;
  std::vector<PlanarDrag> drags;
  std::vector<JointRange> joint_ranges;
  /// joints of the file that stand still: held by robot.yaml, or locked
  std::vector<HeldJoint> held;
  double gravity = kGravity;  ///< along -z [m/s^2]
  double friction = 0.0;      ///< Coulomb coefficient of feet on floor as the robot has it [-]

  [[nodiscard]] int size() const { return count_of(coordinates); }
  [[nodiscard]] int coordinate_index(const std::string& name) const;  ///< -1 where there is none
  [[nodiscard]] int body_of_joint(const std::string& joint) const;    ///< -1 where there is none
  [[nodiscard]] int foot_index(const std::string& name) const;        ///< -1 where there is none
  [[nodiscard]] int motor_index(const std::string& joint) const;      ///< -1 where there is none
  [[nodiscard]] bool slides(const PlanarMotor& motor) const;          ///< its joint; else it turns
  [[nodiscard]] double total_mass() const;                            ///< [kg]
};

/// The same robot with one coordinate held at `value` [rad or m]: it leaves the coordinates, its
/// motor leaves the motors.
PlanarModel lock(const PlanarModel& model, const std::string& coordinate, double value);

}  // namespace jaculus::model
