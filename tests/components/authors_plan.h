#pragma once
// The authors' solved leaps, put into this library's robot and equations: what is left over, row by
// row.
//
// A plan gives, node by node, base and joint values (knees included), rates and accelerations
// (knees left out), torques of one motor at the joint, and foot forces (left and right summed).
// Rows of the balance M a + h - B u - J_f^T f - Q_drag are taken in the coordinates (x, z, pitch,
// one a motor's joint), where each torque acts on one row; joint rows are of one motor.
//
// Two ways. `open`: all joints are coordinates, the knees stand where the plan has them (its loops
// gape by up to 0.5 mm), and the loop forces go with the knee rows. `closed`: the library's way,
// knees from the motors by the loops.

#include <filesystem>
#include <string>
#include <vector>

#include "jaculus/components/equations.h"

namespace jaculus::test {

/// One sample of a plan. `joints` are the joints of all bodies, the base's entry zero.
struct PlanNode {
  int phase = 0;
  int index = 0;                           ///< within its phase
  double time = 0.0;                       ///< [s]
  Eigen::Vector3d base_q, base_v, base_a;  ///< x, z, pitch with rates and accelerations
  Vector joints;                           ///< [rad]
  Vector joint_v, joint_a;  ///< [rad/s], [rad/s^2], zero at the knees, for which plans have none
  Vector u;                 ///< one a motor: joint torque of one motor [N m]
  Vector duty;              ///< one a motor: voltage over 7 V
  Vector force;             ///< 2 a foot: x, z [N], zero where off the ground
  Vector foot;              ///< 2 a foot: position as the plan has it [m]
};

/// A plan and the robot that it is for, with the plan's settings and nothing locked.
struct Plan {
  std::string name;
  model::PlanarModel model;
  std::vector<PlanNode> nodes;
};

Plan read_plan(const std::filesystem::path& file, const model::PlanarModel& model);

/// The generalised coordinates of `model`, which may have joints locked, rates and accelerations at
/// a node (n each).
struct Coordinates {
  Vector q, v, a;
};
Coordinates coordinates(const model::PlanarModel& model, const PlanNode& node);

/// The same robot with its loops opened: coordinates are the base and every joint in the order of
/// the bodies.
model::PlanarModel opened(const model::PlanarModel& model);

/// What is left over at one node.
struct NodeResiduals {
  Vector open;        ///< x, z [N], pitch [N m], then one a motor: N m of one motor
  Vector closed;      ///< the same
  double gap = 0.0;   ///< largest gap of a loop at the plan's own knee angles [m]
  double knee = 0.0;  ///< largest difference of a dependent joint from the plan's [rad]
  /// largest difference of a foot's position from the plan's, at the plan's knees [m]
  double foot = 0.0;
  double foot_rate = 0.0;       ///< largest velocity of a foot in contact [m/s]
  double rate_term = 0.0;       ///< largest velocity that one coordinate gives it [m/s]
  double foot_second = 0.0;     ///< largest acceleration of a foot in contact [m/s^2]
  double second_term = 0.0;     ///< largest acceleration that one coordinate gives it [m/s^2]
  double voltage = 0.0;         ///< largest difference of a motor's voltage from its duty [V]
  double contact_force = 0.0;   ///< largest magnitude of a foot's force [N]
  double contact_moment = 0.0;  ///< largest moment of a foot's force about the base's origin [N m]
};

/// Evaluates plans of one robot; scratch and models are kept between nodes.
class PlanChecker {
 public:
  explicit PlanChecker(const model::PlanarModel& model);

  [[nodiscard]] NodeResiduals residuals(const PlanNode& node) const;
  /// Rows as in NodeResiduals::open for the model with the joint of motor `motor` locked at
  /// `value`, that motor's row left out.
  [[nodiscard]] Vector locked_rows(const PlanNode& node, int motor, double value) const;

  const model::PlanarModel model;
  const components::Equations closed, open;  ///< both with the exact law of drag, no smoothing
};

/// Left side minus right side of the balances over the nodes 0 to `last` of one phase, by Simpson's
/// rule on the plan's nodes.
struct PhaseBalance {
  Vec2 momentum = Vec2::Zero();  ///< change less impulse of feet, drag and weight [N s]
  double moment = 0.0;           ///< of momentum about the world's origin, likewise [N m s]
  double energy = 0.0;           ///< change less work of motors and drag [J]
  double impulse_scale = 0.0;    ///< of the feet, magnitudes summed [N s]
  double moment_scale = 0.0;     ///< of the feet about the base's origin, magnitudes summed [N m s]
  double work_scale = 0.0;       ///< of the motors, magnitudes summed [J]
};

PhaseBalance balance(const PlanChecker& checker, const Plan& plan, int phase, int last);

}  // namespace jaculus::test
