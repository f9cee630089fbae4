// Legs: chains of joints from the base to what can touch the floor.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "model/propose/draft.h"

namespace jaculus::model {
namespace {

/// A chain of planar joints from the base to its last body.
struct Chain {
  std::vector<int> bodies;  ///< from the first on
  Vec3 hip = Vec3::Zero();  ///< of its first joint, in the robot's axes [m]
  Vec3 tip = Vec3::Zero();  ///< where it ends [m]
  double length = 0.0;      ///< from joint to joint to its end, in the plane [m]
  std::string source;       ///< what told the end
  Surface surface;          ///< of the shape that ends it
  double cap = 0.0;         ///< radius about its tip where a capsule ends it [m]
  bool guessed = false;
  bool wheel = false;
};

double in_plane_distance(const Vec3& a, const Vec3& b) {
  return std::hypot(a.x() - b.x(), a.z() - b.z());
}

/// Links that are one with a moving link, itself first.
std::vector<int> rigid_with(const SpatialTree& tree, int link) {
  std::vector<int> links = {link};
  for (std::size_t i = 0; i < links.size(); ++i) {
    for (const SpatialJoint& joint : tree.joints)
      if (joint.parent == links[i] && joint.kind == SpatialJointKind::fixed)
        links.push_back(joint.child);
  }
  return links;
}

/// The end of a shape that is farthest from a joint: a sphere's centre, the middle of the far face
/// of a box or cylinder, the centre of a capsule's far cap.
Vec3 far_end(const SpatialShape& shape, const SpatialLink& link, const Vec3& joint) {
  const Vec3 centre = link.p_BL + link.R_BL * shape.position;
  if (shape.kind == ShapeKind::sphere) return centre;
  int along = 0;
  shape.size.maxCoeff(&along);
  if (shape.kind != ShapeKind::box) along = 2;
  const Vec3 half = link.R_BL * shape.rotation.col(along) * shape.size[along];
  const Vec3 a = centre + half;
  const Vec3 b = centre - half;
  return in_plane_distance(a, joint) > in_plane_distance(b, joint) ? a : b;
}

bool names_foot(const std::string& name) {
  for (const std::string& word : words_of(name))
    for (const char* foot : {"foot", "toe", "paw", "feet"})
      if (word.starts_with(foot)) return true;
  return false;
}

std::string end_text(const SpatialShape& shape, const SpatialLink& link) {
  if (shape.kind == ShapeKind::sphere)
    return fmt::format("centre of a sphere of '{}', radius {:.4g} m", link.name, shape.size[0]);
  if (shape.kind == ShapeKind::capsule)
    return fmt::format(
        "lowest point at rest of a capsule's end, radius {:.4g} m, of '{}'; it doesn't roll",
        shape.size[0], link.name);
  return "far end of a shape of '" + link.name + "'";
}

/// What the file says of a shape's friction.
Surface surface_of(const Draft& draft, const SpatialLink& link, const SpatialShape& shape) {
  for (const Surface& known : draft.surfaces) {
    const bool unknown = std::isnan(known.friction) && std::isnan(shape.friction);
    if (known.link == link.name && (unknown || known.friction == shape.friction)) return known;
  }
  return {link.name, shape.friction, ""};
}

/// The same of the first shape of a link that touches.
Surface surface_of(const Draft& draft, const SpatialLink& link) {
  for (const SpatialShape& shape : link.shapes)
    if (shape.touches) return surface_of(draft, link, shape);
  return {};
}

/// Where a chain's last body ends.
void find_tip(const Draft& draft, const SpatialTree& tree, int head, Chain& chain) {
  const Vec3 joint = tree.links[head].p_BL;
  const std::vector<int> links = rigid_with(tree, head);
  // a rounding of what is at the joint itself
  double farthest = 1e-3;
  const auto offer = [&](const Vec3& point, const std::string& source, const Surface& surface) {
    if (in_plane_distance(point, joint) <= farthest) return;
    farthest = in_plane_distance(point, joint);
    chain.tip = point;
    chain.source = source;
    chain.surface = surface;
  };

  for (const int l : links) {
    const SpatialLink& link = tree.links[l];
    for (const SpatialShape& shape : link.shapes)
      if (shape.kind == ShapeKind::sphere && names_foot(link.name))
        offer(
            far_end(shape, link, joint),
            fmt::format("centre of the sphere of '{}', radius {:.4g} m", link.name, shape.size[0]),
            surface_of(draft, link, shape));
  }
  if (!chain.source.empty()) return;
  for (const int l : links)
    if (l != head && names_foot(tree.links[l].name))
      offer(tree.links[l].p_BL, "origin of '" + tree.links[l].name + "'",
            surface_of(draft, tree.links[l]));
  if (!chain.source.empty()) return;
  for (const int l : links)
    for (const SpatialShape& shape : tree.links[l].shapes) {
      const Vec3 before = chain.tip;
      offer(far_end(shape, tree.links[l], joint), end_text(shape, tree.links[l]),
            surface_of(draft, tree.links[l], shape));
      if (chain.tip != before) chain.cap = shape.kind == ShapeKind::capsule ? shape.size[0] : 0.0;
    }
  if (!chain.source.empty()) return;
  for (const int l : links)
    offer(tree.links[l].p_BL, "origin of '" + tree.links[l].name + "'",
          surface_of(draft, tree.links[l]));
  if (!chain.source.empty()) return;

  const SpatialLink& link = tree.links[head];
  chain.tip = joint + 2.0 * (link.R_BL * link.com);
  chain.guessed = true;
  chain.source = "twice as far as the centre of mass, for the file has no shape there";
}

std::vector<Chain> chains_of(const Draft& draft, const SpatialTree& tree) {
  const std::vector<PlanarBody>& bodies = draft.reduction.bodies;
  std::set<int> parents;
  for (const PlanarBody& body : bodies) parents.insert(body.parent);

  std::vector<Chain> chains;
  for (int b = 1; b < count_of(bodies); ++b) {
    if (parents.count(b) != 0) continue;
    Chain chain;
    for (int a = b; a > 0; a = bodies[a].parent) chain.bodies.insert(chain.bodies.begin(), a);
    const auto origin = [&](int body) {
      return tree.links[tree.link_index(bodies[body].name)].p_BL;
    };
    chain.hip = origin(chain.bodies.front());
    const int last = tree.link_index(bodies[b].name);
    find_tip(draft, tree, last, chain);

    for (std::size_t i = 1; i < chain.bodies.size(); ++i)
      chain.length += in_plane_distance(origin(chain.bodies[i - 1]), origin(chain.bodies[i]));
    chain.length += in_plane_distance(origin(b), chain.tip);

    const SpatialLink& link = tree.links[last];
    const Vec3 com = link.p_BL + link.R_BL * link.com;
    const bool endless = std::isinf(draft.reduction.ranges[b].upper);
    // what is round about its joint reaches nowhere
    chain.wheel = endless && in_plane_distance(com, link.p_BL) < 2e-3 &&
                  in_plane_distance(chain.tip, link.p_BL) < 1e-2;
    chains.push_back(chain);
  }
  return chains;
}

/// Names of groups from front to rear.
std::vector<std::string> end_names(std::size_t groups) {
  if (groups == 1) return {"leg"};
  if (groups == 2) return {"front", "rear"};
  if (groups == 3) return {"front", "middle", "rear"};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < groups; ++i) names.push_back(fmt::format("leg{}", i + 1));
  return names;
}

std::string joint_name(const std::string& leg, std::size_t i, bool lettered) {
  static const std::vector<std::string> parts = {"hip", "knee", "ankle"};
  if (lettered && i == 0) return leg;
  return fmt::format("{}_{}", leg, i < parts.size() ? parts[i] : fmt::format("joint{}", i + 1));
}

/// Legs of one place of the body are lettered a, b, ... (a five-bar has two).
using Legs = std::vector<std::vector<Chain>>;

Legs group_by_place(std::vector<Chain> chains) {
  // what lies side by side keeps the file's order, whatever its coordinates were rounded to
  const auto place = [](const Chain& chain) { return std::round(chain.hip.x() / 1e-3); };
  std::stable_sort(chains.begin(), chains.end(),
                   [&](const Chain& a, const Chain& b) { return place(a) > place(b); });
  Legs legs;
  for (const Chain& chain : chains) {
    const double near = 0.25 * chain.length;  // hips of a five-bar are nearer, of two legs farther
    if (!legs.empty() && std::abs(legs.back().front().hip.x() - chain.hip.x()) <= near) {
      legs.back().push_back(chain);
    } else {
      legs.push_back({chain});
    }
  }
  return legs;
}

void rename_pair(Draft& draft, const std::string& from, const std::string& to) {
  for (PairSpec& pair : draft.pairs)
    if (pair.name == from) pair.name = to;
}

/// A point of a body in the frame that robot.yaml uses for its head link.
Vec2 on_body(const Draft& draft, const SpatialTree& tree, int body, const Vec3& point) {
  const double phi = pose_of(draft.reduction, body)[2];
  const SpatialLink& link = tree.links[tree.link_index(draft.reduction.bodies[body].name)];
  const Vec3 axis = link.R_BL * tree.joints[link.joint].axis;
  Vec3 v = point - link.p_BL;
  if (tree.joints[link.joint].kind == SpatialJointKind::revolute) v -= v.dot(axis) * axis;
  return {std::cos(phi) * v.x() - std::sin(phi) * v.z(),
          std::sin(phi) * v.x() + std::cos(phi) * v.z()};
}

DraftFoot end_of(const Draft& draft, const SpatialTree& tree, const Chain& chain,
                 const std::string& name) {
  const int last = chain.bodies.back();
  return {name,
          draft.reduction.bodies[last].name,
          on_body(draft, tree, last, chain.tip),
          last,
          chain.source,
          chain.guessed,
          chain.surface,
          chain.cap};
}

void add_foot(Draft& draft, const DraftFoot& foot) {
  if (foot.guessed)
    draft.missing.push_back(fmt::format("feet.{}.point: {}", foot.name, foot.source));
  draft.feet.push_back(foot);
}

/// Two chains of their own that begin at one place on one side.
bool shares_hip(const std::vector<Chain>& leg) {
  if (leg.size() != 2) return false;
  const Chain& a = leg[0];
  const Chain& b = leg[1];
  const bool one_side = a.hip.y() * b.hip.y() > 0.0 || std::abs(a.hip.y() - b.hip.y()) < 0.01;
  return one_side && a.bodies.front() != b.bodies.front();
}

/// Two such chains of two links, as long as one another.
bool is_five_bar(const std::vector<Chain>& leg) {
  constexpr double kAlike = 0.1;  // ends of shapes differ by a shape's thickness
  return shares_hip(leg) && leg[0].bodies.size() == 2 && leg[1].bodies.size() == 2 &&
         std::abs(leg[0].length - leg[1].length) < kAlike * leg[0].length;
}

/// Chains that may be a five-bar's, but aren't alike enough to be taken for one.
void note_unlike(Draft& draft, const std::vector<DraftFoot>& ends, const std::vector<Chain>& chains,
                 const std::string& leg) {
  const std::size_t most = std::max(chains[0].bodies.size(), chains[1].bodies.size());
  if (std::min(chains[0].bodies.size(), chains[1].bodies.size()) < 2) return;
  draft.missing.push_back(fmt::format(
      "loops.{}_leg: two chains begin at one hip, of {} and {} joints, {:.3g} and {:.3g} m long; a "
      "five-bar's would be alike, with two joints each: left apart{}",
      leg, chains[0].bodies.size(), chains[1].bodies.size(), chains[0].length, chains[1].length,
      most > 2 ? "" : ". robot.yaml has the lines for a pin"));
  if (most > 2) return;
  draft.open_loops.push_back(pinned(draft, leg, ends[0], ends[1]));
  draft.open_loops.back().why_open = "they aren't alike";
}

void add_leg(Draft& draft, const SpatialTree& tree, const std::vector<Chain>& chains,
             const std::string& leg, bool loops) {
  const std::vector<PlanarBody> bodies = draft.reduction.bodies;
  const bool lettered = chains.size() > 1;
  std::vector<std::string> names;
  for (std::size_t c = 0; c < chains.size(); ++c) {
    names.push_back(lettered ? fmt::format("{}_{}", leg, static_cast<char>('a' + c)) : leg);
    for (std::size_t i = 0; i < chains[c].bodies.size(); ++i)
      rename_pair(draft, bodies[chains[c].bodies[i]].joint, joint_name(names[c], i, lettered));
  }

  std::vector<DraftFoot> ends;
  for (std::size_t c = 0; c < chains.size(); ++c)
    ends.push_back(end_of(draft, tree, chains[c], names[c] + "_foot"));
  if (loops && is_five_bar(chains)) {
    add_five_bar(draft, leg, ends[0], ends[1]);
    return;
  }
  if (loops && shares_hip(chains)) note_unlike(draft, ends, chains, leg);
  for (const DraftFoot& end : ends) add_foot(draft, end);
}

double height_of_mass(const SpatialTree& tree) {
  double sum = 0.0;
  for (const SpatialLink& link : tree.links)
    sum += link.mass * (link.p_BL + link.R_BL * link.com).z();
  const double mass = tree.total_mass();
  return mass > 0.0 ? sum / mass : 0.0;
}

/// Whether a chain begins in the middle of the robot rather than to a side [m].
bool in_the_middle(const Chain& chain) { return std::abs(chain.hip.y()) < 0.01; }

/// How low the chains to the sides of the robot reach as it is drawn; infinite where it has none.
double lowest_at_sides(const std::vector<Chain>& chains) {
  double lowest = kInfinity;
  for (const Chain& chain : chains)
    if (!in_the_middle(chain) && !chain.wheel) lowest = std::min(lowest, chain.tip.z());
  return lowest;
}

/// Legs reach the floor together, one to the left for each to the right: of what is in the middle
/// beside such, as necks, arms and tails are, only what ends as low as they do stands on the floor.
std::vector<Chain> legs_of(Draft& draft, const SpatialTree& tree) {
  constexpr double kAsLow = 0.25;  // of its length
  const double height = height_of_mass(tree);
  const std::vector<Chain> chains = chains_of(draft, tree);
  const double lowest = lowest_at_sides(chains);

  std::vector<Chain> legs;
  for (const Chain& chain : chains) {
    const std::string joint = draft.reduction.bodies[chain.bodies.front()].joint;
    if (chain.wheel) {
      draft.notes.push_back(fmt::format(
          "'{}' turns about its own centre of mass: a wheel or rotor; rolling is not modelled, so "
          "it has no foot",
          draft.reduction.bodies[chain.bodies.back()].joint));
    } else if (chain.hip.z() - height > 0.5 * chain.length) {
      draft.notes.push_back(
          fmt::format("'{}' begins no leg: it is far above the centre of mass", joint));
    } else if (in_the_middle(chain) && std::isfinite(lowest) &&
               chain.tip.z() - lowest > kAsLow * chain.length) {
      draft.notes.push_back(fmt::format(
          "'{}' begins no leg: it is in the middle, between left and right ones, and its end is "
          "{:.2g} m above theirs as the file is drawn",
          joint, chain.tip.z() - lowest));
    } else {
      legs.push_back(chain);
    }
  }
  return legs;
}

}  // namespace

void find_feet(const ProposeOptions& options, Draft& draft) {
  if (!draft.floating) return;
  const SpatialTree tree = gather_leaning(hold_joints(draft.tree, held_of(draft)));
  const Legs groups = group_by_place(legs_of(draft, tree));
  const std::vector<std::string> ends = end_names(groups.size());
  for (std::size_t g = 0; g < groups.size(); ++g)
    add_leg(draft, tree, groups[g], ends[g], options.loops);
  draft.reduction = reduce(draft.tree, draft.pairs, {}, held_of(draft));
}

}  // namespace jaculus::model
