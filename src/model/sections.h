#pragma once
// The sections of robot.yaml, each read and checked against the bodies that the URDF gave. Keys:
// explain_robot().

#include <map>
#include <string>
#include <vector>

#include "jaculus/core/yaml.h"
#include "jaculus/model/planar.h"
#include "model/reduce.h"

namespace jaculus::model {

/// axes: {forward: +z, up: +y}, base_link: link; the tree with its root's axes turned to x forward
/// and z up, and without what is above the base link, which is noted.
SpatialTree read_placement(const yaml::Node& robot, const SpatialTree& tree,
                           std::vector<std::string>& notes);

/// axes alone: file axes to the robot's, rows forward, left and up in the file's frame.
Mat3 read_axes(const yaml::Node& robot);

/// base: floating | fixed | {free: [...], pose: {...}}
void read_base(const yaml::Node& robot, PlanarModel& model);

/// pairs: {joints: {name: [left, right]}, links: {...}}
std::vector<PairSpec> read_pairs(const yaml::Node& robot, const std::string& kind,
                                 const SpatialTree& tree);

/// fixed_joints: {joint: value}
std::vector<HeldJoint> read_held(const yaml::Node& robot, const SpatialTree& tree,
                                 const std::vector<PairSpec>& pairs);

/// loops: {name: {...}}; fills model.loops and model.dependent.
void read_loops(const yaml::Node& robot, const Reduction& reduction, PlanarModel& model);

/// coordinates and ranges; fills model.coordinates, joint_map, joint_offset and joint_ranges.
void read_coordinates(const yaml::Node& robot, const Reduction& reduction, PlanarModel& model);

/// feet, points: {name: {link, point}}
std::vector<PlanarPoint> read_points(const yaml::Node& robot, const std::string& key,
                                     const Reduction& reduction, const PlanarModel& model);

/// motors: {joint: {...}}
void read_motors(const yaml::Node& robot, PlanarModel& model);
/// One of them, at a joint of the model.
PlanarMotor read_motor(const std::string& joint, const yaml::Node& node, const PlanarModel& model);

/// rest_pose: {joint: value}, of joints with a motor, where they are while the robot is carried
/// [rad or m]
std::map<std::string, double> read_rest_pose(const yaml::Node& robot, const PlanarModel& model);

/// drag: {name: {link, direction, kind, ...}}
void read_drags(const yaml::Node& robot, const Reduction& reduction, PlanarModel& model);

/// What only the whole model shows, after overrides: drag that needs a key which is not there, a
/// strip that ends before it starts.
void check_drags(const yaml::Node& robot, const PlanarModel& model);

/// Body of a joint named in `node`, or InputError with the nearest name.
int joint_body(const yaml::Node& node, const std::string& joint, const PlanarModel& model);

/// Place of a link named in `node`; its x-z plane is the sagittal plane, or InputError.
const LinkPlace& link_place(const yaml::Node& node, const std::string& link,
                            const Reduction& reduction);

/// "given 'x', did you mean 'y'?; allowed: a, b, c" as an error at `node`.
InputError unknown_name(const yaml::Node& node, const std::string& what, const std::string& given,
                        const std::vector<std::string>& known);

}  // namespace jaculus::model
