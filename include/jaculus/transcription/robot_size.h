#pragma once
// A robot's size, for problems that suit any: what their numbers are multiples of, and two poses.
//
//   L   leg_length       longest of the legs, from its first joint to the foot, stretched
//   H   standing_height  of the base's origin over its lowest foot, joints as in rest_pose
//   W   body_weight      m g
//       leg_time         sqrt(L/g): the time in which a pendulum of the leg's length moves, up to a
//                        factor; L/leg_time is the speed sqrt(g L) of Froude number 1
// All of the robot as its files give it, before a problem's overrides.

#include <map>
#include <string>
#include <vector>

#include "jaculus/core/units.h"
#include "jaculus/model/robot.h"

namespace jaculus::transcription {

struct RobotSize {
  double leg_length = 0.0;       ///< [m]
  double standing_height = 0.0;  ///< [m]
  double body_weight = 0.0;      ///< [N]
  double leg_time = 0.0;         ///< [s]
  double floor_friction = 0.0;   ///< robot.yaml's friction [-]
};

/// The body whose joint begins the leg of a foot; 0 where the base itself bears the foot.
int first_of_leg(const model::PlanarModel& model, const model::PlanarPoint& foot);

/// InputError where the robot has no feet or nothing pulls it down.
RobotSize robot_size(const model::Robot& robot);

/// The same as units that numbers of a problem may be in.
std::vector<OwnUnit> robot_units(const RobotSize& size);

/// Coordinates [rad or m] that the joints of rest_pose make up. InputError where there is none.
std::map<std::string, double> rest_coordinates(const model::Robot& robot);

/// Names of the coordinates that move a foot while the base stands still, told in rest_pose.
/// InputError where the robot has no such foot.
std::vector<std::string> leg_coordinates(const model::Robot& robot, const std::string& foot);

/// The same with the legs stretched, as at the end of a leap: every foot below its first joint, at
/// one height, no leg longer than 92 % of its length (a straight one can't push). Knees bend as in
/// rest_pose; ranges hold. Found by damped Gauss-Newton steps from there; a foot that can't reach
/// its place comes as near as it can.
std::map<std::string, double> stretched_coordinates(const model::Robot& robot);

}  // namespace jaculus::transcription
