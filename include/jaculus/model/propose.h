#pragma once
// robot.yaml proposed for a robot file that was not made for this program: which plane it moves in,
// what is held, which joints are left and right of one planar joint, where its feet are, what its
// motors give. Everything follows from geometry and names; what the file can't tell is a commented
// line of the proposal and is listed.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/model/mjcf.h"

namespace jaculus::model {

struct ProposeOptions {
  std::map<std::string, double> pose;  ///< of joints that are held, or at rest [rad or m]
  /// the same as the file has it: counts for joints that `pose` leaves out, of legs only where they
  /// stand in it
  std::map<std::string, double> file_pose;
  /// joints that are held though the plane has a place for them, by the file's names
  std::vector<std::string> hold;
  /// so are all without a motor, where others have one: springs, as of spines and tails, are no
  /// part of the nominal robot
  bool hold_passive = false;
  /// "+x" ... "-z" of the file; told by joints and names where empty. Both or none
  std::string forward, up;
  std::map<std::string, double> armature;  ///< inertia that a joint adds to its own [kg m^2]
  std::vector<Surface> surfaces;           ///< what told the friction of the tree's shapes
  std::optional<bool> floating;            ///< base; told by the tree where absent
  bool pairs = true;                       ///< left and right are one planar joint
  /// two chains of two alike links from one hip are a five-bar, pinned where both end
  bool loops = true;
};

/// What the reduction to the plane leaves out, at the pose of the proposal.
struct Dropped {
  double mass = 0.0;            ///< of the whole robot, all of it kept [kg]
  double pitch_inertia = 0.0;   ///< about its centre of mass, kept [kg m^2]
  double mass_off_plane = 0.0;  ///< of links whose centre of mass lies over 1 cm off the plane [kg]
  double com_off_plane = 0.0;   ///< of the whole robot, to the left [m]
  /// sum of m y^2: what moving these links into the plane takes from roll and yaw [kg m^2]
  double inertia_moved = 0.0;
  /// products of inertia of pitch with roll and yaw, against the pitch inertia [-]
  double coupling = 0.0;

  /// com_off_plane in words, "0.06 mm to the right".
  [[nodiscard]] std::string com_sideways() const;
};

struct Proposal {
  std::string yaml;  ///< robot.yaml
  bool floating = false;
  bool planar = true;                ///< something of it moves in the plane
  std::vector<std::string> notes;    ///< what was decided, and by what
  std::vector<std::string> held;     ///< joints of the file that are held
  std::vector<std::string> missing;  ///< what the file doesn't say, with the lines to fill in
  Dropped dropped;
  std::map<std::string, double> rest;  ///< by planar joint: the pose at rest [rad or m]
};

/// Gives links whose inertia is that of their mass at a distance beyond the whole robot's size,
/// place holders of first drafts, that of their largest shape, evenly filled, or of a sphere of
/// water where they have none. The links' names.
std::vector<std::string> take_inertias_of_shapes(SpatialTree& tree);

/// `tree` as read_urdf gives it.
Proposal propose_robot(const SpatialTree& tree, const ProposeOptions& options = {});

}  // namespace jaculus::model
