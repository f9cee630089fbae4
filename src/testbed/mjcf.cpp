// The robot as MuJoCo's model text. What each part means is in mjcf.h.

#include "testbed/mjcf.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "testbed/additions.h"
#include "testbed/joint_changes.h"
#include "testbed/limbs.h"
#include "testbed/parts.h"

namespace jaculus::testbed {
namespace {

constexpr double kRotorMass =
    1e-6;  ///< of the motor's side of a joint with play: MuJoCo wants every body to have some [kg]
constexpr double kRotorInertia = 1e-9;  ///< [kg m^2]
constexpr double kPointRadius = 1e-6;   ///< of a toe that is a point [m]

std::string numbers(const model::Vec3& v) {
  return fmt::format("{:.17g} {:.17g} {:.17g}", v.x(), v.y(), v.z());
}

std::string inertial(const Part& part) {
  const model::Mat3& i = part.inertia;
  return fmt::format(
      "<inertial pos=\"{}\" mass=\"{:.17g}\" fullinertia=\"{:.17g} {:.17g} {:.17g} {:.17g} {:.17g} "
      "{:.17g}\"/>\n",
      numbers(part.com), part.mass, i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2));
}

class Writer {
 public:
  Writer(const RobotFiles& files, const Changes& changes, const Setting& setting,
         const Numerics& numerics)
      : files_(files),
        tree_(files.tree),
        changes_(changes),
        setting_(setting),
        numerics_(numerics) {
    hinges_ = shaft_hinges(files, changes);
    limbs_ = limbs_of_links(files.tree, files.drag_links, files.toes, files.pins);
    const auto rear = [](const Toe& toe) { return toe.limb == Limb::rear_leg; };
    bent_toe_ = std::find_if(files.toes.begin(), files.toes.end(), rear) - files.toes.begin();
    if (files.drag_links.empty()) return;
    tail_link_ = files.drag_links.front();
    const Vec2& along = files.drags.front().direction;
    along_ = model::Vec3(along.x(), 0.0, along.y());
  }

  std::string text() {
    head();
    out_ += "<worldbody>\n";
    if (setting_.floor) floor();
    base();
    out_ += "</worldbody>\n";
    constraints();
    stops_behind_play();
    return out_ + "</mujoco>\n";
  }

 private:
  void head() {
    // Motion capture is levelled on the floor, so a floor that tilts is gravity that leans.
    // So is a base that is held aslant.
    const bool held = setting_.base_fixed || !files_.floating;
    const double tilt =
        (setting_.floor ? changes_.outside.floor_tilt : 0.0) + (held ? changes_.base_tilt : 0.0);
    out_ = fmt::format(
        "<mujoco model=\"{}\">\n<compiler angle=\"radian\" inertiafromgeom=\"false\" "
        "balanceinertia=\"false\" "
        "boundmass=\"0\" boundinertia=\"0\"/>\n"
        "<option timestep=\"{:.17g}\" integrator=\"{}\" cone=\"elliptic\" solver=\"Newton\" "
        "iterations=\"100\" "
        "tolerance=\"1e-14\" impratio=\"{:.17g}\" gravity=\"{:.17g} 0 {:.17g}\"/>\n<option><flag "
        "refsafe=\"disable\"/></option>\n<size nconmax=\"64\" njmax=\"256\"/>\n",
        files_.name, numerics_.step, numerics_.runge_kutta ? "RK4" : "Euler",
        numerics_.friction_impedance, files_.gravity * std::sin(tilt),
        -files_.gravity * std::cos(tilt));
  }

  /// solref and solimp of everything that is rigid.
  [[nodiscard]] std::string rigid() const {
    return fmt::format("solref=\"{:.17g} 1\" solimp=\"{:.17g} {:.17g} 0.001\"",
                       numerics_.stiffness_steps * numerics_.step, numerics_.impedance,
                       numerics_.impedance);
  }

  void floor() {
    if (std::isinf(changes_.floor_stiffness)) {
      out_ +=
          "<geom name=\"floor\" type=\"plane\" size=\"0 0 1\" contype=\"0\" conaffinity=\"0\"/>\n";
      return;
    }

    // A plate under each toe, on a spring of its own.
    double mass = 0.0;
    for (const model::SpatialLink& link : tree_.links) mass += link.mass;
    const double share = mass / std::max(1.0, static_cast<double>(files_.toes.size()));
    const double k = changes_.floor_stiffness;
    for (std::size_t i = 0; i < files_.toes.size(); ++i) {
      out_ += fmt::format(
          "<body name=\"plate_{0}\"><inertial pos=\"0 0 0\" mass=\"{1}\" diaginertia=\"1e-3 1e-3 "
          "1e-3\"/>"
          "<joint name=\"plate_{0}\" type=\"slide\" axis=\"0 0 1\" stiffness=\"{2:.17g}\" "
          "damping=\"{3:.17g}\"/>"
          "<geom name=\"floor_{0}\" type=\"box\" size=\"20 1 0.5\" pos=\"0 0 -0.5\" contype=\"0\" "
          "conaffinity=\"0\"/>"
          "</body>\n",
          i, kPlateMass, k, 2.0 * changes_.floor_damping_ratio * std::sqrt(k * share));
    }
  }

  void base() {
    const model::SpatialLink& root = tree_.links[tree_.root];
    const bool fixed = setting_.base_fixed || !files_.floating;
    const bool sways = fixed && changes_.outside.mount_compliance > 0.0;
    if (sways) out_ += mount_below(files_, changes_);
    out_ += fmt::format("<body name=\"{}\">\n", root.name);
    if (!fixed) {
      out_ +=
          "<joint name=\"base_x\" type=\"slide\" axis=\"1 0 0\"/><joint name=\"base_z\" "
          "type=\"slide\" axis=\"0 0 1\"/>"
          "<joint name=\"base_pitch\" type=\"hinge\" axis=\"0 1 0\"/>\n";
    }
    Part whole = composite(tree_, tree_.root);
    whole.com += model::Vec3(changes_.com_shift.x(), 0.0, changes_.com_shift.y());
    whole.inertia(1, 1) *= changes_.base_inertia;
    Part part = root.mass > 0.0 ? own_share(tree_, tree_.root, whole) : Part{};
    part.mass -= changes_.outside.loose_mass;
    if (part.mass > 0.0) out_ += inertial(part);
    out_ += additions_to_base(changes_);
    children(tree_.root, model::Vec3::Zero());
    out_ += sways ? "</body>\n</body>\n" : "</body>\n";
  }

  void children(int link, const model::Vec3& shift) {
    for (const model::SpatialJoint& joint : tree_.joints) {
      if (joint.parent == link) child(joint, shift);
    }
  }

  [[nodiscard]] const Drive* drive_of(const std::string& joint) const {
    for (const Drive& drive : files_.drives) {
      if (drive.joint == joint) return &drive;
    }
    return nullptr;
  }

  [[nodiscard]] double play_behind(const Drive* drive) const {
    return drive == nullptr ? 0.0 : play_of(changes_, *drive);
  }

  /// One body on its joint, with what lies between the motor and it. `shift`: origin of the
  /// parent's frame in the body written last.
  void child(const model::SpatialJoint& joint, const model::Vec3& shift) {
    const model::SpatialLink& link = tree_.links[joint.child];
    const Eigen::Quaterniond turn(joint.rotation);
    const std::string place =
        fmt::format("pos=\"{}\" quat=\"{:.17g} {:.17g} {:.17g} {:.17g}\"",
                    numbers(joint.origin + shift), turn.w(), turn.x(), turn.y(), turn.z());
    const Drive* drive = drive_of(joint.name);
    const double play = play_behind(drive);
    const bool tail = link.name == tail_link_;
    int open = 1;
    if (play > 0.0) {
      out_ += fmt::format("<body name=\"{}_motor_side\" {}>\n{}", joint.name, place,
                          motor_joint(joint, drive));
      out_ += inertial({kRotorMass, model::Vec3::Zero(), kRotorInertia * model::Mat3::Identity()});
      out_ += fmt::format("<body name=\"{}\">\n", link.name);
      out_ += fmt::format(
          "<joint name=\"{0}_play\" type=\"hinge\" axis=\"{1}\" limited=\"true\" range=\"{2:.17g} "
          "{3:.17g}\" "
          "solreflimit=\"0.001 0.5\" solimplimit=\"0.999 0.999 0.001\"/>\n",
          joint.name, numbers(joint.axis), -0.5 * play, 0.5 * play);
      open = 2;
    } else {
      out_ += fmt::format("<body name=\"{}\" {}>\n", link.name, place);
      if (joint.kind != model::SpatialJointKind::fixed) out_ += motor_joint(joint, drive);
    }

    if (tail && !hinges_.empty()) {
      open += bent_shaft(joint, link);
    } else {
      rigid_link(joint.child, tail);
    }

    for (int i = 0; i < open; ++i) out_ += "</body>\n";
  }

  [[nodiscard]] bool stops_at(const model::SpatialJoint& joint) const {
    return setting_.stops && std::isfinite(joint.range.lower) && std::isfinite(joint.range.upper);
  }

  /// Of one stiffness whatever the damping: time constant 1/(zeta w), at most what MuJoCo takes at
  /// the finest step.
  [[nodiscard]] std::string stop_of(const model::SpatialJoint& joint,
                                    const std::string& what) const {
    const double ratio = damping_ratio_of_restitution(changes_.stop_restitution);
    return fmt::format(
        " limited=\"true\" range=\"{0:.17g} {1:.17g}\" solref{4}=\"{2:.17g} {3:.17g}\" "
        "solimp{4}=\"0.9999 0.9999 "
        "0.001\"",
        joint.range.lower, joint.range.upper, 6.0 * numerics_.step * kStopStep / ratio, ratio,
        what);
  }

  /// Where there is play the link meets the stop, so that the limit is on motor and play together.
  void stops_behind_play() {
    out_ += "<tendon>\n";
    for (const model::SpatialJoint& joint : tree_.joints) {
      if (!stops_at(joint) || play_behind(drive_of(joint.name)) == 0.0) continue;
      out_ += fmt::format(
          "<fixed name=\"{0}_stop\"{1}><joint joint=\"{0}\" coef=\"1\"/>"
          "<joint joint=\"{0}_play\" coef=\"1\"/></fixed>\n",
          joint.name, stop_of(joint, "limit"));
    }
    out_ += "</tendon>\n";
  }

  std::string motor_joint(const model::SpatialJoint& joint, const Drive* drive) {
    double armature = 0.0, viscous = 0.0;
    if (drive != nullptr) {
      const double gear = drive->motor.gear, added = added_rotor_inertia(changes_, *drive);
      armature = gear * gear * (drive->motor.rotor_inertia + added);
      viscous = viscous_friction(changes_, *drive);
    }
    std::string range;
    if (stops_at(joint) && play_behind(drive) == 0.0) range = stop_of(joint, "limit");
    const bool dry = drive != nullptr && rubs(changes_, *drive);
    return fmt::format(
        "<joint name=\"{}\" type=\"{}\" axis=\"{}\" armature=\"{:.17g}\" damping=\"{:.17g}\" "
        "frictionloss=\"{}\" solreffriction=\"0.001 1\" solimpfriction=\"0.999 0.999 0.001\"{}/>\n",
        joint.name, joint.kind == model::SpatialJointKind::prismatic ? "slide" : "hinge",
        numbers(joint.axis), armature, viscous, dry ? "1e-6" : "0", range);
  }

  /// The rest of a link that is one piece: mass, toes, pins, and what hangs on it.
  void rigid_link(int index, bool tail) {
    const model::SpatialLink& link = tree_.links[index];
    Part part{link.mass, link.com, link.inertia};
    if (tail) {
      Part whole = composite(tree_, index);
      whole.inertia(1, 1) *= changes_.tail_inertia;
      part = own_share(tree_, index, whole);
    }
    if (limbs_[index] == Limb::tail) {
      part.mass *= changes_.tail_mass;
      part.inertia *= changes_.tail_mass;
    } else {
      part.inertia *= leg_factor(index);
    }
    const bool loaded = changes_.outside.sliding_load > 0.0 && index == loaded_link(files_);
    if (loaded) part.mass -= changes_.outside.sliding_load;
    if (part.mass > 0.0) out_ += inertial(part);
    if (loaded) out_ += load_on_link(files_, changes_);
    marks(link.name);
    children(index, model::Vec3::Zero());
  }

  /// Pieces of the shaft, each a body on a hinge; returns how many bodies it left open. The first
  /// piece turns with the motor.
  int bent_shaft(const model::SpatialJoint& joint, const model::SpatialLink& link) {
    const double length = 2.0 * link.com.dot(along_);  // a uniform rod from the pivot
    const double factor = changes_.tail_mass;

    const double stiffness = hinge_stiffness(files_, changes_, hinges_);
    double inertia = link.inertia(1, 1) + link.mass * link.com.squaredNorm();
    for (const model::SpatialJoint& below : tree_.joints) {
      if (below.parent == joint.child)
        inertia += tree_.links[below.child].mass * below.origin.squaredNorm();
    }

    // All hinges together, seen as one at the root, have K and K c/k.
    const double damping = 2.0 * changes_.shaft_damping_ratio *
                           std::sqrt(inertia / changes_.shaft_stiffness) * stiffness;
    double from = 0.0;
    int opened = 0;
    for (std::size_t i = 0; i <= hinges_.size(); ++i) {
      const double to = i < hinges_.size() ? hinges_[i] : length;
      const double piece = to - from;
      Part part;
      part.mass = factor * link.mass * piece / length;
      part.com = 0.5 * piece * along_;
      const double turning = part.mass * piece * piece / 12.0;
      part.inertia.diagonal() << turning, turning, 0.01 * turning;
      if (i > 0) {
        out_ += fmt::format(
            "<body name=\"tail_piece_{0}\" pos=\"{1}\">\n<joint name=\"tail_bend_{0}\" "
            "type=\"hinge\" axis=\"{2}\" stiffness=\"{3:.17g}\" damping=\"{4:.17g}\"/>\n",
            i, numbers((i == 1 ? from : from - hinges_[i - 2]) * along_), numbers(joint.axis),
            stiffness, damping);
        ++opened;
      }
      out_ += inertial(part);
      if (i < hinges_.size()) from = to;
    }

    children(joint.child, -hinges_.back() * along_);
    return opened;
  }

  /// Links of legs are those that move; what is fixed to the base keeps its mass.
  [[nodiscard]] double leg_factor(int index) const {
    for (int i = index; i >= 0;) {
      const model::SpatialLink& link = tree_.links[i];
      if (link.joint < 0) return 1.0;
      const model::SpatialJoint& joint = tree_.joints[link.joint];
      if (joint.kind != model::SpatialJointKind::fixed) return changes_.leg_inertia;
      i = joint.parent;
    }
    return 1.0;
  }

  void marks(const std::string& link) {
    for (std::size_t i = 0; i < files_.pins.size(); ++i) {
      const Pin& pin = files_.pins[i];
      if (pin.link_a == link)
        out_ += fmt::format("<site name=\"pin_{}_a\" pos=\"{}\"/>\n", i, numbers(pin.point_a));
      if (pin.link_b == link)
        out_ += fmt::format("<site name=\"pin_{}_b\" pos=\"{}\"/>\n", i, numbers(pin.point_b));
    }
    const double radius = std::max(changes_.toe_radius, kPointRadius);
    for (int i = 0; i < count_of(files_.toes); ++i) {
      Toe toe = files_.toes[i];
      if (toe.link != link) continue;
      if (i == bent_toe_) toe.point += changes_.outside.bent_link * away_from_pivot(toe);
      out_ += fmt::format(
          "<geom name=\"toe_{}\" type=\"sphere\" size=\"{:.17g}\" pos=\"{}\" contype=\"0\" "
          "conaffinity=\"0\"/>\n",
          i, radius, numbers(toe.point));
    }
  }

  /// Along a straight link, from its joint to the toe: the axis of its frame nearest to that.
  static model::Vec3 away_from_pivot(const Toe& toe) {
    const bool upright = std::abs(toe.point.z()) >= std::abs(toe.point.x());
    const double reach = upright ? toe.point.z() : toe.point.x();
    const double sign = reach < 0.0 ? -1.0 : 1.0;
    return upright ? model::Vec3(0.0, 0.0, sign) : model::Vec3(sign, 0.0, 0.0);
  }

  void constraints() {
    if (!files_.pins.empty()) {
      out_ += "<equality>\n";
      for (const Pin& pin : files_.pins) {
        out_ += fmt::format("<connect body1=\"{}\" body2=\"{}\" anchor=\"{}\" {}/>\n", pin.link_a,
                            pin.link_b, numbers(pin.point_a), rigid());
      }
      out_ += "</equality>\n";
    }

    if (!setting_.floor || files_.toes.empty()) return;
    const double friction = files_.friction * changes_.floor_friction_scale;
    const bool plates = std::isfinite(changes_.floor_stiffness);
    out_ += "<contact>\n";
    for (std::size_t i = 0; i < files_.toes.size(); ++i) {
      out_ += fmt::format(
          "<pair geom1=\"toe_{0}\" geom2=\"floor{1}\" condim=\"3\" friction=\"{2:.17g} {2:.17g}\" "
          "{3}/>\n",
          i, plates ? fmt::format("_{}", i) : "", friction, rigid());
    }

    out_ += "</contact>\n";
  }

  const RobotFiles& files_;
  const model::SpatialTree& tree_;
  const Changes& changes_;
  const Setting& setting_;
  const Numerics& numerics_;
  std::vector<double> hinges_;
  std::vector<Limb> limbs_;      ///< of every link
  std::ptrdiff_t bent_toe_ = 0;  ///< left one of the rear feet
  std::string tail_link_;
  model::Vec3 along_ = model::Vec3::UnitZ();  ///< the tail, in its own frame
  std::string out_;
};

}  // namespace

std::string mjcf(const RobotFiles& files, const Changes& changes, const Setting& setting,
                 const Numerics& numerics) {
  return Writer(files, changes, setting, numerics).text();
}

}  // namespace jaculus::testbed
