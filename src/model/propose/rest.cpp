// A pose to stand in: every foot below its hip, all at one height, legs drawn in by a quarter.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/propose/draft.h"

namespace jaculus::model {
namespace {

/// A pose in which a foot is less than this share of its leg's length below its hip is one to lie
/// in, as keyframes of files may be [-].
constexpr double kLeast = 0.3;

/// Share of a leg's length at which it stands: knees bent by about 80 degrees, as quadrupeds are
/// carried by their controllers [-].
constexpr double kDrawnIn = 0.75;

/// A chain of joints and what is to be brought below its hip.
struct Leg {
  std::vector<int> bodies;
  Vec2 point = Vec2::Zero();  ///< its end, on the last of them [m]
  Vec2 hip = Vec2::Zero();    ///< with all joints at zero [m]
  double x = 0.0;             ///< of where the end is to be [m]
  double cap = 0.0;           ///< radius about its end, of which the lowest point touches [m]
  double length = 0.0;        ///< [m]
  double knee = 1.0;          ///< +1: behind the hip rather than before it, -1: the other way
  /// What a knee on the wrong side costs against an end that is off [-]: small, it tells two knees
  /// apart that both bring the end there; of loops it has to be there.
  double knee_weight = 1e-3;
};

using Pose = std::map<std::string, double>;

/// Where it touches the floor that is below it.
Vec2 end_at(const Draft& draft, const Leg& leg, const Pose& joints) {
  return point_at(draft, leg.bodies.back(), leg.point, joints) - Vec2(0.0, leg.cap);
}

/// The lowest point of what a foot is.
double height_of(const Draft& draft, const DraftFoot& foot) {
  return point_at(draft, foot.body, foot.point, draft.rest).y() - foot.cap;
}

Leg leg_of(const Draft& draft, const DraftFoot& foot) {
  Leg leg;
  leg.point = foot.point;
  for (int b = foot.body; b > 0; b = draft.reduction.bodies[b].parent)
    leg.bodies.insert(leg.bodies.begin(), b);
  leg.hip = pose_of(draft.reduction, leg.bodies.front()).head<2>();
  leg.x = leg.hip.x();
  leg.cap = foot.cap;
  leg.length = foot.point.norm() + foot.cap;
  for (std::size_t i = 1; i < leg.bodies.size(); ++i)
    leg.length += draft.reduction.bodies[leg.bodies[i]].origin.norm();
  return leg;
}

Bounds range_of(const Draft& draft, int body) {
  const Bounds& r = draft.reduction.ranges[body];
  // a finite one may lie anywhere, as its file has the joint's zero
  return {std::isfinite(r.lower) ? r.lower : std::min(-M_PI, r.upper - 2.0 * M_PI),
          std::isfinite(r.upper) ? r.upper : std::max(M_PI, r.lower + 2.0 * M_PI)};
}

/// How far a pose is from the one wanted [m]: the foot below the hip at `height`, and among two
/// knees the one behind, as most quadrupeds have it, or as the leg states.
double miss(const Draft& draft, const Leg& leg, double height, const Pose& joints) {
  const Vec2 off = end_at(draft, leg, joints) - Vec2(leg.x, height);
  const bool bent = leg.bodies.size() > 1;
  const double knee = bent ? pose_of(draft.reduction, leg.bodies[1], joints)[0] - leg.hip.x() : 0.0;
  return off.norm() + leg.knee_weight * std::max(0.0, leg.knee * knee);
}

/// The pose of two joints on a grid that closes in on the best.
void bend(const Draft& draft, const Leg& leg, double height, Pose& rest) {
  const std::size_t moving = std::min<std::size_t>(2, leg.bodies.size());
  std::vector<Bounds> window;
  for (std::size_t i = 0; i < moving; ++i) window.push_back(range_of(draft, leg.bodies[i]));

  constexpr int kGrid = 60;
  for (int round = 0; round < 14; ++round) {
    double least = kInfinity;
    Pose best = rest;
    for (int i = 0; i <= kGrid; ++i) {
      for (int k = 0; k <= (moving > 1 ? kGrid : 0); ++k) {
        Pose trial = rest;
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
  const Vec2 v = point_at(draft, loop.a.body, loop.a.point, draft.rest) - a;
  return u.y() * v.x() - u.x() * v.y() > 0.0 ? 1.0 : -1.0;
}

/// A loop's chains brought to one place.
struct Closure {
  Pose pose;
  double apart = kInfinity;  ///< of their ends [m]
};

/// Share of the lower link by which knees are apart: nearer, the pin hardly follows from them [-].
constexpr double kSpread = 0.1;

/// Knees on two sides, so that the loop is neither stretched nor folded.
bool is_closed(const Draft& draft, const DraftLoop& loop, const Closure& found) {
  constexpr double kMeet = 1e-3;  // [m]: poses are found to far less
  const Vec2 a = pose_of(draft.reduction, loop.a.body, found.pose).head<2>();
  const Vec2 b = pose_of(draft.reduction, loop.b.body, found.pose).head<2>();
  return found.apart < kMeet && (a - b).norm() > kSpread * loop.a.point.norm();
}

/// Whether the first chain's knee is before the second's as the file is drawn, or it doesn't tell.
bool is_first_in_front(const Draft& draft, const DraftLoop& loop) {
  return pose_of(draft.reduction, loop.a.body)[0] - pose_of(draft.reduction, loop.b.body)[0] >
         -kSpread * loop.a.point.norm();
}

/// Both chains at a height and `aside` of the middle of their hips [m]: one knee points forward and
/// the other back, as they are drawn where that is possible.
Closure close_at(const Draft& draft, const DraftLoop& loop, double height, double aside) {
  Leg a = leg_of(draft, loop.a);
  Leg b = leg_of(draft, loop.b);
  a.x = b.x = 0.5 * (a.hip.x() + b.hip.x()) + aside;

  a.knee_weight = b.knee_weight = 1.0;
  const double drawn = is_first_in_front(draft, loop) ? -1.0 : 1.0;

  Closure best;
  for (const double front : {drawn, -drawn}) {
    a.knee = front;
    b.knee = -front;
    Closure trial{draft.rest, kInfinity};
    bend(draft, a, height, trial.pose);
    bend(draft, b, height, trial.pose);
    trial.apart = (end_at(draft, a, trial.pose) - end_at(draft, b, trial.pose)).norm();
    if (is_closed(draft, loop, trial)) return trial;
    if (trial.apart < best.apart) best = trial;
  }
  return best;
}

/// A pose that closes a loop, as near as there is one to legs drawn in by a quarter.
Closure close_loop(const Draft& draft, const DraftLoop& loop) {
  const Leg a = leg_of(draft, loop.a);
  const double hips = 0.5 * (a.hip.y() + leg_of(draft, loop.b).hip.y());
  Closure best;
  for (const double aside : {0.0, 0.35, -0.35}) {
    for (const double share : {kDrawnIn, 0.55, 0.9}) {
      const Closure found = close_at(draft, loop, hips - share * a.length, aside * a.length);
      if (is_closed(draft, loop, found)) return found;
      if (found.apart < best.apart) best = found;
    }
  }
  return best;
}

/// A loop that no pose closes isn't one: its chains stand on their own.
void leave_open(Draft& draft, DraftLoop loop, double apart) {
  const auto is_foot = [&](const DraftFoot& foot) { return foot.name == loop.foot.name; };
  const auto at = draft.feet.erase(std::find_if(draft.feet.begin(), draft.feet.end(), is_foot));
  draft.feet.insert(at, loop.ends.begin(), loop.ends.end());
  loop.why_open = fmt::format(
      "no pose was found, within the ranges of the joints, that brings the ends nearer than "
      "{:.2g} m",
      apart);
  draft.missing.push_back(fmt::format(
      "loops.{}: {}: left open after all, with two feet; robot.yaml has the lines for a pin "
      "elsewhere",
      loop.name, loop.why_open));
  draft.open_loops.push_back(loop);
}

/// Closes what can be closed, and says how high the lowest foot of a five-bar then is.
double close_loops(Draft& draft) {
  double height = -kInfinity;
  std::vector<DraftLoop> closed;
  for (const DraftLoop& loop : draft.loops) {
    const Closure found = close_loop(draft, loop);
    if (!is_closed(draft, loop, found)) {
      leave_open(draft, loop, found.apart);
      continue;
    }
    draft.missing.push_back(fmt::format(
        "loops.{}: two alike chains begin at one hip: taken as a five-bar. Its pin: {}. The file "
        "says nothing of it (--open leaves them apart)",
        loop.name, loop.source));
    draft.rest = found.pose;
    height = std::max(height, height_of(draft, loop.foot));
    closed.push_back(loop);
  }
  draft.loops = closed;
  return height;
}

/// The pin higher or lower, until the foot that is below it is at `height`.
void lift_loop(Draft& draft, const DraftLoop& loop, double height) {
  constexpr int kRounds = 4;  // the foot follows the pin nearly one to one
  for (int round = 0; round < kRounds; ++round) {
    const Vec2 pin = point_at(draft, loop.a.body, loop.a.point, draft.rest);
    const double off = height - height_of(draft, loop.foot);
    if (std::abs(off) < 1e-6) return;
    const double middle = 0.5 * (leg_of(draft, loop.a).hip.x() + leg_of(draft, loop.b).hip.x());
    const Closure found = close_at(draft, loop, pin.y() + off, pin.x() - middle);
    if (!is_closed(draft, loop, found)) return;
    draft.rest = found.pose;
  }
}

/// The pose with all feet at the height of the leg that reaches least far.
void stand(Draft& draft) {
  double height = close_loops(draft);
  std::vector<Leg> legs;
  for (const DraftFoot& foot : draft.feet) {
    const bool in_loop = std::any_of(draft.loops.begin(), draft.loops.end(),
                                     [&](const auto& l) { return l.foot.name == foot.name; });
    if (in_loop) continue;
    legs.push_back(leg_of(draft, foot));
    height = std::max(height, legs.back().hip.y() - kDrawnIn * legs.back().length);
  }

  for (const DraftLoop& loop : draft.loops) lift_loop(draft, loop, height);
  for (const Leg& leg : legs) bend(draft, leg, height, draft.rest);
}

/// Whether all legs stand in a pose.
bool stands(const Draft& draft, const Pose& pose) {
  return std::all_of(draft.feet.begin(), draft.feet.end(), [&](const DraftFoot& foot) {
    const Leg leg = leg_of(draft, foot);
    return leg.hip.y() - end_at(draft, leg, pose).y() > kLeast * leg.length;
  });
}

/// Feet that are caps are their lowest points from here on, fixed to their links.
void settle_caps(Draft& draft) {
  for (DraftFoot& foot : draft.feet) {
    if (foot.cap == 0.0) continue;
    const double phi = pose_of(draft.reduction, foot.body, draft.rest)[2];
    foot.point += foot.cap * Vec2(std::sin(phi), -std::cos(phi));
    draft.notes.push_back(fmt::format(
        "'{}' is the lowest point, at rest, of a round end of {:.3g} m radius: where the link "
        "turns, a plan's foot stays at that point of it, and doesn't roll",
        foot.name, foot.cap));
    foot.cap = 0.0;
  }
}

/// What a file states of one joint of a pair may be out of the range that both have.
void keep_in_ranges(Draft& draft) {
  constexpr double kRounding = 1e-9;  // [rad or m]: of grids that reach from end to end
  for (int b = 1; b < count_of(draft.reduction.bodies); ++b) {
    const std::string& joint = draft.reduction.bodies[b].joint;
    const Bounds& range = draft.reduction.ranges[b];
    double& value = draft.rest.at(joint);
    const double within = std::clamp(value, range.lower, range.upper);
    if (std::abs(value - within) > kRounding)
      draft.notes.push_back(
          fmt::format("pose of '{}': {:.4g} is out of its range, {:.4g} to {:.4g}: its end is "
                      "taken",
                      joint, value, range.lower, range.upper));
    value = within;
  }
}

/// The pose with what is stated of joints, in space or planar, in its place; whether anything is.
bool take(const Draft& draft, const Pose& stated, Pose& pose) {
  bool any = false;
  for (const auto& [joint, value] : stated) {
    for (const DraftJoint& known : joints_of(draft)) {
      const bool spatial = std::any_of(known.spatial.begin(), known.spatial.end(),
                                       [&](int j) { return draft.tree.joints[j].name == joint; });
      if (known.name != joint && !spatial) continue;
      pose[known.name] = value;
      any = true;
    }
  }
  return any;
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

  stand(draft);
  for (DraftLoop& loop : draft.loops) loop.branch = branch_at_rest(draft, loop);

  Pose of_file = draft.rest;
  const bool stated = take(draft, options.file_pose, of_file);
  if (stated && stands(draft, of_file)) {
    draft.rest = of_file;
    draft.rest_stated = true;
  } else if (stated) {
    draft.notes.push_back(
        "the file's pose is none to stand in, a foot less than 30 % of its leg below its hip: legs "
        "are drawn in instead (--pose states another)");
  }
  if (take(draft, options.pose, draft.rest)) draft.rest_stated = true;
  keep_in_ranges(draft);
  settle_caps(draft);
}

}  // namespace jaculus::model
