#pragma once
// The sections of robot.yaml, each read and checked against the bodies that the URDF gave. Keys:
// explain_robot().

#include <map>
#include <set>
#include <string>
#include <vector>

#include "jaculus/core/yaml.h"
#include "jaculus/model/planar.h"
#include "model/reduce.h"

namespace jaculus::model {

struct OverrideInput;

/// Joints and links of what `attach` has with kind none: they aren't there, and what robot.yaml
/// says of them (pairs, fixed_joints, ranges, rest_pose, feet, points, motors, drag) is skipped.
using Absent = std::set<std::string>;

/// axes: {forward: +z, up: +y}, base_link: link; the tree with its root's axes turned to x forward
/// and z up, and without what is above the base link, which is noted.
SpatialTree read_placement(const yaml::Node& robot, const SpatialTree& tree,
                           std::vector<std::string>& notes);

/// base: floating | fixed | {free: [...], pose: {...}}
void read_base(const yaml::Node& robot, PlanarModel& model);

/// pairs: {joints: {name: [left, right]}, links: {...}}; an absent pair's name is absent too
std::vector<PairSpec> read_pairs(const yaml::Node& robot, const std::string& kind,
                                 const SpatialTree& tree, Absent& absent);

/// fixed_joints: {joint: value}
std::vector<HeldJoint> read_held(const yaml::Node& robot, const SpatialTree& tree,
                                 const std::vector<PairSpec>& pairs, const Absent& absent);

/// loops: {name: {...}}; fills model.loops and model.dependent.
void read_loops(const yaml::Node& robot, const Reduction& reduction, PlanarModel& model);

/// coordinates and ranges; fills model.coordinates, joint_map, joint_offset and joint_ranges.
void read_coordinates(const yaml::Node& robot, const Reduction& reduction, const Absent& absent,
                      PlanarModel& model);

/// feet, points: {name: {link, point}}
std::vector<PlanarPoint> read_points(const yaml::Node& robot, const std::string& key,
                                     const Reduction& reduction, const PlanarModel& model,
                                     const Absent& absent);

/// motors: {joint: {...}}
void read_motors(const yaml::Node& robot, const Absent& absent, PlanarModel& model);
/// One of them, at a joint of the model.
PlanarMotor read_motor(const std::string& joint, const yaml::Node& node, const PlanarModel& model);
/// As such a node, in one line.
std::string motor_text(PlanarMotor motor, const PlanarModel& model);
/// Motors of the model that an override describes anew, as {motors.hip: {kind: ideal}}.
void replace_motors(const std::vector<OverrideInput>& overrides, PlanarModel& model);
/// InputError for such an override of a motor that the robot hasn't.
void check_replaced(const std::vector<OverrideInput>& overrides, const Absent& absent,
                    const PlanarModel& model);

/// rest_pose: {joint: value}, of joints with a motor, where they are while the robot is carried
/// [rad or m]
std::map<std::string, double> read_rest_pose(const yaml::Node& robot, const PlanarModel& model,
                                             const Absent& absent);

/// drag: {name: {link, direction, kind, ...}}
void read_drags(const yaml::Node& robot, const Reduction& reduction, const Absent& absent,
                PlanarModel& model);

/// What only the whole model shows, after overrides: drag that needs a key which is not there, a
/// strip that ends before it starts. Told at an override where one changed that drag.
void check_drags(const yaml::Node& robot, const std::vector<OverrideInput>& overrides,
                 const PlanarModel& model);

/// Body of a joint named in `node`, or InputError with the nearest name.
int joint_body(const yaml::Node& node, const std::string& joint, const PlanarModel& model);

/// Place of a link named in `node`; its x-z plane is the sagittal plane, or InputError.
const LinkPlace& link_place(const yaml::Node& node, const std::string& link,
                            const Reduction& reduction);

/// "given 'x', did you mean 'y'?; allowed: a, b, c" as an error at `node`.
InputError unknown_name(const yaml::Node& node, const std::string& what, const std::string& given,
                        const std::vector<std::string>& known);

}  // namespace jaculus::model
