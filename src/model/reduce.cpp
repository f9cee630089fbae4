#include "model/reduce.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

#include "model/urdf_check.h"

namespace jaculus::model {
namespace {

constexpr double kTolerance = 1e-6;  ///< of directions [-] and of what pairs must share, relative

Vec2 in_plane(const Vec3& v) { return {v.x(), v.z()}; }

/// R(phi)' v, from a frame turned by phi about +y back into it.
Vec2 unrotate(double phi, const Vec2& v) {
  return {std::cos(phi) * v.x() - std::sin(phi) * v.y(),
          std::sin(phi) * v.x() + std::cos(phi) * v.y()};
}

double pitch_of(const Mat3& R) { return std::atan2(R(0, 2), R(0, 0)); }
bool about_y(const Mat3& R) { return R(1, 1) > 1.0 - kTolerance * kTolerance; }

/// Angle wrapped to (-pi, pi].
double wrap(double angle) { return std::remainder(angle, 2.0 * M_PI); }

/// The assignment of links to bodies. Side 0 is left (or the only one), 1 right.
class Reducer {
 public:
  Reducer(const SpatialTree& tree, const std::vector<PairSpec>& joints,
          const std::vector<PairSpec>& links)
      : tree_(tree), joint_pairs_(joints), link_pairs_(links) {
    body_.assign(tree.links.size(), -1);
    side_.assign(tree.links.size(), 0);
    pair_left_.assign(tree.joints.size(), -1);
    pair_right_.assign(tree.joints.size(), -1);
  }

  Reduction run() {
    find_pairs();
    heads_.push_back({tree_.root, -1});
    pairs_of_body_.push_back(-1);
    assign_left(tree_.root, 0);
    assign_right(tree_.root, 0, 0);
    for (int b = 0; b < count_of(heads_); ++b) result_.bodies.push_back(lump(b));
    place();
    drop_notes();
    return result_;
  }

 private:
  struct Heads {
    int left;   ///< link whose frame is the body's
    int right;  ///< its mirror image, -1 where not lumped
  };

  [[nodiscard]] InputError joint_error(const SpatialJoint& joint, const std::string& what) const {
    return urdf_error(tree_.file, joint.line, "joint '" + joint.name + "': " + what);
  }

  void find_pairs() {
    for (int p = 0; p < count_of(joint_pairs_); ++p) {
      pair_left_[tree_.joint_index(joint_pairs_[p].left)] = p;
      pair_right_[tree_.joint_index(joint_pairs_[p].right)] = p;
    }
  }

  /// Depth first in file order: bodies of everything but right-hand parts.
  void assign_left(int link, int body) {
    body_[link] = body;
    for (int j = 0; j < count_of(tree_.joints); ++j) {
      const SpatialJoint& joint = tree_.joints[j];
      if (joint.parent != link || pair_right_[j] >= 0) continue;

      if (joint.kind == SpatialJointKind::fixed) {
        assign_left(joint.child, body);
        continue;
      }
      if (pairs_of_body_[body] >= 0 && pair_left_[j] < 0) {
        throw joint_error(
            joint,
            fmt::format(
                "moves below the pair '{}' but is in no pair; allowed: pairs.joints names it and "
                "its mirror image",
                joint_pairs_[pairs_of_body_[body]].name));
      }

      const int child = count_of(heads_);
      heads_.push_back({joint.child, -1});
      pairs_of_body_.push_back(pair_left_[j]);
      parents_[child] = body;
      assign_left(joint.child, child);
    }
  }

  /// The whole tree again: right-hand parts join the bodies of their left-hand images.
  void assign_right(int link, int body, int side) {
    for (int j = 0; j < count_of(tree_.joints); ++j) {
      const SpatialJoint& joint = tree_.joints[j];
      if (joint.parent != link) continue;

      int child_body = body;
      int child_side = side;
      if (joint.kind != SpatialJointKind::fixed && pair_right_[j] >= 0) {
        child_body = right_body(joint, pair_right_[j], body);
        child_side = 1;
      } else if (joint.kind != SpatialJointKind::fixed) {
        child_body = body_[joint.child];
        if (side == 1)
          throw joint_error(
              joint, "moves below the right-hand part of a pair; allowed: the right of a pair");
      }

      body_[joint.child] = child_body;
      side_[joint.child] = child_side;
      assign_right(joint.child, child_body, child_side);
    }
  }

  int right_body(const SpatialJoint& joint, int pair, int parent_body) {
    const PairSpec& spec = joint_pairs_[pair];
    const int left_link = tree_.joints[tree_.joint_index(spec.left)].child;
    const int body = body_[left_link];
    if (body < 0 || parents_[body] != parent_body) {
      throw spec.node.error(fmt::format(
          "'{}' and '{}' hang on different bodies; allowed: joints of one body, or of a pair",
          spec.left, spec.right));
    }
    heads_[body].right = joint.child;
    return body;
  }

  /// One side of a body: what its links add up to, in the frame of its head.
  PlanarBody side(int body, int side) const {
    const Heads& heads = heads_[body];
    const SpatialLink& head = tree_.links[side == 0 ? heads.left : heads.right];
    PlanarBody result;
    result.name = head.name;
    if (body > 0) joint_of(head, body, side, result);

    const double phi = pitch_of(head.R_BL);
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t l = 0; l < tree_.links.size(); ++l) {
        const SpatialLink& link = tree_.links[l];
        if (body_[l] != body || side_[l] != side || link.mass == 0.0) continue;
        const Vec2 com = unrotate(phi, in_plane(link.p_BL + link.R_BL * link.com - head.p_BL));
        if (pass == 0) {
          result.mass += link.mass;
          // exact where there is but one link
          result.com += link.mass / result.mass * (com - result.com);
          continue;
        }

        const Mat3 inertia_B = link.R_BL * link.inertia * link.R_BL.transpose();
        result.inertia += inertia_B(1, 1) + link.mass * (com - result.com).squaredNorm();
      }
    }

    return result;
  }

  /// The joint that carries a body, in the frame of the parent's head.
  void joint_of(const SpatialLink& head, int body, int side, PlanarBody& result) const {
    const SpatialJoint& joint = tree_.joints[head.joint];
    const Heads& parents = heads_[parents_.at(body)];
    const bool right = side == 1 && parents.right >= 0;
    const SpatialLink& parent = tree_.links[right ? parents.right : parents.left];

    if (!about_y(head.R_BL)) {
      throw joint_error(joint,
                        "its frame is turned out of the sagittal plane; allowed: moving links "
                        "whose y axis is the root's");
    }

    const Vec3 axis_B = head.R_BL * joint.axis;
    const double phi = pitch_of(parent.R_BL);
    result.joint = joint.name;
    result.parent = parents_.at(body);
    result.origin = unrotate(phi, in_plane(head.p_BL - parent.p_BL));
    result.angle_offset = wrap(pitch_of(head.R_BL) - phi);

    const std::string shown = fmt::format("axis ({:.4g}, {:.4g}, {:.4g}) in the root's frame",
                                          axis_B.x(), axis_B.y(), axis_B.z());
    if (joint.kind == SpatialJointKind::revolute) {
      if (std::abs(axis_B.y()) < 1.0 - kTolerance) {
        throw joint_error(
            joint, shown + " given; allowed: +y or -y, or the joint in fixed_joints of robot.yaml");
      }
      result.sign = axis_B.y() > 0.0 ? 1.0 : -1.0;
      return;
    }

    if (std::abs(axis_B.y()) > kTolerance) {
      throw joint_error(
          joint,
          shown +
              " given; allowed: a direction in x-z, or the joint in fixed_joints of robot.yaml");
    }

    result.kind = JointKind::prismatic;
    result.axis = unrotate(phi, in_plane(axis_B)).normalized();
  }

  PlanarBody lump(int body) {
    PlanarBody left = side(body, 0);
    const Heads& heads = heads_[body];
    const SpatialLink& head = tree_.links[heads.left];
    result_.ranges.push_back(body == 0 ? Bounds{} : tree_.joints[head.joint].range);

    if (body > 0 && left.mass == 0.0) {
      throw urdf_error(
          tree_.file, head.line,
          fmt::format("link '{}' moves but has no mass; allowed: <inertial> with a mass above 0",
                      head.name));
    }

    if (heads.right < 0) return left;
    const PlanarBody right = side(body, 1);
    const PairSpec& pair = joint_pairs_[pairs_of_body_[body]];
    compare(pair, left, right);
    result_.notes.push_back(fmt::format("'{}' stands for '{}' and '{}': masses and inertias added",
                                        pair.name, left.joint, right.joint));

    left.joint = pair.name;
    left.name = planar_link_name(left.name, right.name);
    left.mass += right.mass;
    left.inertia += right.inertia;
    left.count = 2;
    return left;
  }

  [[nodiscard]] std::string planar_link_name(const std::string& left,
                                             const std::string& right) const {
    for (const PairSpec& pair : link_pairs_) {
      if (pair.left == left && pair.right == right) return pair.name;
    }
    return left;
  }

  /// Left and right must be alike in the plane, else one body can't stand for both.
  void compare(const PairSpec& pair, const PlanarBody& left, const PlanarBody& right) const {
    const auto same = [&](const char* what, const char* unit, double a, double b, double scale) {
      if (std::abs(a - b) <= kTolerance * scale) return;
      throw pair.node.error(
          fmt::format("'{}' and '{}' differ in {}: {:.10g} and {:.10g}{}{}; allowed: the same",
                      pair.left, pair.right, what, a, b, *unit ? " " : "", unit));
    };

    const Bounds& a = tree_.joints[tree_.joint_index(pair.left)].range;
    const Bounds& b = tree_.joints[tree_.joint_index(pair.right)].range;

    same("kind (0 revolute, 1 prismatic)", "", static_cast<double>(left.kind),
         static_cast<double>(right.kind), 1.0);
    same("mass", "kg", left.mass, right.mass, left.mass);
    same("joint position x", "m", left.origin.x(), right.origin.x(), 1.0);
    same("joint position z", "m", left.origin.y(), right.origin.y(), 1.0);
    same("zero angle", "rad", left.angle_offset, right.angle_offset, 1.0);
    same("direction of the axis", "", left.sign, right.sign, 1.0);
    same("direction of the slide, x", "", left.axis.x(), right.axis.x(), 1.0);
    same("direction of the slide, z", "", left.axis.y(), right.axis.y(), 1.0);
    same("centre of mass x", "m", left.com.x(), right.com.x(), 1.0);
    same("centre of mass z", "m", left.com.y(), right.com.y(), 1.0);
    same("pitch inertia", "kg m^2", left.inertia, right.inertia, left.inertia);

    if (a.lower != b.lower) same("lower limit", "", a.lower, b.lower, 1.0);
    if (a.upper != b.upper) same("upper limit", "", a.upper, b.upper, 1.0);
  }

  /// Places of all links on their bodies, and the planar names of paired links.
  void place() {
    for (std::size_t l = 0; l < tree_.links.size(); ++l) {
      const SpatialLink& link = tree_.links[l];
      const Heads& heads = heads_[body_[l]];
      const SpatialLink& head =
          tree_.links[side_[l] == 1 && heads.right >= 0 ? heads.right : heads.left];
      const double phi = pitch_of(head.R_BL);

      LinkPlace place;
      place.body = body_[l];
      place.in_plane = about_y(link.R_BL);
      place.angle = wrap(pitch_of(link.R_BL) - phi);
      place.position = unrotate(phi, in_plane(link.p_BL - head.p_BL));
      result_.links[link.name] = place;

      if (link.joint < 0 || tree_.joints[link.joint].kind != SpatialJointKind::fixed) continue;
      result_.notes.push_back(fmt::format("'{}' is fixed by '{}' and merged into '{}'", link.name,
                                          tree_.joints[link.joint].name, head.name));
    }

    for (const PairSpec& pair : link_pairs_) {
      const LinkPlace& left = result_.links.at(pair.left);
      const LinkPlace& right = result_.links.at(pair.right);
      if (left.body != right.body || (left.position - right.position).norm() > kTolerance ||
          std::abs(wrap(left.angle - right.angle)) > kTolerance) {
        throw pair.node.error(fmt::format(
            "'{}' and '{}' are not in the same place of one planar body; allowed: links that lie "
            "side by side on a pair of joints",
            pair.left, pair.right));
      }

      const LinkPlace copy = left;
      result_.links[pair.name] = copy;
    }
  }

  /// What the projection leaves out.
  void drop_notes() {
    double widest = 0.0;
    double mass = 0.0;
    double moment = 0.0;
    for (const SpatialLink& link : tree_.links) {
      widest = std::max(widest, std::abs(link.p_BL.y()));
      mass += link.mass;
      moment += link.mass * (link.p_BL + link.R_BL * link.com).y();
    }
    if (widest > 0.0)
      result_.notes.push_back(fmt::format(
          "sideways positions dropped (links up to {:.4g} m off the sagittal plane)", widest));
    if (mass > 0.0 && std::abs(moment) > 1e-4 * mass) {
      result_.notes.push_back(
          fmt::format("the centre of mass lies {:.4g} m to the left of the sagittal plane; dropped",
                      moment / mass));
    }
  }

  const SpatialTree& tree_;
  const std::vector<PairSpec>& joint_pairs_;
  const std::vector<PairSpec>& link_pairs_;
  std::vector<int> body_;        ///< of each link
  std::vector<int> side_;        ///< of each link
  std::vector<int> pair_left_;   ///< of each joint: the pair whose left one it is, or -1
  std::vector<int> pair_right_;  ///< the same for the right
  std::vector<Heads> heads_;     ///< of each body
  std::vector<int> pairs_of_body_;
  std::map<int, int> parents_;
  Reduction result_;
};

}  // namespace

Reduction reduce(const SpatialTree& spatial, const std::vector<PairSpec>& joints,
                 const std::vector<PairSpec>& links, const std::vector<HeldJoint>& held) {
  SpatialTree tree = spatial;
  for (const HeldJoint& hold : held) {
    SpatialJoint& joint = tree.joints[tree.joint_index(hold.joint)];
    if (joint.kind == SpatialJointKind::prismatic)
      joint.origin += joint.rotation * joint.axis * hold.value;
    if (joint.kind == SpatialJointKind::revolute) {
      joint.rotation =
          joint.rotation * Eigen::AngleAxisd(hold.value, joint.axis).toRotationMatrix();
    }
    joint.kind = SpatialJointKind::fixed;
  }
  place_links(tree);
  return Reducer(tree, joints, links).run();
}

}  // namespace jaculus::model
