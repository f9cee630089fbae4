// Joints that the plane has no place for, and left and right of those that it has.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "model/propose/draft.h"

namespace jaculus::model {
namespace {

/// Left and right must lie within this of one another in the plane; sides.cpp has the same [m].
constexpr double kPlace = 2e-3;
/// A joint nearer to the plane is in its middle [m].
constexpr double kMiddle = 1e-3;

double held_value(const SpatialJoint& joint, const ProposeOptions& options) {
  for (const auto* pose : {&options.pose, &options.file_pose}) {
    const auto stated = pose->find(joint.name);
    if (stated != pose->end()) return stated->second;
  }
  return std::clamp(0.0, joint.range.lower, joint.range.upper);
}

/// Why a joint can't move in the plane; empty where it can.
std::string why_held(const SpatialTree& tree, const SpatialJoint& joint) {
  const Vec3 axis = tree.links[joint.child].R_BL * joint.axis;
  if (joint.kind == SpatialJointKind::revolute && std::abs(axis.y()) < kAlong)
    return fmt::format("turns about ({:.2g}, {:.2g}, {:.2g}), out of the plane", axis.x(), axis.y(),
                       axis.z());
  if (joint.kind == SpatialJointKind::prismatic &&
      std::abs(axis.y()) > std::sqrt(1.0 - kAlong * kAlong))
    return "slides out of the plane";
  return subtree(tree, joint.child).total_mass() > 0.0 ? "" : "carries nothing that has mass";
}

bool has_motor(const SpatialJoint& joint) { return std::isfinite(joint.effort); }

/// Why a joint is held that could move in the plane; empty where it isn't.
std::string why_asked(const SpatialTree& tree, const SpatialJoint& joint,
                      const ProposeOptions& options) {
  if (index_of(options.hold, joint.name) >= 0) return "as asked for";
  const bool any = std::any_of(tree.joints.begin(), tree.joints.end(), has_motor);
  return options.hold_passive && any && !has_motor(joint)
             ? "no motor of their own with a stated limit"
             : "";
}

/// Joints from the root outwards, in file order where they are equally far.
std::vector<int> outwards(const SpatialTree& tree) {
  std::vector<int> order, links = {tree.root};
  for (std::size_t i = 0; i < links.size(); ++i) {
    for (int j = 0; j < count_of(tree.joints); ++j) {
      if (tree.joints[j].parent != links[i]) continue;
      order.push_back(j);
      links.push_back(tree.joints[j].child);
    }
  }
  return order;
}

/// The moving joint that carries a link, -1 for the base.
int carrier(const SpatialTree& tree, int link) {
  while (tree.links[link].joint >= 0) {
    const int j = tree.links[link].joint;
    if (tree.joints[j].kind != SpatialJointKind::fixed) return j;
    link = tree.joints[j].parent;
  }
  return -1;
}

class Pairing {
 public:
  explicit Pairing(const SpatialTree& tree) : tree_(tree), mate_(tree.joints.size(), -1) {}

  /// Mates by joint, -1 where alone.
  std::vector<int> run() {
    for (const int j : outwards(tree_)) {
      if (tree_.joints[j].kind == SpatialJointKind::fixed || mate_[j] >= 0) continue;
      int best = -1;
      double least = kInfinity;
      for (int k = 0; k < count_of(tree_.joints); ++k) {
        const std::optional<double> cost = cost_of(j, k);
        if (cost && *cost < least) {
          least = *cost;
          best = k;
        }
      }
      if (best < 0) continue;
      mate_[j] = best;
      mate_[best] = j;
    }
    return mate_;
  }

 private:
  [[nodiscard]] const SpatialLink& child(int j) const { return tree_.links[tree_.joints[j].child]; }

  /// How unlike mirror images two joints are [m]; nothing where they are none.
  [[nodiscard]] std::optional<double> cost_of(int j, int k) const {
    if (j == k || mate_[k] >= 0 || tree_.joints[j].kind != tree_.joints[k].kind) return {};
    const Vec3 a = child(j).p_BL;
    const Vec3 b = child(k).p_BL;
    const bool across =
        a.y() * b.y() < 0.0 && std::abs(a.y()) > kMiddle && std::abs(b.y()) > kMiddle;
    if (!across || std::abs(a.x() - b.x()) > kPlace || std::abs(a.z() - b.z()) > kPlace) return {};

    const int above_j = carrier(tree_, tree_.joints[j].parent);
    const int above_k = carrier(tree_, tree_.joints[k].parent);
    const bool mates = above_j >= 0 && above_k >= 0 && mate_[above_j] == above_k;
    if (above_j != above_k && !mates) return {};
    if (above_j == above_k && above_j >= 0 && mate_[above_j] >= 0) return {};

    std::string plain;
    for (const std::string& word : words_of(tree_.joints[k].name))
      plain += (plain.empty() ? "" : "_") + word;
    constexpr double kUnlikeNames = 0.02;  // [m]: motors side by side lie further apart
    return std::abs(a.y() + b.y()) +
           (other_side(tree_.joints[j].name) == plain ? 0.0 : kUnlikeNames);
  }

  const SpatialTree& tree_;
  std::vector<int> mate_;
};

/// How many joints the plane has no place for, by the reason.
void note_held(Draft& draft) {
  std::map<std::string, std::vector<std::string>> by_reason;
  for (const HeldBecause& h : draft.held) {
    const std::string reason = h.reason.starts_with("turns") ? "turn out of the plane" : h.reason;
    by_reason[reason].push_back(h.held.joint);
  }
  const auto moving = std::count_if(
      draft.tree.joints.begin(), draft.tree.joints.end(),
      [](const SpatialJoint& joint) { return joint.kind != SpatialJointKind::fixed; });
  for (const auto& [reason, joints] : by_reason)
    draft.notes.push_back(fmt::format("held, {} of {} joints ({}): {}", joints.size(), moving,
                                      reason, fmt::join(joints, ", ")));
}

/// What was asked to be held and can't be.
void check_asked(const ProposeOptions& options, Draft& draft) {
  const std::vector<SpatialJoint>& joints = draft.tree.joints;
  if (options.hold_passive && std::none_of(joints.begin(), joints.end(), has_motor))
    draft.notes.emplace_back(
        "`--hold passive` holds nothing: the file states no motor's limit, so none can be missing");
  for (const std::string& name : options.hold) {
    const bool held = std::any_of(draft.held.begin(), draft.held.end(),
                                  [&](const HeldBecause& h) { return h.held.joint == name; });
    if (!held)
      throw InputError(fmt::format(
          "--hold: '{}' is of the chain that carries the base; allowed: joints beyond it, and "
          "--base fixed for a base that is held",
          name));
  }
}

HeldJoint held_joint(const SpatialJoint& joint, const ProposeOptions& options) {
  const double value = held_value(joint, options);
  return {joint.name, value, joint.kind == SpatialJointKind::prismatic};
}

}  // namespace

std::vector<HeldJoint> held_of(const Draft& draft) {
  std::vector<HeldJoint> held;
  for (const HeldBecause& h : draft.held) held.push_back(h.held);
  return held;
}

void find_held(const ProposeOptions& options, Draft& draft) {
  // Holding one turns all that hangs on it, so the tree is placed anew after each.
  SpatialTree tree = draft.tree;
  for (const int j : outwards(tree)) {
    const SpatialJoint& joint = tree.joints[j];
    if (joint.kind == SpatialJointKind::fixed) continue;
    std::string reason = why_held(tree, joint);
    if (reason.empty()) reason = why_asked(tree, joint, options);
    if (reason.empty()) continue;
    draft.held.push_back({held_joint(joint, options), reason});
    tree = hold_joints(tree, {draft.held.back().held});
  }
  check_asked(options, draft);
}

void find_pairs(const ProposeOptions& options, Draft& draft) {
  SpatialTree tree = hold_joints(draft.tree, held_of(draft));
  std::vector<int> mates(tree.joints.size(), -1);
  if (options.pairs) mates = Pairing(tree).run();

  for (const int j : outwards(tree)) {
    if (tree.joints[j].kind == SpatialJointKind::fixed || mates[j] >= 0) continue;
    bool below = false;
    for (int a = carrier(tree, tree.joints[j].parent); a >= 0;
         a = carrier(tree, tree.joints[a].parent))
      below = below || mates[a] >= 0;
    if (!below) continue;
    draft.held.push_back(
        {held_joint(tree.joints[j], options), "hangs on one side and has no mirror image"});
  }

  const yaml::Node place = yaml::Node::parse("{}", "the proposal");
  for (const int j : outwards(tree)) {
    if (mates[j] < 0 || tree.links[tree.joints[j].child].p_BL.y() < 0.0) continue;
    // the left one's name, until a leg has a better one
    draft.pairs.push_back(
        {tree.joints[j].name, tree.joints[j].name, tree.joints[mates[j]].name, place});
  }
  note_held(draft);
  try {
    draft.reduction = reduce(draft.tree, draft.pairs, {}, held_of(draft));
  } catch (const InputError& error) {
    if (draft.pairs.empty()) throw;
    draft.missing.push_back(fmt::format(
        "pairs: left and right stay apart, for they can't be paired: {}", error.what()));
    draft.pairs.clear();
    draft.reduction = reduce(draft.tree, {}, {}, held_of(draft));
  }
}

std::vector<DraftJoint> joints_of(const Draft& draft) {
  std::vector<DraftJoint> joints;
  for (int b = 1; b < count_of(draft.reduction.bodies); ++b) {
    DraftJoint joint;
    joint.name = draft.reduction.bodies[b].joint;
    joint.body = b;
    for (const PairSpec& pair : draft.pairs) {
      if (pair.name != joint.name) continue;
      joint.spatial = {draft.tree.joint_index(pair.left), draft.tree.joint_index(pair.right)};
    }
    if (joint.spatial.empty()) joint.spatial = {draft.tree.joint_index(joint.name)};
    joints.push_back(joint);
  }
  return joints;
}

}  // namespace jaculus::model
