#pragma once
// The running robot: MuJoCo's model and data with the ids that the testbed needs, placed in a start
// pose.

#include <mujoco/mujoco.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "testbed/mjcf.h"

namespace jaculus::testbed {

struct ModelDeleter {
  void operator()(mjModel* m) const { mj_deleteModel(m); }
};
struct DataDeleter {
  void operator()(mjData* d) const { mj_deleteData(d); }
};

/// Places of one joint in qpos and qvel; -1 where there is none.
struct JointPlace {
  int qpos = -1;
  int dof = -1;
};

/// A strip of a tail that meets the air.
struct Strip {
  int body = -1;
  model::Vec3 point_B = model::Vec3::Zero();  ///< its middle [m]
  double length = 0.0;                        ///< [m]
};

struct Machine {
  std::unique_ptr<mjModel, ModelDeleter> model;
  std::unique_ptr<mjData, DataDeleter> data;
  JointPlace base_x, base_z, base_pitch;
  std::vector<JointPlace> drives;          ///< motor's side of each drive
  std::vector<std::vector<Strip>> strips;  ///< of each drag
  std::vector<int> drag_pivot;             ///< body whose origin is the tail's pivot
  std::vector<int> toes;                   ///< geoms
  int base = -1;                           ///< body

  [[nodiscard]] JointPlace joint(const std::string& name) const;
};

/// Builds the robot. What MuJoCo refuses in its own model text is a LostRobot.
Machine build_machine(const RobotFiles& files, const Changes& changes, const Setting& setting,
                      const Numerics& numerics);

/// Puts the robot into a pose at rest: `joints` by planar or spatial name, other joints at their
/// zero, knees by closing the pins (Newton). A floating base goes to x, pitch, and to `z`; NaN puts
/// its lowest toe on the floor. With `level` the pitch is turned until the lowest toes of both ends
/// touch. UnreachablePose where the pins can't be
/// closed.
struct StartPose {
  std::map<std::string, double> joints;
  double x = 0.0, z = kNaN, pitch = 0.0;
  bool level = false;
};
void place(Machine& machine, const RobotFiles& files, const StartPose& pose);

/// Lets springs and play of the build come to rest under gravity with all motors held: bends of the
/// shaft, the flank of a gear on which the tail lies, a sliding load, floor plates under the
/// robot's weight (the base sinks with them).
void settle(Machine& machine);

}  // namespace jaculus::testbed
