// A pose to stand in: every foot below its hip, all at one height, legs drawn in by a quarter.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/propose/draft.h"

namespace jaculus::model {
namespace {

/// Share of a leg's length at which it stands: knees bent by about 80 degrees, as quadrupeds are
/// carried by their controllers [-].
constexpr double kDrawnIn = 0.75;

/// A leg's joints, what they may do, and its foot.
struct Leg {
  std::vector<int> bodies;
  const DraftFoot* foot = nullptr;
  Vec2 hip = Vec2::Zero();  ///< with all joints at zero [m]
  double length = 0.0;      ///< [m]
  double knee = 1.0;        ///< +1: behind the hip rather than before it, -1: the other way
};

Vec2 foot_at(const Draft& draft, const Leg& leg, const std::map<std::string, double>& joints) {
  const Eigen::Vector3d pose = pose_of(draft.reduction, leg.bodies.back(), joints);
  const double c = std::cos(pose[2]);
  const double s = std::sin(pose[2]);
  const Vec2& p = leg.foot->point;
  return {pose[0] + c * p.x() + s * p.y(), pose[1] - s * p.x() + c * p.y()};
}

Leg leg_of(const Draft& draft, const DraftFoot& foot) {
  Leg leg;
  leg.foot = &foot;
  for (int b = foot.body; b > 0; b = draft.reduction.bodies[b].parent)
    leg.bodies.insert(leg.bodies.begin(), b);
  leg.hip = pose_of(draft.reduction, leg.bodies.front()).head<2>();
  leg.length = foot.point.norm();
  for (std::size_t i = 1; i < leg.bodies.size(); ++i)
    leg.length += draft.reduction.bodies[leg.bodies[i]].origin.norm();
  return leg;
}

Bounds range_of(const Draft& draft, int body) {
  const Bounds& r = draft.reduction.ranges[body];
  return {std::max(r.lower, -M_PI), std::min(r.upper, M_PI)};
}

/// How far a pose is from the one wanted [m]: the foot below the hip at `height`, and among two
/// knees the one behind, as most quadrupeds have it, or as the leg states.
double miss(const Draft& draft, const Leg& leg, double height,
            const std::map<std::string, double>& joints) {
  const Vec2 off = foot_at(draft, leg, joints) - Vec2(leg.hip.x(), height);
  const bool bent = leg.bodies.size() > 1;
  const double knee = bent ? pose_of(draft.reduction, leg.bodies[1], joints)[0] - leg.hip.x() : 0.0;
  // small against a foot that is off, but tells two knees apart
  return off.norm() + 1e-3 * std::max(0.0, leg.knee * knee);
}

/// The pose of two joints on a grid that closes in on the best.
void bend(const Draft& draft, const Leg& leg, double height, std::map<std::string, double>& rest) {
  const std::size_t moving = std::min<std::size_t>(2, leg.bodies.size());
  std::vector<Bounds> window;
  for (std::size_t i = 0; i < moving; ++i) window.push_back(range_of(draft, leg.bodies[i]));

  constexpr int kGrid = 60;
  for (int round = 0; round < 14; ++round) {
    double least = kInfinity;
    std::map<std::string, double> best = rest;
    for (int i = 0; i <= kGrid; ++i) {
      for (int k = 0; k <= (moving > 1 ? kGrid : 0); ++k) {
        std::map<std::string, double> trial = rest;
        for (std::size_t j = 0; j < moving; ++j) {
          const Bounds& w = window[j];
          trial[draft.reduction.bodies[leg.bodies[j]].joint] =
              w.lower + (w.upper - w.lower) * (j == 0 ? i : k) / kGrid;
        }
        const double off = miss(draft, leg, height, trial);
        if (off >= least) continue;
        least = off;
        best = trial;
      }
    }

    rest = best;
    for (std::size_t j = 0; j < moving; ++j) {
      const Bounds range = range_of(draft, leg.bodies[j]);
      const double at = rest[draft.reduction.bodies[leg.bodies[j]].joint];
      const double half = (window[j].upper - window[j].lower) / 10.0;
      window[j] = {std::max(range.lower, at - half), std::min(range.upper, at + half)};
    }
  }
}

double branch_at_rest(const Draft& draft, const DraftLoop& loop) {
  const Vec2 a = pose_of(draft.reduction, loop.a.body, draft.rest).head<2>();
  const Vec2 b = pose_of(draft.reduction, loop.b.body, draft.rest).head<2>();
  const Vec2 u = b - a;
  const Vec2 v = foot_at(draft, leg_of(draft, loop.a), draft.rest) - a;
  return u.y() * v.x() - u.x() * v.y() > 0.0 ? 1.0 : -1.0;
}

/// A pin that neither pose brings together is none.
void drop_open_loops(Draft& draft) {
  std::vector<DraftLoop> closed;
  for (const DraftLoop& loop : draft.loops) {
    const Vec2 a = foot_at(draft, leg_of(draft, loop.a), draft.rest);
    const Vec2 b = foot_at(draft, leg_of(draft, loop.b), draft.rest);
    constexpr double kMeet = 1e-3;  // [m]: poses are found to far less
    if ((a - b).norm() < kMeet) {
      closed.push_back(loop);
      continue;
    }
    draft.missing.push_back(
        fmt::format("loops.{}: its chains end {:.2g} m apart at rest: left open after all",
                    loop.name, (a - b).norm()));
  }
  draft.loops = closed;
}

/// The pose with all feet at the height of the leg that reaches least far.
void stand(const Draft& draft, std::map<std::string, double>& pose) {
  std::vector<Leg> legs;
  double height = -kInfinity;
  for (const DraftFoot& foot : draft.feet) {
    legs.push_back(leg_of(draft, foot));
    height = std::max(height, legs.back().hip.y() - kDrawnIn * legs.back().length);
  }

  // of a five-bar one knee points forward, the other back
  for (const DraftLoop& loop : draft.loops) {
    for (Leg& leg : legs)
      if (leg.foot->name == loop.a.name) leg.knee = -1.0;
    legs.push_back(leg_of(draft, loop.b));
  }
  for (const Leg& leg : legs) bend(draft, leg, height, pose);
}

}  // namespace

Eigen::Vector3d pose_of(const Reduction& reduction, int body,
                        const std::map<std::string, double>& joints) {
  if (body == 0) return Eigen::Vector3d::Zero();
  const PlanarBody& b = reduction.bodies[body];
  const auto found = joints.find(b.joint);
  const double theta = found == joints.end() ? 0.0 : found->second;
  const Eigen::Vector3d p = pose_of(reduction, b.parent, joints);
  const double c = std::cos(p[2]);
  const double s = std::sin(p[2]);
  const Vec2 at = b.origin + b.axis * theta;
  const double turn = b.kind == JointKind::revolute ? b.sign * theta : 0.0;
  return {p[0] + c * at.x() + s * at.y(), p[1] - s * at.x() + c * at.y(),
          p[2] + b.angle_offset + turn};
}

void find_rest(const ProposeOptions& options, Draft& draft) {
  for (int b = 1; b < count_of(draft.reduction.bodies); ++b) {
    const Bounds range = range_of(draft, b);
    draft.rest[draft.reduction.bodies[b].joint] =
        draft.reduction.bodies[b].kind == JointKind::revolute
            ? std::clamp(0.0, range.lower, range.upper)
            : std::clamp(0.0, draft.reduction.ranges[b].lower, draft.reduction.ranges[b].upper);
  }

  stand(draft, draft.rest);
  drop_open_loops(draft);
  for (DraftLoop& loop : draft.loops) loop.branch = branch_at_rest(draft, loop);

  for (const auto& [joint, value] : options.pose) {
    for (const DraftJoint& known : joints_of(draft)) {
      const bool spatial = std::any_of(known.spatial.begin(), known.spatial.end(),
                                       [&](int j) { return draft.tree.joints[j].name == joint; });
      if (known.name != joint && !spatial) continue;
      draft.rest[known.name] = value;
      draft.rest_stated = true;
    }
  }
}

}  // namespace jaculus::model
