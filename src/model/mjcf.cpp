#include "jaculus/model/mjcf.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>

#include "jaculus/core/error.h"
#include "model/mjcf_floor.h"
#include "model/mjcf_load.h"

namespace jaculus::model {

bool is_mjcf(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string text;
  for (char c = 0; text.size() < 100000 && stream.get(c);) text.push_back(c);
  // the first element that is neither a comment nor a declaration
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    if (text.compare(at, 4, "<!--") == 0) {
      at = text.find("-->", at);
      if (at == std::string::npos) return false;
      continue;
    }
    if (text.compare(at, 2, "<?") == 0 || text.compare(at, 2, "<!") == 0) continue;
    return text.compare(at, 7, "<mujoco") == 0;
  }
  return false;
}

#ifndef JACULUS_HAS_MUJOCO

MjcfRobot read_mjcf(const std::filesystem::path& file, Reading) {
  throw InputError(fmt::format(
      "{}: an MJCF file, which MuJoCo reads, and this build was made without it; install "
      "libmujoco-dev (Debian) and build again, or give a URDF file",
      file.string()));
}

#else

namespace {

Vec3 vector(const mjtNum* v) { return {v[0], v[1], v[2]}; }
Mat3 matrix(const mjtNum* q) {
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
}

/// A compiled MuJoCo model turned into links and joints.
class Converter {
 public:
  Converter(const mjModel& model, const std::filesystem::path& file) : m_(model) {
    robot_.tree.file = file;
    robot_.tree.name = m_.names[0] != '\0' ? std::string(m_.names) : file.stem().string();
    link_of_.assign(m_.nbody, -1);
    shift_.assign(m_.nbody, Vec3::Zero());
  }

  MjcfRobot run() {
    const int top = top_body();
    const bool free = m_.body_jntnum[top] == 1 && m_.jnt_type[m_.body_jntadr[top]] == mjJNT_FREE;
    robot_.floating = free;
    if (free) {
      link_of_[top] = add_link(body_name(top), top, Vec3::Zero());
    } else {
      link_of_[0] = add_link("world", -1, Vec3::Zero());
      add_body(top);
    }
    for (int b = top + 1; b < m_.nbody; ++b)
      if (m_.body_rootid[b] == top) add_body(b);

    if (std::none_of(robot_.tree.joints.begin(), robot_.tree.joints.end(),
                     [](const SpatialJoint& j) { return j.kind != SpatialJointKind::fixed; }))
      throw InputError(robot_.tree.file.string() + ": no joint of it turns or slides");
    place_links(robot_.tree);
    note_others(top);
    read_keyframe();
    return robot_;
  }

 private:
  [[nodiscard]] std::string name_of(mjtObj type, int id, const char* otherwise) const {
    const char* name = mj_id2name(&m_, type, id);
    return name && *name ? std::string(name) : fmt::format("{}_{}", otherwise, id);
  }
  [[nodiscard]] std::string body_name(int b) const { return name_of(mjOBJ_BODY, b, "body"); }
  [[nodiscard]] std::string joint_name(int j) const { return name_of(mjOBJ_JOINT, j, "joint"); }

  /// The body under the world that has the most joints.
  [[nodiscard]] int top_body() const {
    std::vector<int> joints(m_.nbody, 0);
    for (int j = 0; j < m_.njnt; ++j) ++joints[m_.body_rootid[m_.jnt_bodyid[j]]];
    const auto most = std::max_element(joints.begin(), joints.end());
    if (m_.nbody < 2 || *most == 0)
      throw InputError(robot_.tree.file.string() + ": no body of it moves; allowed: a robot");
    return static_cast<int>(most - joints.begin());
  }

  /// A link with what a body holds, -1: with nothing. `shift`: its origin in the body's frame.
  int add_link(const std::string& name, int body, const Vec3& shift) {
    SpatialLink link;
    link.name = name;
    if (body >= 0) {
      const Mat3 R = matrix(m_.body_iquat + 4 * body);
      link.mass = m_.body_mass[body];
      link.com = vector(m_.body_ipos + 3 * body) - shift;
      link.inertia = R * vector(m_.body_inertia + 3 * body).asDiagonal() * R.transpose();
      if (!(link.mass > 0.0)) link.com.setZero();
      add_shapes(body, shift, link);
    }
    robot_.tree.links.push_back(link);
    return count_of(robot_.tree.links) - 1;
  }

  /// Whether a stated contact pair lets a geom meet another whatever their masks.
  [[nodiscard]] bool in_a_pair(int geom) const {
    for (int p = 0; p < m_.npair; ++p)
      if (m_.pair_geom1[p] == geom || m_.pair_geom2[p] == geom) return true;
    return false;
  }

  void add_shapes(int body, const Vec3& shift, SpatialLink& link) {
    for (int g = m_.body_geomadr[body]; g >= 0 && g < m_.body_geomadr[body] + m_.body_geomnum[body];
         ++g) {
      const bool masked = m_.geom_contype[g] == 0 && m_.geom_conaffinity[g] == 0;
      if (masked && !in_a_pair(g)) continue;
      SpatialShape shape;
      shape.size = vector(m_.geom_size + 3 * g);
      switch (m_.geom_type[g]) {
        case mjGEOM_SPHERE:
          shape.size = Vec3::Constant(shape.size[0]);
          break;
        case mjGEOM_BOX:
          shape.kind = ShapeKind::box;
          break;
        case mjGEOM_CYLINDER:
          shape.kind = ShapeKind::cylinder;
          break;
        case mjGEOM_CAPSULE:
          shape.kind = ShapeKind::capsule;
          break;
        default:
          continue;
      }
      if (shape.kind == ShapeKind::cylinder || shape.kind == ShapeKind::capsule)
        shape.size = Vec3(shape.size[0], shape.size[0], shape.size[1]);
      Surface surface = surface_on_floor(m_, g);
      shape.friction = surface.friction;
      surface.link = link.name;
      if (!surface.source.empty()) robot_.surfaces.push_back(surface);
      shape.position = vector(m_.geom_pos + 3 * g) - shift;
      shape.rotation = matrix(m_.geom_quat + 4 * g);
      link.shapes.push_back(shape);
    }
  }

  /// Joints of a body in their order, each with a link of its own; the last holds the body.
  void add_body(int b) {
    const int parent = m_.body_parentid[b];
    Vec3 at = vector(m_.body_pos + 3 * b) - shift_[parent];
    Mat3 R = matrix(m_.body_quat + 4 * b);
    int link = link_of_[parent];
    Vec3 anchor = Vec3::Zero();

    std::vector<int> joints;
    for (int j = m_.body_jntadr[b]; j >= 0 && j < m_.body_jntadr[b] + m_.body_jntnum[b]; ++j) {
      if (m_.jnt_type[j] == mjJNT_HINGE || m_.jnt_type[j] == mjJNT_SLIDE) {
        joints.push_back(j);
      } else {
        robot_.notes.push_back(
            fmt::format("joint '{}' is a ball or free joint: taken as fixed", joint_name(j)));
      }
    }

    for (std::size_t i = 0; i < std::max<std::size_t>(1, joints.size()); ++i) {
      const bool moves = !joints.empty();
      const bool last = i + 1 >= joints.size();
      const Vec3 here = moves ? vector(m_.jnt_pos + 3 * joints[i]) : Vec3(Vec3::Zero());
      SpatialJoint joint;
      joint.parent = link;
      joint.origin = at + R * (here - anchor);
      joint.rotation = R;
      joint.name = moves ? joint_name(joints[i]) : body_name(b) + "_fixed";
      if (moves) set_joint(joints[i], joint);
      link = last ? add_link(body_name(b), b, here)
                  : add_link(fmt::format("{}_{}", body_name(b), joint.name), -1, here);
      joint.child = link;
      robot_.tree.links[link].joint = count_of(robot_.tree.joints);
      robot_.tree.joints.push_back(joint);
      // later joints of the body count from this one, along the body's axes
      at.setZero();
      R.setIdentity();
      anchor = here;
    }
    link_of_[b] = link;
    shift_[b] = anchor;
  }

  void set_joint(int j, SpatialJoint& joint) {
    const bool slides = m_.jnt_type[j] == mjJNT_SLIDE;
    joint.kind = slides ? SpatialJointKind::prismatic : SpatialJointKind::revolute;
    joint.axis = vector(m_.jnt_axis + 3 * j).normalized();
    const double zero = m_.qpos0[m_.jnt_qposadr[j]];
    if (m_.jnt_limited[j])
      joint.range = {m_.jnt_range[2 * j] - zero, m_.jnt_range[2 * j + 1] - zero};
    joint.effort = effort_of(j);

    const int dof = m_.jnt_dofadr[j];
    const double armature = m_.dof_armature[dof];
    if (armature > 0.0 && !slides) robot_.armature[joint.name] = armature;
    joint.damping = m_.dof_damping[dof];
    joint.friction = m_.dof_frictionloss[dof];
    const double stiffness = m_.jnt_stiffness[j];
    const double lost = slides ? armature : 0.0;
    if (stiffness == 0.0 && lost == 0.0) return;
    robot_.notes.push_back(fmt::format(
        "joint '{}': stiffness {:.4g}{} (SI) is no part of the nominal robot; effects simulate it",
        joint.name, stiffness, lost > 0.0 ? fmt::format(", armature {:.4g}", lost) : ""));
  }

  /// The largest torque that actuators with limits give at a joint; infinite where none has any.
  [[nodiscard]] double effort_of(int j) const {
    double sum = 0.0;
    for (int a = 0; a < m_.nu; ++a) {
      if (m_.actuator_trntype[a] != mjTRN_JOINT || m_.actuator_trnid[2 * a] != j) continue;
      const double gear = std::abs(m_.actuator_gear[6 * a]);
      const mjtNum* force = m_.actuator_forcerange + 2 * a;
      const mjtNum* control = m_.actuator_ctrlrange + 2 * a;
      if (m_.actuator_forcelimited[a]) {
        sum += gear * std::max(std::abs(force[0]), std::abs(force[1]));
      } else if (m_.actuator_ctrllimited[a] && m_.actuator_biastype[a] == mjBIAS_NONE) {
        sum += gear * std::abs(m_.actuator_gainprm[mjNGAIN * a]) *
               std::max(std::abs(control[0]), std::abs(control[1]));
      }
    }
    return sum > 0.0 ? sum : kInfinity;
  }

  void note_others(int top) {
    for (int b = 1; b < m_.nbody; ++b) {
      if (m_.body_parentid[b] != 0 || b == top) continue;
      robot_.notes.push_back("body '" + body_name(b) + "' is no part of the robot: left out");
    }
    for (int e = 0; e < m_.neq; ++e) {
      robot_.notes.push_back(
          fmt::format("constraint '{}' is left out; a pin that closes a loop belongs into `loops` "
                      "of robot.yaml",
                      name_of(mjOBJ_EQUALITY, e, "equality")));
    }
    if (m_.ntendon > 0) robot_.notes.push_back(fmt::format("{} tendons are left out", m_.ntendon));
    std::vector<std::string> others;
    for (int a = 0; a < m_.nu; ++a)
      if (m_.actuator_trntype[a] != mjTRN_JOINT)
        others.push_back(name_of(mjOBJ_ACTUATOR, a, "motor"));
    if (!others.empty())
      robot_.notes.push_back(fmt::format("actuators that act on no single joint are left out: {}",
                                         fmt::join(others, ", ")));
  }

  void read_keyframe() {
    if (m_.nkey == 0) return;
    for (const SpatialJoint& joint : robot_.tree.joints) {
      const int j = mj_name2id(&m_, mjOBJ_JOINT, joint.name.c_str());
      if (j < 0) continue;
      const int at = m_.jnt_qposadr[j];
      robot_.pose[joint.name] =
          std::clamp(m_.key_qpos[at] - m_.qpos0[at], joint.range.lower, joint.range.upper);
    }
    robot_.notes.push_back("the file's pose: that of keyframe '" + name_of(mjOBJ_KEY, 0, "key") +
                           "'");
  }

  const mjModel& m_;
  MjcfRobot robot_;
  std::vector<int> link_of_;  ///< of each body: the link that holds it
  std::vector<Vec3> shift_;   ///< of each body: its link's origin in its frame [m]
};

}  // namespace

MjcfRobot read_mjcf(const std::filesystem::path& file, Reading reading) {
  const LoadedMjcf loaded = load_mjcf(file, reading);
  MjcfRobot robot = Converter(*loaded.model, file).run();
  robot.notes.insert(robot.notes.begin(), loaded.notes.begin(), loaded.notes.end());
  return robot;
}

#endif

}  // namespace jaculus::model
