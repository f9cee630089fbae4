// The proposal as robot.yaml, with where each line comes from.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "model/propose/draft.h"

namespace jaculus::model {
namespace {

using yaml::quoted;

std::string number(double value) {
  return fmt::format("{:.6g}", std::abs(value) < 1e-9 ? 0.0 : value);
}

/// The same of a joint's value, with all digits where rounding would leave its range.
std::string number_within(double value, const Bounds& range) {
  const std::string rounded = number(value);
  return range.contains(std::stod(rounded)) ? rounded : fmt::format("{}", value);
}

/// Of motors whose speed nobody stated, for plans; quadrupeds that state one turn their joints at
/// 20 to 50 rad/s.
constexpr double kAssumedSpeed = 30.0;

std::string head(const Draft& draft, const Dropped& d) {
  std::string text = fmt::format(
      "# Proposed by `jaculus robot import` from {}. Lines that begin with `# fill in` are what "
      "the\n"
      "# file doesn't say.\n"
      "#\n"
      "# Kept in the plane: {:.6g} kg, pitch inertia {:.6g} kg m^2 about the centre of mass.\n"
      "# Dropped: sideways places of {:.4g} kg ({:.4g} kg m^2 of roll and yaw inertia), a centre "
      "of\n"
      "# mass {}, products of inertia of pitch with roll and yaw of {:.2g} %.\n",
      draft.tree.file.filename().string(), d.mass, d.pitch_inertia, d.mass_off_plane,
      d.inertia_moved, d.com_sideways(), 1e2 * d.coupling);
  for (const std::string& note : draft.notes) text += "# " + note + "\n";
  return text + "format: jaculus-robot/1\n";
}

/// The least of the feet's; NaN where the file doesn't have it for each, with why where it says.
Surface feet_surface(const Draft& draft) {
  Surface least{"", kInfinity, ""};
  for (const DraftFoot& foot : draft.feet) {
    if (std::isnan(foot.surface.friction)) return foot.surface;
    if (foot.surface.friction < least.friction) least = foot.surface;
  }
  return least;
}

std::string frame(const Draft& draft) {
  std::string text;
  if (draft.forward != "+x" || draft.up != "+z")
    text += fmt::format("axes: {{forward: {}, up: {}}}\n", draft.forward, draft.up);
  if (!draft.base_link.empty()) text += fmt::format("base_link: {}\n", quoted(draft.base_link));
  text += fmt::format("base: {}\n", draft.floating ? "floating" : "fixed");
  if (draft.horizontal) text += "gravity: 0\n";
  if (draft.feet.empty()) return text;
  const Surface feet = feet_surface(draft);
  return text +
         (std::isnan(feet.friction)
              ? "friction: 0.8   # fill in: rubber on a dry floor is assumed, 0.6 to 1\n"
              : fmt::format("friction: {}   # of the feet, by the file{}{}\n",
                            number(feet.friction), feet.source.empty() ? "" : ": ", feet.source));
}

std::string held(const Draft& draft) {
  if (draft.held.empty()) return "";
  std::string text = "\nfixed_joints:\n";
  for (const HeldBecause& h : draft.held)
    text += fmt::format("  {}: {}   # {}\n", quoted(h.held.joint), number(h.held.value), h.reason);
  return text;
}

std::string pairs(const Draft& draft) {
  if (draft.pairs.empty()) return "";
  std::string text = "\n# Left and right move alike: [left, right].\npairs:\n  joints:\n";
  for (const PairSpec& pair : draft.pairs)
    text +=
        fmt::format("    {}: [{}, {}]\n", quoted(pair.name), quoted(pair.left), quoted(pair.right));
  return text;
}

std::string feet(const Draft& draft) {
  if (draft.feet.empty()) return "";
  std::string text = "\nfeet:\n";
  for (const DraftFoot& foot : draft.feet)
    text += fmt::format("  {}: {{link: {}, point: [{}, {}]}}   # {}{}\n", quoted(foot.name),
                        quoted(foot.link), number(foot.point.x()), number(foot.point.y()),
                        foot.guessed ? "fill in: " : "", foot.source);
  return text;
}

/// A line of `loops`, each of its own lines begun by `margin`.
std::string loop_line(const Draft& draft, const DraftLoop& loop, const std::string& margin,
                      const std::string& branch) {
  const auto joint = [&](const DraftFoot& end) {
    return quoted(draft.reduction.bodies[end.body].joint);
  };
  return fmt::format(
      "{0}  {1}:\n{0}    {{link_a: {2}, point_a: [{3}, {4}], link_b: {5}, point_b: [{6}, {7}],\n"
      "{0}     dependent: [{8}, {9}], branch: {10}}}\n",
      margin, quoted(loop.name), quoted(loop.a.link), number(loop.a.point.x()),
      number(loop.a.point.y()), quoted(loop.b.link), number(loop.b.point.x()),
      number(loop.b.point.y()), joint(loop.a), joint(loop.b), branch);
}

std::string loops(const Draft& draft) {
  std::string text;
  if (!draft.loops.empty())
    text += "\n# fill in: where the pins are; a URDF has no place for that.\nloops:\n";
  for (const DraftLoop& loop : draft.loops)
    text += fmt::format("  # {}\n{}", loop.source,
                        loop_line(draft, loop, "", loop.branch > 0.0 ? "positive" : "negative"));

  for (const DraftLoop& loop : draft.open_loops) {
    text += fmt::format(
        "\n# fill in if a pin joins these two chains; left open: {}.\n# point_a, point_b: {}\n",
        loop.why_open, loop.source);
    if (draft.loops.empty() && &loop == &draft.open_loops.front()) text += "# loops:\n";
    text += loop_line(draft, loop, "# ", "...");
  }
  return text;
}

/// Legs with a loop in their own terms.
std::string coordinates(const Draft& draft) {
  std::string text;
  for (const DraftLoop& loop : draft.loops) {
    const std::optional<LegCoordinates> leg = leg_coordinates(draft, loop);
    if (!leg) continue;
    const auto line = [&](const char* what, const std::array<double, 2>& of, const Bounds& range) {
      const std::string name = loop.name.substr(0, loop.name.rfind("_leg")) + what;
      return fmt::format("  {}: {{of: {{{}: {}, {}: {}}}, range: [{:.4g}, {:.4g}]}}", quoted(name),
                         quoted(leg->joints[0]), number(of[0]), quoted(leg->joints[1]),
                         number(of[1]), range.lower, range.upper);
    };
    text += line("_extension", leg->stretch, leg->extension) + "\n" +
            line("_angle", leg->swing, leg->angle) + "\n";
  }
  if (text.empty()) return "";
  return "\n# Legs in their own terms: how far stretched, short of where the lower links fold or\n"
         "# stretch out, and how far swung to the rear, 90 degrees about rest.\ncoordinates:\n" +
         text;
}

/// Whether a joint follows from a loop.
bool is_dependent(const Draft& draft, const DraftJoint& joint) {
  for (const DraftLoop& loop : draft.loops)
    if (joint.body == loop.a.body || joint.body == loop.b.body) return true;
  return false;
}

/// What a file says of the motor at a joint.
struct StatedMotor {
  std::string name;           ///< quoted
  std::string keys;           ///< speed_limit, rotor_inertia, frictions
  double effort = kInfinity;  ///< [N m or N]
  bool fast_known = true;     ///< or slides, where no speed is assumed
};

/// Of a pair, the mean: both together rub as they do in the file.
double mean_of_sides(const Draft& draft, const DraftJoint& joint, double SpatialJoint::*value) {
  double sum = 0.0;
  for (const int j : joint.spatial) sum += draft.tree.joints[j].*value;
  return sum / static_cast<double>(joint.spatial.size());
}

StatedMotor stated_motor(const Draft& draft, const DraftJoint& joint) {
  const SpatialJoint& first = draft.tree.joints[joint.spatial.front()];
  const bool slides = first.kind == SpatialJointKind::prismatic;
  StatedMotor motor{quoted(joint.name), "", first.effort, std::isfinite(first.velocity) || slides};
  if (std::isfinite(first.velocity)) {
    motor.keys = fmt::format(", speed_limit: {}", number(first.velocity));
  } else if (!slides) {
    motor.keys = fmt::format(", speed_limit: {}", number(kAssumedSpeed));
  }
  const auto armature = draft.armature.find(first.name);
  if (armature != draft.armature.end() && !slides)
    motor.keys += fmt::format(", rotor_inertia: {}", number(armature->second));
  const double damping = mean_of_sides(draft, joint, &SpatialJoint::damping);
  const double friction = mean_of_sides(draft, joint, &SpatialJoint::friction);
  if (damping > 0.0) motor.keys += fmt::format(", viscous_friction: {}", number(damping));
  if (friction > 0.0) motor.keys += fmt::format(", dry_friction: {}", number(friction));
  return motor;
}

/// What robot.yaml doesn't have of the file's friction: it is that of motors alone, one of a pair.
void note_friction(Draft& draft, const DraftJoint& joint, bool driven) {
  const SpatialJoint& first = draft.tree.joints[joint.spatial.front()];
  for (const int j : joint.spatial) {
    const SpatialJoint& side = draft.tree.joints[j];
    const bool same = side.damping == first.damping && side.friction == first.friction;
    const bool none = side.damping == 0.0 && side.friction == 0.0;
    if (driven && !same) {
      draft.notes.push_back(fmt::format(
          "'{}' and '{}' differ in damping, {:.4g} and {:.4g}, or friction, {:.4g} and {:.4g} "
          "(SI): their mean counts",
          first.name, side.name, first.damping, side.damping, first.friction, side.friction));
    }
    if (!driven && !none) {
      draft.notes.push_back(fmt::format(
          "'{}': damping {:.4g} and friction {:.4g} (SI) are left out: no motor is assumed there; "
          "effects simulate them",
          side.name, side.damping, side.friction));
    }
  }
}

/// Of joints that only springs hold, as of spines and tails.
constexpr const char* kLoose =
    "; no motor is assumed there, so that they hang loose (--hold passive holds them)";

/// Files state an effort for joints that motors drive; where some have one, the others are passive.
std::string motors(Draft& draft) {
  bool any = false;
  const std::vector<DraftJoint> joints = joints_of(draft);
  for (const DraftJoint& joint : joints)
    any = any || std::isfinite(stated_motor(draft, joint).effort);

  std::string text, unknown, unknown_speed;
  const auto list = [](std::string& names, const std::string& name) {
    names += (names.empty() ? "" : ", ") + name;
  };
  for (const DraftJoint& joint : joints) {
    const StatedMotor motor = stated_motor(draft, joint);
    const bool known = std::isfinite(motor.effort);
    note_friction(draft, joint, !is_dependent(draft, joint) && (known || !any));
    if (is_dependent(draft, joint)) continue;
    if (!known) list(unknown, joint.name);
    if (!motor.fast_known && known == any) list(unknown_speed, joint.name);

    const std::string fill =
        known ? (motor.fast_known ? "" : "   # fill in speed_limit")
              : fmt::format("   # fill in torque_limit{}", motor.fast_known ? "" : ", speed_limit");
    text += known ? fmt::format("  {}: {{kind: ideal, torque_limit: {}{}}}{}\n", motor.name,
                                number(motor.effort), motor.keys, fill)
            : any ? fmt::format(
                        "  # fill in if a motor drives it: {}: {{kind: ideal, torque_limit: "
                        "...{}}}\n",
                        motor.name, motor.keys)
                  : fmt::format("  {}: {{kind: ideal{}}}{}\n", motor.name, motor.keys, fill);
  }

  if (!unknown.empty())
    draft.missing.push_back(fmt::format("motors: the file states no largest torque of {}{}",
                                        unknown, any ? kLoose : ""));
  if (!unknown_speed.empty())
    draft.missing.push_back(fmt::format(
        "motors: the file states no speed of {}; plans with motor_limits keep below {:.4g} rad/s",
        unknown_speed, kAssumedSpeed));
  const bool none = text.find("\n  \"") == std::string::npos && !text.starts_with("  \"");
  return text.empty()
             ? ""
             : fmt::format("\n# Torques at the joint, of one motor of a pair.\n{}motors:{}\n{}",
                           none ? "# " : "", "", text);
}

Bounds range_of_joint(const Draft& draft, const std::string& joint) {
  for (int b = 1; b < count_of(draft.reduction.bodies); ++b)
    if (draft.reduction.bodies[b].joint == joint) return draft.reduction.ranges[b];
  return {};
}

std::string rest(const Draft& draft, const std::string& motors) {
  std::string text;
  for (const auto& [joint, value] : draft.rest) {
    // rest_pose is of joints with motors
    if (motors.find("\n  " + quoted(joint) + ":") == std::string::npos) continue;
    text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", quoted(joint),
                        number_within(value, range_of_joint(draft, joint)));
  }
  if (text.empty()) return "";
  std::string origin = draft.feet.empty() ? "Joints at zero, or at the nearest that they may have."
                                          : "Feet below the hips, legs drawn in to 75 %.";
  if (draft.rest_stated) origin = "As stated; other joints: " + origin;
  return fmt::format("\n# {}\nrest_pose: {{{}}}\n", origin, text);
}

}  // namespace

std::string write_proposal(Draft& draft, const Dropped& dropped) {
  const Surface surface = feet_surface(draft);
  if (!draft.feet.empty() && std::isnan(surface.friction))
    draft.missing.push_back(fmt::format("friction: 0.8, rubber on a dry floor, is assumed{}{}",
                                        surface.source.empty() ? "" : "; the file has ",
                                        surface.source));
  const std::string drives = motors(draft);
  return head(draft, dropped) + frame(draft) + held(draft) + pairs(draft) + loops(draft) +
         coordinates(draft) + feet(draft) + drives + rest(draft, drives);
}

}  // namespace jaculus::model
