#pragma once
// Which messages of a ROS 2 bag become which channels, in YAML. Bags are read by the Python
// package; this is what its map may say.
//
//   format: jaculus-bag/1
//   topics:                               # those that are taken; others are left out, with a note
//     /joint_states:                      # of a known type: nothing need be said
//       stream: joints
//       joints: {shoulder_motor: front_a} # joint's name in the bag: in the robot
//     /mocap/pose:
//       forward: +y                       # axis of its frame; auto: told by the motion
//       rest: 0.5 s                       # at the beginning, zero of x and the angles
//     /lowstate:                          # of any type: fields by their path
//       stamp: log                        # header or log; header where it is set, unless given
//       rate_hz: 500                      # as stated
//       channels:
//         front_a: {fields: ["motor_state[0].q", "motor_state[3].q"], unit: rad, scale: -1}
//         front_a_torque: {field: "motor_state[0].tau_est", unit: N m}
//         # SI of scale * mean + offset; [NAME] stands for its place in the message's `name`

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/yaml.h"
#include "jaculus/trajectory/column_map.h"
#include "jaculus/trajectory/optitrack.h"

namespace jaculus::trajectory {

/// Whose time a message has: its header's or the recorder's.
enum class BagStamp { header, log };

/// "header", "log".
const NameTable<BagStamp>& bag_stamps();

/// What a map says of one topic. Nothing said: empty.
struct BagTopic {
  std::string topic;
  std::string stream;
  double rate_hz = kNaN;  ///< as stated [Hz]
  std::optional<BagStamp> stamp;
  std::map<std::string, std::string> joints;  ///< bag's name to robot's
  std::optional<MocapForward> forward;        ///< of poses, in their frame
  std::optional<double> rest;                 ///< of poses, at the beginning [s]
  std::vector<MappedChannel> channels;        ///< `columns` are paths of fields
};

/// Checks a map. Faults: InputError with the node's place.
std::vector<BagTopic> read_bag_map(const yaml::Node& description);

}  // namespace jaculus::trajectory
