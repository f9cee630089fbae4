#pragma once
// What a proposal is made of, filled in by one step after the other.

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/model/planar.h"
#include "jaculus/model/propose.h"
#include "model/reduce.h"

namespace jaculus::model {

/// What counts as along an axis, as the reduction has it.
inline const double kAlong = std::cos(10.0 * M_PI / 180.0);

struct HeldBecause {
  HeldJoint held;
  std::string reason;
};

/// A foot, or what could be one.
struct DraftFoot {
  std::string name;
  std::string link;           ///< that a moving joint carries
  Vec2 point = Vec2::Zero();  ///< in its frame [m]
  int body = 0;               ///< of the reduction
  std::string source;         ///< what told where it is
  bool guessed = false;       ///< nothing in the file says where it is
  Surface surface;            ///< of what touches there
  /// of a capsule's cap about `point` [m]: until the pose at rest is known, in which the foot is
  /// the cap's lowest point; 0: the foot is `point` itself
  double cap = 0.0;
};

/// Two chains from one hip whose last links are pinned together.
struct DraftLoop {
  std::string name;
  DraftFoot a, b;                 ///< the pin, as points of the last bodies
  DraftFoot foot;                 ///< below it
  std::array<DraftFoot, 2> ends;  ///< of both chains: its feet where it stays open
  double branch = 1.0;            ///< as PlanarLoop has it, at rest
  std::string source;             ///< what told where the pin is
  std::string why_open;           ///< of one that is left open
};

/// Coordinates of a five-bar leg: sums of its motors' joints.
struct LegCoordinates {
  std::array<std::string, 2> joints;         ///< of the motors
  std::array<double, 2> stretch{}, swing{};  ///< by joint: extension and angle as sums of them [-]
  Bounds extension, angle;                   ///< ranges [rad]
};

struct Draft {
  SpatialTree tree;  ///< from the base link on, x forward and z up, nothing held
  std::string forward = "+x", up = "+z";  ///< axes of the file's root
  std::string base_link;                  ///< empty where it is the file's root
  bool floating = false;
  bool horizontal = false;  ///< the plane lies flat, so nothing falls in it
  std::vector<HeldBecause> held;
  std::vector<PairSpec> pairs;
  Reduction reduction;
  std::vector<DraftFoot> feet;
  std::map<std::string, double> armature;  ///< by joint of the file [kg m^2]
  std::vector<Surface> surfaces;           ///< of links of the file
  std::vector<DraftLoop> loops;
  std::vector<DraftLoop> open_loops;   ///< that may be, for a user to close
  std::map<std::string, double> rest;  ///< by planar joint [rad or m]
  bool rest_stated = false;            ///< by the user or the file, in part or whole
  std::vector<std::string> notes, missing;
};

/// Words of a name in lower case: "FR_hipJoint" is fr, hip, joint.
std::vector<std::string> words_of(const std::string& name);
/// Left and right swapped in a name, in lower case: "front_leftL" is "front_rightr".
std::string other_side(const std::string& name);

/// +1 where a name says front, -1 rear, 0 neither.
int end_of_name(const std::string& name);

/// +1 where a name says left, -1 right, 0 neither.
int side_of_name(const std::string& name);

/// Which way is forward, left and up; where the base begins; whether it floats. Places the tree.
void find_frame(const SpatialTree& file, const ProposeOptions& options, Draft& draft);

/// Holds what leaves the plane or moves nothing.
void find_held(const ProposeOptions& options, Draft& draft);

/// Pairs what lies left and right of the plane; joints that this leaves alone below a pair are
/// held. Reduces.
void find_pairs(const ProposeOptions& options, Draft& draft);

/// Feet, and names by leg for the pairs that lead to them; loops of two chains from one hip.
void find_feet(const ProposeOptions& options, Draft& draft);

/// Two chains of one leg, by their ends, pinned together; the foot is below the pin.
DraftLoop pinned(const Draft& draft, const std::string& leg, const DraftFoot& a,
                 const DraftFoot& b);

/// The same, taken as a five-bar with that foot.
void add_five_bar(Draft& draft, const std::string& leg, const DraftFoot& a, const DraftFoot& b);

/// Coordinates of a closed leg at rest, with ranges that keep it closed. Nothing where its motors
/// have ranges of their own, or where no range of the extension does for all angles.
std::optional<LegCoordinates> leg_coordinates(const Draft& draft, const DraftLoop& loop);

/// Planar place of a point of a body, the base at the origin: x, z [m].
Vec2 point_at(const Draft& draft, int body, const Vec2& point,
              const std::map<std::string, double>& joints = {});

/// A pose in which it stands on its feet, or the stated one. Loops that no pose closes move to
/// open_loops, and each of their chains gets a foot.
void find_rest(const ProposeOptions& options, Draft& draft);

/// A planar joint as the draft knows it.
struct DraftJoint {
  std::string name;          ///< planar
  std::vector<int> spatial;  ///< its joints in draft.tree, left first
  int body = 0;
};
std::vector<DraftJoint> joints_of(const Draft& draft);

/// All joints that are held, as reduce() takes them.
std::vector<HeldJoint> held_of(const Draft& draft);

/// Planar pose of a body with all joints at zero and the base at the origin: x, z [m], angle [rad].
Eigen::Vector3d pose_of(const Reduction& reduction, int body,
                        const std::map<std::string, double>& joints = {});

Dropped dropped_of(const Draft& draft);

/// robot.yaml. Adds what it has to leave open to draft.missing.
std::string write_proposal(Draft& draft, const Dropped& dropped);

}  // namespace jaculus::model
