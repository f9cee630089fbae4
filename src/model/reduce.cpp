#include "model/reduce.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "jaculus/core/angle.h"
#include "model/inertia.h"
#include "model/sides.h"
#include "model/urdf_check.h"

namespace jaculus::model {
namespace {

constexpr double kTolerance = 1e-6;  ///< of directions and of places on a body, relative

Vec2 in_plane(const Vec3& v) { return {v.x(), v.z()}; }

/// R(phi)' v, from a frame turned by phi about +y back into it.
Vec2 unrotate(double phi, const Vec2& v) { return turned(-phi, v); }

double pitch_of(const Mat3& R) { return std::atan2(R(0, 2), R(0, 0)); }
bool about_y(const Mat3& R) { return R(1, 1) > std::cos(kLean); }

/// Angle wrapped to (-pi, pi].
double wrap(double angle) { return std::remainder(angle, 2.0 * M_PI); }

/// The assignment of links to bodies. Side 0 is left (or the only one), 1 right.
class Reducer {
 public:
  Reducer(const SpatialTree& tree, const std::vector<PairSpec>& joints,
          const std::vector<PairSpec>& links, Assumptions& assumptions)
      : tree_(tree), joint_pairs_(joints), link_pairs_(links), assumptions_(assumptions) {
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
    set_frames();
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

  /// The angle of each body's frame: its link's own where that lies in the plane, else the robot's
  /// with all joints at zero.
  void set_frames() {
    int turned = 0;
    frames_.assign(heads_.size(), {0.0, 0.0});
    for (int b = 1; b < count_of(heads_); ++b) {
      const Heads& heads = heads_[b];
      const Mat3& left = tree_.links[heads.left].R_BL;
      const Mat3& right = tree_.links[heads.right < 0 ? heads.left : heads.right].R_BL;
      // sides whose frames are turned against one another share the robot's: their sum is exact
      const bool alike = std::abs(wrap(pitch_of(left) - pitch_of(right))) <= kTolerance;
      if (about_y(left) && about_y(right) && (alike || assumptions_.strict())) {
        frames_[b] = {pitch_of(left), pitch_of(right)};
      } else {
        ++turned;
      }
    }
    if (turned == 0) return;
    result_.notes.push_back(fmt::format(
        "frames of {} moving link{} turned out of the plane, or left against right: points there "
        "are along the robot's axes with all joints at zero",
        turned, turned == 1 ? " is" : "s are"));
  }

  /// One side of a body: what its links add up to, in the frame of its head.
  PlanarBody side(int body, int side) const {
    const Heads& heads = heads_[body];
    const SpatialLink& head = tree_.links[side == 0 ? heads.left : heads.right];
    PlanarBody result;
    result.name = head.name;
    if (body > 0) joint_of(head, body, side, result);

    const double phi = frame_of(body, side);
    Vec2 squares = Vec2::Zero();  // of distances from the centre of mass, by mass [kg m^2]
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
        squares += squares_along(phi, inertia_B) + link.mass * (com - result.com).cwiseAbs2();
      }
    }
    if (result.mass > 0.0) result.spread = (squares / result.mass).cwiseMax(0.0).cwiseSqrt();

    return result;
  }

  /// The joint that carries a body, in the frame of the parent's head.
  void joint_of(const SpatialLink& head, int body, int side, PlanarBody& result) const {
    const SpatialJoint& joint = tree_.joints[head.joint];
    const Heads& parents = heads_[parents_.at(body)];
    const bool right = side == 1 && parents.right >= 0;
    const SpatialLink& parent = tree_.links[right ? parents.right : parents.left];

    const Vec3 axis_B = head.R_BL * joint.axis;
    const double phi = frame_of(parents_.at(body), right ? 1 : 0);
    result.joint = joint.name;
    result.file_joints = {{joint.name, 1.0, joint.attached}};
    result.parent = parents_.at(body);
    result.origin = unrotate(phi, in_plane(head.p_BL - parent.p_BL));
    result.angle_offset = wrap(frame_of(body, side) - phi);

    const bool turns = joint.kind == SpatialJointKind::revolute;
    check_axis(joint, turns, axis_B);
    if (turns) {
      result.sign = axis_B.y() > 0.0 ? 1.0 : -1.0;
      return;
    }
    result.kind = JointKind::prismatic;
    result.axis = unrotate(phi, in_plane(axis_B)).normalized();
  }

  /// How far an axis is from where the plane needs it.
  void check_axis(const SpatialJoint& joint, bool turns, const Vec3& axis_B) const {
    const double across = in_plane(axis_B).norm();
    const double lean = turns ? across : std::abs(axis_B.y());
    if (lean <= (turns ? std::sqrt(2.0 * kTolerance) : kTolerance)) return;

    const std::string fault = fmt::format(
        "axis ({:.4g}, {:.4g}, {:.4g}) in the root's frame given; allowed: {}, or the joint in "
        "fixed_joints of robot.yaml",
        axis_B.x(), axis_B.y(), axis_B.z(), turns ? "+y or -y" : "a direction in x-z");
    if (lean > std::sin(kLean)) throw joint_error(joint, fault);
    assumptions_.assume(joint.line, "joint '" + joint.name + "': " + fault,
                        fmt::format("taken as in the plane, from which it leans by {:.3g} deg",
                                    std::asin(lean) * 180.0 / M_PI));
  }

  PlanarBody lump(int body) {
    PlanarBody left = side(body, 0);
    const Heads& heads = heads_[body];
    const SpatialLink& head = tree_.links[heads.left];
    result_.ranges.push_back(body == 0 ? Bounds{} : tree_.joints[head.joint].range);

    if (body > 0 && left.mass == 0.0) {
      // keeps equations regular, is below every balance
      const double speck = 1e-8 * tree_.total_mass();
      assumptions_.assume(
          head.line,
          fmt::format("link '{}' moves but has no mass; allowed: <inertial> with a mass above 0",
                      head.name),
          "a 1e-8th of the robot's mass");
      left.mass = speck;
      left.inertia = sphere_moment(speck);
    }

    if (heads.right < 0) return left;
    const PlanarBody right = side(body, 1);
    const PairSpec& pair = joint_pairs_[pairs_of_body_[body]];
    const Bounds& range = tree_.joints[tree_.joint_index(pair.right)].range;
    result_.ranges.back() = compare_sides({pair, tree_.joints[head.joint].line, assumptions_},
                                          {left, result_.ranges.back()}, {right, range});
    result_.notes.push_back(fmt::format("'{}' stands for '{}' and '{}': masses and inertias added",
                                        pair.name, left.joint, right.joint));
    if (left.sign != right.sign) {
      result_.notes.push_back(fmt::format(
          "'{}' turns the other way: its angle is minus that of '{}'", right.joint, left.joint));
    }

    add_side(left, right);
    left.file_joints.push_back(
        {pair.right, left.sign * right.sign, right.file_joints.front().attached});
    left.joint = pair.name;
    left.name = planar_link_name(left.name, right.name);
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

  /// Places of all links on their bodies, and the planar names of paired links.
  void place() {
    for (std::size_t l = 0; l < tree_.links.size(); ++l) {
      const SpatialLink& link = tree_.links[l];
      const Heads& heads = heads_[body_[l]];
      const SpatialLink& head =
          tree_.links[side_[l] == 1 && heads.right >= 0 ? heads.right : heads.left];
      const double phi = frame_of(body_[l], side_[l]);

      LinkPlace place;
      place.body = body_[l];
      // the frame of a body is its head's, or stands for it
      place.in_plane = &link == &head || about_y(link.R_BL);
      place.angle = &link == &head ? 0.0 : wrap(pitch_of(link.R_BL) - phi);
      place.position = unrotate(phi, across_axis(link.p_BL - head.p_BL, head));
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

  /// A way in the plane that a link turns in, which leans where its axis does, from along y.
  [[nodiscard]] Vec2 across_axis(const Vec3& way, const SpatialLink& head) const {
    if (head.joint < 0 || tree_.joints[head.joint].kind != SpatialJointKind::revolute)
      return in_plane(way);
    const Vec3 axis = head.R_BL * tree_.joints[head.joint].axis;
    return in_plane(way - way.dot(axis) * axis);
  }

  /// What the projection leaves out.
  void drop_notes() {
    double widest = 0.0;
    const double mass = tree_.total_mass();
    double moment = 0.0;
    for (const SpatialLink& link : tree_.links) {
      widest = std::max(widest, std::abs(link.p_BL.y()));
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

  [[nodiscard]] double frame_of(int body, int side) const { return frames_[body][side]; }

  const SpatialTree& tree_;
  const std::vector<PairSpec>& joint_pairs_;
  const std::vector<PairSpec>& link_pairs_;
  std::vector<int> body_;        ///< of each link
  std::vector<int> side_;        ///< of each link
  std::vector<int> pair_left_;   ///< of each joint: the pair whose left one it is, or -1
  std::vector<int> pair_right_;  ///< the same for the right
  std::vector<Heads> heads_;     ///< of each body
  std::vector<std::array<double, 2>> frames_;  ///< of each body, left and right [rad]
  std::vector<int> pairs_of_body_;
  std::map<int, int> parents_;
  Assumptions& assumptions_;
  Reduction result_;
};

/// Joints that move in the file and are fixed in `tree`, where they are.
std::vector<HeldJoint> standing_joints(const SpatialTree& file, const SpatialTree& tree,
                                       const std::vector<HeldJoint>& held) {
  std::vector<HeldJoint> standing;
  for (std::size_t j = 0; j < file.joints.size(); ++j) {
    const SpatialJoint& joint = file.joints[j];
    if (joint.kind == SpatialJointKind::fixed || tree.joints[j].kind != SpatialJointKind::fixed)
      continue;
    const auto stated = std::find_if(held.begin(), held.end(),
                                     [&](const HeldJoint& h) { return h.joint == joint.name; });
    standing.push_back({joint.name, stated == held.end() ? 0.0 : stated->value,
                        joint.kind == SpatialJointKind::prismatic});
  }
  return standing;
}

}  // namespace

Reduction reduce(const SpatialTree& spatial, const std::vector<PairSpec>& joints,
                 const std::vector<PairSpec>& links, const std::vector<HeldJoint>& held,
                 Reading reading) {
  Assumptions assumptions(spatial.file, reading == Reading::strict);
  SpatialTree tree = hold_joints(spatial, held);
  hold_massless(tree, joints, assumptions);
  tree = gather_leaning(tree);

  Reduction reduction = Reducer(tree, joints, links, assumptions).run();
  reduction.held = standing_joints(spatial, tree, held);
  const std::vector<std::string> assumed = assumptions.notes();
  reduction.notes.insert(reduction.notes.end(), assumed.begin(), assumed.end());
  return reduction;
}

}  // namespace jaculus::model
