#include <fmt/format.h>

#include "jaculus/model/robot.h"
#include "model/attach.h"
#include "model/fields.h"

namespace jaculus::model {
namespace {

const char* const kText = R"(robot.yaml: what robot.urdf can't say about a robot
Plain numbers are SI (rad); "16 V", "15 deg" carry their unit. Unknown keys are errors. The
sagittal plane is x-z, points are [x, z] in their link's frame, angles turn about +y.

  format          jaculus-robot/1
  urdf            file of the bodies and joints, in the same folder; robot.urdf where absent
  axes            how the file's root lies, where x isn't forward and z up:
    forward, up     one of +x, -x, +y, -y, +z, -z of the file's root
  base_link       the link that is the base, where the URDF's root isn't; what is above it is
                  left out
  base            floating (x, z and pitch are coordinates), fixed, or a map:
    free          list of those of x, z, pitch that are coordinates; the others are held
    pose          x [m], z [m], pitch [rad] where held; 0 where absent
  gravity         [m/s^2] along -z; 9.81 where absent
  friction        Coulomb coefficient of feet on the floor [-]; needed where there are feet
  pairs           left and right parts that move alike, lumped into one planar part (masses and
                  inertias added)
    joints        planar name: [left joint, right joint]; joints below a pair must be in pairs too
    links         planar name: [left link, right link]; the left one's name where absent
  fixed_joints    joint: value [rad or m]; held there, its link is merged into its parent
  loops           name: a loop closure, a pin that joins two links
    link_a, link_b     the links that the pin joins
    point_a, point_b   where the pin is on each [m]
    dependent          [joint_a, joint_b]: the joints at the roots of link_a and link_b; they follow
                       from the others
    branch             positive or negative: sign of u_z v_x - u_x v_z, u from joint_a to joint_b,
                       v from joint_a to the pin; where absent, that of the URDF's zero
  coordinates     name: a combination of independent joints; joints in none stand for themselves
    of            joint: coefficient [-]; as many coordinates as joints that they share,
                  independent of one another
    range         [lower, upper] [rad or m]; none where absent
  ranges          joint or base coordinate: [lower, upper] [rad or m], in place of the URDF's limits
  rest_pose       joint with a motor: where it is while the robot is carried or stands on a bench
                  [rad or m]; 0 where absent
  feet            name: a point that may touch the floor
    link, point   the link and the position on it [m]
  points          name: any other point, keys as in feet
)";

const char* const kMotors = R"(  motors          joint: one motor of its pair
    kind               electric, envelope (a torque-speed curve, of which k_t, R and saturation
                       follow) or ideal (a torque, a force where the joint slides; takes
                       torque_limit, speed_limit, frictions and, where it turns, rotor_inertia)
    knee_speed         of envelope: up to it there is torque_limit, before the gear [rad/s]
    no_load_speed      of envelope: from the knee torque falls in a line to none here, at
                       `voltage`, before the gear [rad/s]
)";

const char* const kDrag =
    R"(  drag            name: aerodynamic drag of a tail, overridden by the path name.drag.key
    link               the link that carries it; its joint is the pivot
    direction          [x, z] along the tail, in the link's frame; any length
)";

const char* const kAttach =
    R"(  attach          name: what is put on the robot: a tail, its link, joint, motor and drag of
                  this name, overridden by the path attach.name.key
)";

const char* const kTolerances =
    R"(  tolerances      what a careful builder can't know: standard deviations; nothing is off by
                  more than two of them
)";

template <class S>
std::string section(const std::string& head, const std::vector<Key<S>>& keys) {
  std::string text = head;
  for (const Key<S>& key : keys) {
    const bool word = std::holds_alternative<DragKind S::*>(key.member);
    const std::string unit = word ? "" : fmt::format(" [{}]", unit_name(key.dimension));
    text += fmt::format("    {:<18} {}{}\n", key.name, key.meaning, unit);
  }
  return text;
}

std::string attach_section() {
  std::string text = kAttach;
  for (const AttachKey& key : attach_keys())
    text += fmt::format("    {:<18} {}\n", key.name, key.meaning);
  return text;
}

std::string tolerance_section() {
  std::string text = kTolerances;
  for (const ToleranceKey& key : tolerance_keys()) {
    text += fmt::format("    {:<18} {} [{}]; {:.4g} where absent\n", key.name, key.meaning,
                        unit_name(key.dimension), Tolerances{}.*key.member);
  }
  return text;
}

}  // namespace

std::string explain_robot() {
  return kText + section(kMotors, motor_keys()) + section(kDrag, drag_keys()) + attach_section() +
         tolerance_section();
}

}  // namespace jaculus::model
