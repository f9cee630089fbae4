#include "jaculus/model/urdf.h"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Dense>
#include <map>

#include "core/text_file.h"
#include "model/inertia.h"
#include "model/urdf_check.h"

namespace jaculus::model {
namespace {

/// Keeps what urdfdom would print, so that a fault is one message and nothing else.
class Capture : public console_bridge::OutputHandler {
 public:
  Capture() { console_bridge::useOutputHandler(this); }
  ~Capture() override { console_bridge::restorePreviousOutputHandler(); }
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char* /*file*/,
           int /*line*/) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && text_.empty()) text_ = text;
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

Vec3 vector(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

Mat3 matrix(const urdf::Rotation& r) {
  return Eigen::Quaterniond(r.w, r.x, r.y, r.z).normalized().toRotationMatrix();
}

/// The values of a link whose place in the file and shapes are known.
void read_link(const urdf::Link& source, SpatialLink& link, Assumptions& assumptions) {
  if (!source.inertial) return;
  const urdf::Inertial& inertial = *source.inertial;
  const Mat3 R_LI = matrix(inertial.origin.rotation);
  Mat3 inertia;
  inertia << inertial.ixx, inertial.ixy, inertial.ixz, inertial.ixy, inertial.iyy, inertial.iyz,
      inertial.ixz, inertial.iyz, inertial.izz;
  link.mass = inertial.mass;
  link.com = vector(inertial.origin.position);
  link.inertia = R_LI * inertia * R_LI.transpose();
  settle_inertia(link, assumptions);
}

Bounds read_range(const urdf::JointLimits& limits, const SpatialJoint& joint,
                  Assumptions& assumptions) {
  if (limits.lower <= limits.upper) return {limits.lower, limits.upper};
  assumptions.assume(
      joint.line,
      fmt::format(
          "joint '{}': lower limit {:.10g} is above upper limit {:.10g}; allowed: lower <= upper",
          joint.name, limits.lower, limits.upper),
      "no range");
  return {};
}

void read_joint(const urdf::Joint& source, bool unlimited, SpatialJoint& joint,
                Assumptions& assumptions, const std::filesystem::path& file) {
  joint.origin = vector(source.parent_to_joint_origin_transform.position);
  joint.rotation = matrix(source.parent_to_joint_origin_transform.rotation);
  if (source.type == urdf::Joint::FIXED) return;

  joint.kind = source.type == urdf::Joint::PRISMATIC ? SpatialJointKind::prismatic
                                                     : SpatialJointKind::revolute;
  joint.axis = vector(source.axis);
  if (!(joint.axis.norm() > 1e-6)) {
    throw urdf_error(
        file, joint.line,
        fmt::format("joint '{}': axis of length 0 given; allowed: a direction", joint.name));
  }
  joint.axis.normalize();

  if (source.dynamics) {
    joint.damping = source.dynamics->damping;
    joint.friction = source.dynamics->friction;
  }
  if (!source.limits) return;
  if (source.type != urdf::Joint::CONTINUOUS && !unlimited)
    joint.range = read_range(*source.limits, joint, assumptions);
  // URDF wants the keys; 0 is written where nobody knows
  if (source.limits->effort > 0.0) joint.effort = source.limits->effort;
  if (source.limits->velocity > 0.0) joint.velocity = source.limits->velocity;
}

/// One root, one parent a link, no cycle. urdfdom would say so without a line.
void connect(SpatialTree& tree) {
  for (int j = 0; j < count_of(tree.joints); ++j) {
    const SpatialJoint& joint = tree.joints[j];
    SpatialLink& child = tree.links[joint.child];

    if (joint.child == joint.parent) {
      throw urdf_error(
          tree.file, joint.line,
          fmt::format("joint '{}' connects link '{}' with itself", joint.name, child.name));
    }
    if (child.joint >= 0) {
      throw urdf_error(
          tree.file, joint.line,
          fmt::format("link '{}' is the child of both joint '{}' and joint '{}'; allowed: one "
                      "(loops are closed "
                      "in robot.yaml)",
                      child.name, tree.joints[child.joint].name, joint.name));
    }
    child.joint = j;
  }

  int roots = 0;
  for (int l = 0; l < count_of(tree.links); ++l) {
    const SpatialLink& link = tree.links[l];
    if (link.joint >= 0) continue;
    if (++roots == 2) {
      throw urdf_error(
          tree.file, link.line,
          fmt::format("links '{}' and '{}' both have no parent; allowed: one root, all others "
                      "connected to it",
                      tree.links[tree.root].name, link.name));
    }
    tree.root = l;
  }

  if (roots == 0) {
    throw urdf_error(tree.file, tree.joints.front().line,
                     "every link has a parent (the joints form a cycle); allowed: one root");
  }
}

/// The structure without values, checked with lines; urdfdom refuses a broken tree without saying
/// where.
SpatialTree skeleton(const UrdfOutline& outline, const std::filesystem::path& file) {
  SpatialTree tree;
  tree.file = file;
  tree.notes = outline.notes;
  for (const UrdfOutline::Link& source : outline.links) {
    SpatialLink link;
    link.name = source.name;
    link.line = source.line;
    link.shapes = source.shapes;
    tree.links.push_back(link);
  }

  if (tree.links.empty()) throw urdf_error(file, 1, "no <link> given; allowed: at least one");
  // Walks of the tree recurse; no robot comes near this.
  constexpr std::size_t kMaxLinks = 1000;
  if (tree.links.size() > kMaxLinks) {
    throw urdf_error(
        file, tree.links[kMaxLinks].line,
        fmt::format("{} links given; allowed: at most {}", tree.links.size(), kMaxLinks));
  }

  for (const UrdfOutline::Joint& source : outline.joints) {
    SpatialJoint joint;
    joint.name = source.name;
    joint.line = source.line;
    joint.parent = tree.link_index(source.parent);
    joint.child = tree.link_index(source.child);
    tree.joints.push_back(joint);
  }

  connect(tree);
  place_links(tree);
  return tree;
}

}  // namespace

int SpatialTree::link_index(const std::string& link) const {
  for (int i = 0; i < count_of(links); ++i) {
    if (links[i].name == link) return i;
  }
  return -1;
}

int SpatialTree::joint_index(const std::string& joint) const {
  for (int i = 0; i < count_of(joints); ++i) {
    if (joints[i].name == joint) return i;
  }
  return -1;
}

double SpatialTree::total_mass() const {
  double mass = 0.0;
  for (const SpatialLink& link : links) mass += link.mass;
  return mass;
}

/// Poses at joint zero, walking outwards; links that the walk never reaches hang in a cycle.
void place_links(SpatialTree& tree) {
  std::vector<bool> reached(tree.links.size(), false);
  reached[tree.root] = true;
  for (bool moved = true; moved;) {
    moved = false;
    for (const SpatialJoint& joint : tree.joints) {
      if (!reached[joint.parent] || reached[joint.child]) continue;
      const SpatialLink& parent = tree.links[joint.parent];
      SpatialLink& child = tree.links[joint.child];
      child.R_BL = parent.R_BL * joint.rotation;
      child.p_BL = parent.p_BL + parent.R_BL * joint.origin;
      reached[joint.child] = true;
      moved = true;
    }
  }

  for (std::size_t l = 0; l < tree.links.size(); ++l) {
    if (reached[l]) continue;
    throw urdf_error(
        tree.file, tree.links[l].line,
        fmt::format("link '{}' is not connected to the root '{}' (its joints form a cycle); "
                    "allowed: one tree",
                    tree.links[l].name, tree.links[tree.root].name));
  }
}

SpatialTree subtree(const SpatialTree& tree, int root) {
  SpatialTree part = tree;
  part.links.clear();
  part.joints.clear();
  std::vector<int> place(tree.links.size(), -1);

  // Links may stand in any order in the file: those below the root are found by walking up.
  for (int l = 0; l < count_of(tree.links); ++l) {
    int at = l;
    while (at != root && tree.links[at].joint >= 0) at = tree.joints[tree.links[at].joint].parent;
    if (at != root) continue;
    place[l] = count_of(part.links);
    part.links.push_back(tree.links[l]);
    part.links.back().joint = -1;
  }
  for (SpatialJoint joint : tree.joints) {
    if (place[joint.parent] < 0) continue;
    joint.parent = place[joint.parent];
    joint.child = place[joint.child];
    part.links[joint.child].joint = count_of(part.joints);
    part.joints.push_back(joint);
  }

  part.root = place[root];
  return part;
}

SpatialTree parse_urdf(const std::string& text, const std::filesystem::path& file,
                       Reading reading) {
  Assumptions assumptions(file, reading == Reading::strict);
  const UrdfOutline outline = check_urdf_text(text, file, assumptions);
  SpatialTree tree = skeleton(outline, file);

  Capture capture;
  urdf::ModelInterfaceSharedPtr model;
  try {
    model = urdf::parseURDF(outline.text);
  } catch (const std::exception& e) {
    throw urdf_error(file, 1,
                     fmt::format("urdfdom refuses the file: {}; allowed: a URDF file", e.what()));
  }
  if (!model) {
    throw urdf_error(
        file, 1, fmt::format("urdfdom refuses the file: {}; allowed: a URDF file", capture.text()));
  }

  tree.name = model->getName();
  for (SpatialLink& link : tree.links) read_link(*model->getLink(link.name), link, assumptions);
  for (int j = 0; j < count_of(tree.joints); ++j) {
    read_joint(*model->getJoint(tree.joints[j].name), outline.joints[j].unlimited, tree.joints[j],
               assumptions, file);
  }

  place_links(tree);
  const std::vector<std::string> assumed = assumptions.notes();
  tree.notes.insert(tree.notes.end(), assumed.begin(), assumed.end());
  return tree;
}

SpatialTree read_urdf(const std::filesystem::path& file, Reading reading) {
  return parse_urdf(read_text_file(file, "a URDF file"), file, reading);
}

}  // namespace jaculus::model
