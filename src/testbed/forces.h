#pragma once
// Forces on the robot that MuJoCo does not make itself: motors, air, and disturbances. MuJoCo calls
// them at every stage of a step through its control callback.

#include <vector>

#include "testbed/drives.h"
#include "testbed/joint_laws.h"
#include "testbed/machine.h"

namespace jaculus::testbed {

/// Drives that a disturbance strikes: indices, -1 where the robot has none.
struct FailingDrives {
  int derated = -1;   ///< left one of the last front joint (a rear one, where no leg is in front)
  int deaf = -1;      ///< right one of the last rear joint
  int slipping = -1;  ///< right one of the first rear joint
};
FailingDrives failing_drives(const RobotFiles& files);

struct Forces {
  const RobotFiles* files = nullptr;
  const Changes* changes = nullptr;
  Machine* machine = nullptr;
  Drives* drives = nullptr;
  std::vector<double> commands;    ///< what the motors hear
  std::vector<DriveState> states;  ///< as of the last call
  double bus = kNaN;               ///< [V]
  std::vector<double> rates;       ///< scratch
  double start_x = 0.0;            ///< of the base [m]
  FailingDrives failing;
  std::vector<JointSize> sizes;     ///< of each drive
  std::vector<JointMemory> memory;  ///< of each drive's joint

  /// Takes the pose in which the robot starts.
  void begin(const mjData& d);
  /// Sets qfrc_applied and xfrc_applied for the state in `d`.
  void apply(mjData& d);
  /// Renews friction levels and what joints remember for the coming step.
  void renew_friction();
};

/// Makes `forces` those of every MuJoCo call of this thread, as long as the guard lives.
class ForcesGuard {
 public:
  explicit ForcesGuard(Forces& forces);
  ~ForcesGuard();
  ForcesGuard(const ForcesGuard&) = delete;
  ForcesGuard& operator=(const ForcesGuard&) = delete;
};

/// Drag on one tail, added to xfrc_applied of the bodies that carry its strips: midpoint rule over
/// strips of equal length, each with -1/2 rho C_D w u|u| along the tail's normal, u its own speed
/// through the air (Norby et al. 2021, equations 1 and 8).
void add_drag(const Machine& machine, std::size_t index, const model::PlanarDrag& drag,
              const Changes& changes, mjData& d);

/// What is outside any catalogue; may change `states`' torques as well.
void add_disturbances(const Forces& forces, mjData& d);
/// Torque of drive `i` as it arrives, [N m].
double disturbed_torque(const Forces& forces, int i, double torque, const mjData& d);
/// A push at a time [N m or N].
double push_at(const Push& push, double time);

}  // namespace jaculus::testbed
