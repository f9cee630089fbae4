#include "jaculus/model/propose.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "jaculus/core/error.h"
#include "jaculus/core/yaml.h"
#include "model/propose/draft.h"
#include "model/swollen.h"

namespace jaculus::model {
namespace {

/// InputError where a name is of no joint that moves.
void check_moves(const SpatialTree& tree, const std::string& name, const std::string& option) {
  std::vector<std::string> names;
  for (const SpatialJoint& joint : tree.joints)
    if (joint.kind != SpatialJointKind::fixed) names.push_back(joint.name);
  if (index_of(names, name) >= 0) return;
  throw InputError(fmt::format("{}: no joint '{}' moves{}; allowed: {}", option, name,
                               yaml::did_you_mean(name, names), fmt::join(names, ", ")));
}

void check_pose(const SpatialTree& tree, const ProposeOptions& options) {
  for (const std::string& name : options.hold) check_moves(tree, name, "--hold");

  for (const auto& [name, value] : options.pose) {
    check_moves(tree, name, "--pose");
    const Bounds& range = tree.joints[tree.joint_index(name)].range;
    if (!range.contains(value)) {
      throw InputError(fmt::format("--pose: {} = {:.6g} is out of range; allowed: {:.6g} to {:.6g}",
                                   name, value, range.lower, range.upper));
    }
  }
}

/// What files of first drafts have ones for.
void find_swollen(Draft& draft) {
  const SpatialTree tree = hold_joints(draft.tree, held_of(draft));
  const SwollenLinks swollen = swollen_links(tree);
  if (swollen.links.empty()) return;
  std::vector<std::string> names;
  for (const int l : swollen.links) names.push_back(tree.links[l].name);
  draft.missing.push_back(fmt::format(
      "robot.urdf: inertias of {} links are those of their mass up to {:.2g} m away, on a robot of "
      "{:.2g} m; used as they are (--inertias shapes takes those of their shapes): {}",
      names.size(), swollen.farthest, swollen.size, fmt::join(names, ", ")));
}

}  // namespace

std::string Dropped::com_sideways() const {
  return fmt::format("{:.2f} mm to the {}", 1e3 * std::abs(com_off_plane),
                     com_off_plane < 0.0 ? "right" : "left");
}

Dropped dropped_of(const Draft& draft) {
  const SpatialTree tree = hold_joints(draft.tree, held_of(draft));
  Dropped dropped;
  Vec3 com = Vec3::Zero();
  for (const SpatialLink& link : tree.links) {
    const Vec3 at = link.p_BL + link.R_BL * link.com;
    dropped.mass += link.mass;
    com += link.mass * at;
    dropped.inertia_moved += link.mass * at.y() * at.y();
    if (std::abs(at.y()) > 1e-2) dropped.mass_off_plane += link.mass;
  }
  if (!(dropped.mass > 0.0)) return dropped;
  com /= dropped.mass;
  dropped.com_off_plane = com.y();

  Mat3 inertia = Mat3::Zero();
  for (const SpatialLink& link : tree.links) {
    const Vec3 r = link.p_BL + link.R_BL * link.com - com;
    inertia += link.R_BL * link.inertia * link.R_BL.transpose() +
               link.mass * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
  }
  dropped.pitch_inertia = inertia(1, 1);
  if (inertia(1, 1) > 0.0)
    dropped.coupling = std::hypot(inertia(0, 1), inertia(1, 2)) / inertia(1, 1);
  return dropped;
}

Proposal propose_robot(const SpatialTree& tree, const ProposeOptions& options) {
  check_pose(tree, options);
  Draft draft;
  draft.armature = options.armature;
  draft.surfaces = options.surfaces;
  find_frame(tree, options, draft);
  find_held(options, draft);
  find_pairs(options, draft);
  find_feet(options, draft);
  find_rest(options, draft);
  find_swollen(draft);

  Proposal proposal;
  proposal.dropped = dropped_of(draft);
  proposal.floating = draft.floating;
  proposal.planar = draft.reduction.bodies.size() > 1;
  if (!proposal.planar) {
    draft.missing.emplace_back(
        "nothing of this robot turns or slides in one plane, so nothing but its base moves");
  } else if (draft.floating && draft.feet.empty()) {
    draft.missing.emplace_back(
        "feet: none was found, so nothing carries it on the floor; wheels don't");
  }
  proposal.yaml = write_proposal(draft, proposal.dropped);
  for (const HeldBecause& h : draft.held) proposal.held.push_back(h.held.joint);
  proposal.notes = draft.notes;
  proposal.missing = draft.missing;
  proposal.rest = draft.rest;
  return proposal;
}

}  // namespace jaculus::model
