#pragma once
// What robot.yaml puts on a robot whose file doesn't have it: a tail, or a second URDF's links.
//
// A tail is a straight rod in two parts, a shaft of length s that feels no air and a scoop of
// length p at its end, L = s + p. Its joint turns about +y at the pivot; at zero it points straight
// up.
// With masses m_s and m_p spread evenly over the two (m_p = m p/L unless `scoop_mass` says
// otherwise), m = m_s + m_p:
//   com      c = (m_s s/2 + m_p (s + p/2)) / m                                  from the pivot
//   inertia  I = m_s (s^2/12 + (s/2 - c)^2) + m_p (p^2/12 + (s + p/2 - c)^2)    about c, pitch
// A uniform one has c = L/2 and I = m L^2/12. The scoop's width lies across the plane and adds
// nothing to the pitch inertia. Drag: the strip of components/tail_drag.h from s to L.
// Limits of validity: no thickness, no bending.

#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/yaml.h"
#include "jaculus/model/planar.h"
#include "jaculus/model/urdf.h"
#include "model/fields.h"
#include "model/reduce.h"
#include "model/sections.h"

namespace jaculus::model {

/// What a tail does: nothing (it is not there), its inertia alone, or drag as well.
enum class TailKind { none, inertial, drag };

/// One entry of `attach`.
struct Attachment {
  std::string name;        ///< of a tail's link, joint, motor and drag
  std::string to;          ///< link that carries it
  Vec2 at = Vec2::Zero();  ///< pivot from that link's origin, along the robot's x and z [m]
  std::string urdf;        ///< file of a second URDF; empty: a tail
  TailKind kind = TailKind::drag;
  double length = 0.0;         ///< L, from the pivot to the tip [m]
  double scoop = 0.0;          ///< p [m]
  double width = 0.0;          ///< of the scoop [m]
  double mass = 0.0;           ///< m [kg]
  double scoop_mass = 0.0;     ///< m_p [kg]
  double coefficient = 0.0;    ///< C_D [-]
  double density = 0.0;        ///< of air [kg/m^3]
  Bounds range;                ///< of the joint [rad]
  yaml::Node motor;            ///< as in `motors`, or the name of a joint whose motor it is
  std::optional<double> gear;  ///< in place of the motor's [-]
  yaml::Node node;
};

/// attach: {name: {...}}, with overrides ("attach.tail.kind") in place of what stands there.
/// `robot_mass` [kg] is what a share of it counts. InputError with the place of the fault.
std::vector<Attachment> read_attachments(const yaml::Node& robot,
                                         const std::vector<OverrideInput>& overrides,
                                         double robot_mass);

/// Takes out those of kind none. Returns their links and joints, of which the rest of robot.yaml
/// may still speak.
Absent remove_absent(Reading reading, std::vector<Attachment>& attachments);

/// Adds links and joints of all attachments to a tree whose R_BL and p_BL are set.
void attach(const std::vector<Attachment>& attachments, Reading reading, SpatialTree& tree);

/// InputError where a link that carries something is left or right of a pair.
void check_carriers(const std::vector<Attachment>& attachments, const std::vector<PairSpec>& pairs,
                    const SpatialTree& tree);

/// Motors, drags and tips of attached tails, into a model that has their bodies.
void add_attached_parts(const std::vector<Attachment>& attachments, PlanarModel& model);

/// A tail's link: com, inertia along its axes (z along the tail).
SpatialLink tail_link(const Attachment& tail);

/// What was attached, as a sentence.
std::string attached_note(const Attachment& a);

/// Overridable paths of `attach` with what stands there, "attach.tail.kind = drag".
std::vector<std::string> attach_paths(const yaml::Node& robot);

/// A key of `attach` for `jaculus check --explain`.
struct AttachKey {
  std::string_view name;
  std::string_view meaning;  ///< with its unit
};
const std::vector<AttachKey>& attach_keys();

}  // namespace jaculus::model
