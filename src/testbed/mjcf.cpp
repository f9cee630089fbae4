// The shaft. Its flexible part, from the pivot to where the scoop begins, is cut into n equal pieces with a hinge in the middle of
// each. A force F across the tail at distance d turns hinge i at s_i by F (d - s_i)/k, which moves the place d by the sum of
// F (d - s_i)^2/k; as an angle about the pivot per moment F d this is 1/K = sum (d - s_i)^2/(k d^2), so that
//   k = K sum (d - s_i)^2/d^2.
// The stop. MuJoCo's limit is an oscillator a = -2 zeta v - r (time in 1/w) that only pushes. From r = 0, v = -1 it pushes until
// a = 0, and the speed then is the restitution e(zeta). With s = sqrt|1 - zeta^2|
//   zeta < 1:  t = (pi - atan2(2 zeta s, 1 - 2 zeta^2) )/s if taken in (0, pi),  v = -exp(-zeta t)(cos st - zeta/s sin st)
//   zeta > 1:  t = ln(l2/l1)/s,  v = (l1 exp(-l1 t) - l2 exp(-l2 t))/(2 s),  l1, l2 = zeta -+ s
// e(1) = exp(-2), and e falls to 0 only as 1/zeta^2: a stop without restitution gets zeta = 3, e = 0.024.

#include "testbed/mjcf.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace jaculus::testbed {
namespace {

constexpr double kRotorMass =
    1e-6;  ///< of the motor's side of a joint with play: MuJoCo wants every body to have some [kg]
constexpr double kRotorInertia = 1e-9;  ///< [kg m^2]
constexpr double kPointRadius = 1e-6;   ///< of a toe that is a point [m]
constexpr double kPlateMass = 0.01;     ///< of a floor plate [kg]

std::size_t at(int index) { return static_cast<std::size_t>(index); }

std::string numbers(const Vec3& v) { return fmt::format("{:.17g} {:.17g} {:.17g}", v.x(), v.y(), v.z()); }

/// Mass, centre of mass and pitch inertia of one rigid part; inertias about the other axes play no part in the plane.
struct Part {
  double mass = 0.0;
  Vec3 com = Vec3::Zero();
  Mat3 inertia = Mat3::Zero();
};

std::string inertial(const Part& part) {
  const Mat3& i = part.inertia;
  return fmt::format(
      "<inertial pos=\"{}\" mass=\"{:.17g}\" fullinertia=\"{:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}\"/>\n",
      numbers(part.com), part.mass, i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2));
}

/// Of each hinge of the shaft [N m/rad].
double hinge_stiffness(const RobotFiles& files, const Changes& changes, const std::vector<double>& hinges) {
  const double d = files.drags.front().point_distance;
  double sum = 0.0;
  for (const double s : hinges) sum += (d - s) * (d - s);
  return changes.shaft_stiffness * sum / (d * d);
}

class Writer {
 public:
  Writer(const RobotFiles& files, const Changes& changes, const Setting& setting, const Numerics& numerics)
      : files_(files), tree_(files.tree), changes_(changes), setting_(setting), numerics_(numerics) {
    hinges_ = shaft_hinges(files, changes);
    if (!files.drag_links.empty()) tail_link_ = files.drag_links.front();
  }

  std::string text() {
    head();
    out_ += "<worldbody>\n";
    if (setting_.floor) floor();
    base();
    out_ += "</worldbody>\n";
    constraints();
    return out_ + "</mujoco>\n";
  }

 private:
  void head() {
    out_ = fmt::format(
        "<mujoco model=\"{}\">\n<compiler angle=\"radian\" inertiafromgeom=\"false\" balanceinertia=\"false\" "
        "boundmass=\"0\" boundinertia=\"0\"/>\n"
        "<option timestep=\"{:.17g}\" integrator=\"{}\" cone=\"elliptic\" solver=\"Newton\" iterations=\"100\" "
        "tolerance=\"1e-14\" impratio=\"{:.17g}\" gravity=\"0 0 {:.17g}\"/>\n<size nconmax=\"64\" njmax=\"256\"/>\n",
        files_.name, numerics_.step, numerics_.runge_kutta ? "RK4" : "Euler", numerics_.friction_impedance,
        -files_.gravity);
  }

  /// solref and solimp of everything that is rigid.
  [[nodiscard]] std::string rigid() const {
    return fmt::format("solref=\"{:.17g} 1\" solimp=\"{:.17g} {:.17g} 0.001\"",
                       numerics_.stiffness_steps * numerics_.step, numerics_.impedance, numerics_.impedance);
  }

  void floor() {
    if (std::isinf(changes_.floor_stiffness)) {
      out_ += "<geom name=\"floor\" type=\"plane\" size=\"0 0 1\" contype=\"0\" conaffinity=\"0\"/>\n";
      return;
    }
    // A plate under each toe, on a spring of its own.
    double mass = 0.0;
    for (const SpatialLink& link : tree_.links) mass += link.mass;
    const double share = mass / std::max(1.0, static_cast<double>(files_.toes.size()));
    const double k = changes_.floor_stiffness;
    for (std::size_t i = 0; i < files_.toes.size(); ++i) {
      out_ += fmt::format(
          "<body name=\"plate_{0}\"><inertial pos=\"0 0 0\" mass=\"{1}\" diaginertia=\"1e-3 1e-3 1e-3\"/>"
          "<joint name=\"plate_{0}\" type=\"slide\" axis=\"0 0 1\" stiffness=\"{2:.17g}\" damping=\"{3:.17g}\"/>"
          "<geom name=\"floor_{0}\" type=\"box\" size=\"20 1 0.5\" pos=\"0 0 -0.5\" contype=\"0\" conaffinity=\"0\"/>"
          "</body>\n",
          i, kPlateMass, k, 2.0 * changes_.floor_damping_ratio * std::sqrt(k * share));
    }
  }

  void base() {
    const SpatialLink& root = tree_.links[at(tree_.root)];
    out_ += fmt::format("<body name=\"{}\">\n", root.name);
    if (!setting_.base_fixed && files_.floating) {
      out_ +=
          "<joint name=\"base_x\" type=\"slide\" axis=\"1 0 0\"/><joint name=\"base_z\" type=\"slide\" axis=\"0 0 1\"/>"
          "<joint name=\"base_pitch\" type=\"hinge\" axis=\"0 1 0\"/>\n";
    }
    Part whole = composite(tree_.root);
    whole.com += Vec3(changes_.com_shift.x(), 0.0, changes_.com_shift.y());
    whole.inertia(1, 1) *= changes_.base_inertia;
    Part part = root.mass > 0.0 ? own_share(tree_.root, whole) : Part{};
    part.mass -= changes_.outside.loose_mass;
    if (part.mass > 0.0) out_ += inertial(part);
    additions();
    children(tree_.root, Vec3::Zero());
    out_ += "</body>\n";
  }

  /// Payload, and a battery that came loose.
  void additions() {
    if (changes_.payload > 0.0) {
      out_ += fmt::format(
          "<body name=\"payload\" pos=\"{:.17g} 0 {:.17g}\"><inertial pos=\"0 0 0\" mass=\"{:.17g}\" "
          "diaginertia=\"1e-6 1e-6 1e-6\"/></body>\n",
          changes_.payload_place.x(), changes_.payload_place.y(), changes_.payload);
    }
    if (const double m = changes_.outside.loose_mass; m > 0.0) {
      out_ += fmt::format(
          "<body name=\"loose\"><joint name=\"loose\" type=\"slide\" axis=\"1 0 0\" stiffness=\"{:.17g}\" "
          "damping=\"{:.17g}\"/><inertial pos=\"0 0 0\" mass=\"{:.17g}\" diaginertia=\"1e-6 1e-6 1e-6\"/></body>\n",
          400.0 * m, 4.0 * m, m);
    }
  }

  /// A link with all that is fixed to it, seen as one body. Only its pitch inertia is meant.
  [[nodiscard]] Part composite(int index) const {
    const SpatialLink& link = tree_.links[at(index)];
    Part whole{link.mass, link.com, link.inertia};
    for (const SpatialJoint& joint : tree_.joints) {
      if (joint.parent != index || joint.kind != SpatialJointKind::fixed) continue;
      Part below = composite(joint.child);
      below.com = joint.origin + joint.rotation * below.com;
      merge(whole, below, 1.0);
    }
    return whole;
  }

  /// What the link itself must be so that, with all that is fixed to it, it is `whole`.
  [[nodiscard]] Part own_share(int index, Part whole) const {
    for (const SpatialJoint& joint : tree_.joints) {
      if (joint.parent != index || joint.kind != SpatialJointKind::fixed) continue;
      Part below = composite(joint.child);
      below.com = joint.origin + joint.rotation * below.com;
      merge(whole, below, -1.0);
    }
    // MuJoCo wants inertias that a body can have about every axis.
    whole.inertia = Vec3(whole.inertia(1, 1), whole.inertia(1, 1), 0.5 * whole.inertia(1, 1)).asDiagonal();
    return whole;
  }

  /// Adds (sign 1) or takes away (-1) a part: masses, centres of mass, pitch inertia by the parallel-axis theorem.
  static void merge(Part& whole, const Part& part, double sign) {
    const double mass = whole.mass + sign * part.mass;
    if (mass <= 0.0) return;
    const Vec3 com = (whole.mass * whole.com + sign * part.mass * part.com) / mass;
    const auto about = [&](const Part& p) {
      const Vec3 d = p.com - com;
      return p.inertia(1, 1) + p.mass * (d.x() * d.x() + d.z() * d.z());
    };
    const double pitch = about(whole) + sign * about(part);
    whole.mass = mass;
    whole.com = com;
    whole.inertia(1, 1) = pitch;
  }

  void children(int link, const Vec3& shift) {
    for (const SpatialJoint& joint : tree_.joints) {
      if (joint.parent == link) child(joint, shift);
    }
  }

  [[nodiscard]] const Drive* drive_of(const std::string& joint) const {
    for (const Drive& drive : files_.drives) {
      if (drive.joint == joint) return &drive;
    }
    return nullptr;
  }

  [[nodiscard]] double play_of(const Drive* drive, const std::string& link) const {
    if (drive == nullptr) return 0.0;
    return link == tail_link_ ? changes_.tail_play : changes_.leg_play;
  }

  /// One body on its joint, with what lies between the motor and it. `shift`: origin of the parent's frame in the body written last.
  void child(const SpatialJoint& joint, const Vec3& shift) {
    const SpatialLink& link = tree_.links[static_cast<std::size_t>(joint.child)];
    const Eigen::Quaterniond turn(joint.rotation);
    const std::string place = fmt::format("pos=\"{}\" quat=\"{:.17g} {:.17g} {:.17g} {:.17g}\"",
                                          numbers(joint.origin + shift), turn.w(), turn.x(), turn.y(), turn.z());
    const Drive* drive = drive_of(joint.name);
    const double play = play_of(drive, link.name);
    const bool tail = link.name == tail_link_;
    int open = 1;
    if (play > 0.0) {
      out_ += fmt::format("<body name=\"{}_motor_side\" {}>\n{}", joint.name, place, motor_joint(joint, drive, tail));
      out_ += inertial({kRotorMass, Vec3::Zero(), kRotorInertia * Mat3::Identity()});
      out_ += fmt::format("<body name=\"{}\">\n", link.name);
      out_ += fmt::format(
          "<joint name=\"{0}_play\" type=\"hinge\" axis=\"{1}\" limited=\"true\" range=\"{2:.17g} {3:.17g}\" "
          "solreflimit=\"0.001 0.5\" solimplimit=\"0.999 0.999 0.001\"/>\n",
          joint.name, numbers(joint.axis), -0.5 * play, 0.5 * play);
      open = 2;
    } else {
      out_ += fmt::format("<body name=\"{}\" {}>\n", link.name, place);
      if (joint.kind != SpatialJointKind::fixed) out_ += motor_joint(joint, drive, tail);
    }
    if (tail && !hinges_.empty()) {
      open += bent_shaft(joint, link);
    } else {
      rigid_link(joint.child, tail);
    }
    for (int i = 0; i < open; ++i) out_ += "</body>\n";
  }

  std::string motor_joint(const SpatialJoint& joint, const Drive* drive, bool tail) {
    double armature = 0.0;
    if (drive != nullptr) {
      const double added = tail ? changes_.tail_rotor_inertia : changes_.leg_rotor_inertia;
      armature = drive->motor.gear * drive->motor.gear * (drive->motor.rotor_inertia + added);
    }
    std::string range;
    if (setting_.stops && std::isfinite(joint.range.lower) && std::isfinite(joint.range.upper)) {
      // Of one stiffness whatever the damping: time constant 1/(zeta w), at most what MuJoCo takes at the finest step.
      const double ratio = damping_ratio_of_restitution(changes_.stop_restitution);
      range = fmt::format(
          " limited=\"true\" range=\"{:.17g} {:.17g}\" solreflimit=\"{:.17g} {:.17g}\" "
          "solimplimit=\"0.9999 0.9999 0.001\"",
          joint.range.lower, joint.range.upper, 6.0 * numerics_.step * kStopStep / ratio, ratio);
    }
    const DryFriction& f = tail ? changes_.tail_friction : changes_.leg_friction;
    const bool rubs = drive != nullptr && (f.coulomb > 0.0 || f.stribeck > 0.0 || f.load > 0.0);
    return fmt::format(
        "<joint name=\"{}\" type=\"{}\" axis=\"{}\" armature=\"{:.17g}\" damping=\"{:.17g}\" "
        "frictionloss=\"{}\" solreffriction=\"0.001 1\" solimpfriction=\"0.999 0.999 0.001\"{}/>\n",
        joint.name, joint.kind == SpatialJointKind::prismatic ? "slide" : "hinge", numbers(joint.axis), armature,
        drive != nullptr ? f.viscous : 0.0, rubs ? "1e-6" : "0", range);
  }

  /// The rest of a link that is one piece: mass, toes, pins, and what hangs on it.
  void rigid_link(int index, bool tail) {
    const SpatialLink& link = tree_.links[static_cast<std::size_t>(index)];
    Part part{link.mass, link.com, link.inertia};
    if (tail) {
      Part whole = composite(index);
      whole.inertia(1, 1) *= changes_.tail_inertia;
      part = own_share(index, whole);
    }
    if (tail || hangs_on_tail(index)) {
      part.mass *= changes_.tail_mass;
      part.inertia *= changes_.tail_mass;
    } else {
      part.inertia *= leg_factor(index);
    }
    if (part.mass > 0.0) out_ += inertial(part);
    marks(link.name);
    children(index, Vec3::Zero());
  }

  /// Pieces of the shaft, each a body on a hinge; returns how many bodies it left open. The first piece turns with the motor.
  int bent_shaft(const SpatialJoint& joint, const SpatialLink& link) {
    const double length = 2.0 * link.com.z();  // a uniform rod from the pivot
    const double factor = changes_.tail_mass;
    const double stiffness = hinge_stiffness(files_, changes_, hinges_);
    double inertia = link.inertia(1, 1) + link.mass * link.com.squaredNorm();
    for (const SpatialJoint& below : tree_.joints) {
      if (below.parent == joint.child)
        inertia += tree_.links[static_cast<std::size_t>(below.child)].mass * below.origin.squaredNorm();
    }
    // All hinges together, seen as one at the root, have K and K c/k.
    const double damping =
        2.0 * changes_.shaft_damping_ratio * std::sqrt(inertia / changes_.shaft_stiffness) * stiffness;
    double from = 0.0;
    int opened = 0;
    for (std::size_t i = 0; i <= hinges_.size(); ++i) {
      const double to = i < hinges_.size() ? hinges_[i] : length;
      const double piece = to - from;
      Part part;
      part.mass = factor * link.mass * piece / length;
      part.com = Vec3(0.0, 0.0, 0.5 * piece);
      const double turning = part.mass * piece * piece / 12.0;
      part.inertia.diagonal() << turning, turning, 0.01 * turning;
      if (i > 0) {
        out_ += fmt::format(
            "<body name=\"tail_piece_{0}\" pos=\"0 0 {1:.17g}\">\n<joint name=\"tail_bend_{0}\" "
            "type=\"hinge\" axis=\"{2}\" stiffness=\"{3:.17g}\" damping=\"{4:.17g}\"/>\n",
            i, i == 1 ? from : from - hinges_[i - 2], numbers(joint.axis), stiffness, damping);
        ++opened;
      }
      out_ += inertial(part);
      if (i < hinges_.size()) from = to;
    }
    children(joint.child, Vec3(0.0, 0.0, -hinges_.back()));
    return opened;
  }

  [[nodiscard]] bool hangs_on_tail(int index) const {
    for (int i = index; i >= 0;) {
      const SpatialLink& link = tree_.links[static_cast<std::size_t>(i)];
      if (link.name == tail_link_) return true;
      i = link.joint < 0 ? -1 : tree_.joints[static_cast<std::size_t>(link.joint)].parent;
    }
    return false;
  }

  /// Links of legs are those that move; what is fixed to the base keeps its mass.
  [[nodiscard]] double leg_factor(int index) const {
    for (int i = index; i >= 0;) {
      const SpatialLink& link = tree_.links[static_cast<std::size_t>(i)];
      if (link.joint < 0) return 1.0;
      const SpatialJoint& joint = tree_.joints[static_cast<std::size_t>(link.joint)];
      if (joint.kind != SpatialJointKind::fixed) return changes_.leg_inertia;
      i = joint.parent;
    }
    return 1.0;
  }

  void marks(const std::string& link) {
    for (std::size_t i = 0; i < files_.pins.size(); ++i) {
      const Pin& pin = files_.pins[i];
      if (pin.link_a == link) out_ += fmt::format("<site name=\"pin_{}_a\" pos=\"{}\"/>\n", i, numbers(pin.point_a));
      if (pin.link_b == link) out_ += fmt::format("<site name=\"pin_{}_b\" pos=\"{}\"/>\n", i, numbers(pin.point_b));
    }
    const double radius = std::max(changes_.toe_radius, kPointRadius);
    for (std::size_t i = 0; i < files_.toes.size(); ++i) {
      Toe toe = files_.toes[i];
      if (toe.link != link) continue;
      if (i + 2 == files_.toes.size()) toe.point.z() -= changes_.outside.bent_link;
      out_ += fmt::format(
          "<geom name=\"toe_{}\" type=\"sphere\" size=\"{:.17g}\" pos=\"{}\" contype=\"0\" conaffinity=\"0\"/>\n", i,
          radius, numbers(toe.point));
    }
  }

  void constraints() {
    if (!files_.pins.empty()) {
      out_ += "<equality>\n";
      for (const Pin& pin : files_.pins) {
        out_ += fmt::format("<connect body1=\"{}\" body2=\"{}\" anchor=\"{}\" {}/>\n", pin.link_a, pin.link_b,
                            numbers(pin.point_a), rigid());
      }
      out_ += "</equality>\n";
    }
    if (!setting_.floor || files_.toes.empty()) return;
    const double friction = files_.friction * changes_.floor_friction_scale;
    const bool plates = std::isfinite(changes_.floor_stiffness);
    out_ += "<contact>\n";
    for (std::size_t i = 0; i < files_.toes.size(); ++i) {
      out_ +=
          fmt::format("<pair geom1=\"toe_{0}\" geom2=\"floor{1}\" condim=\"3\" friction=\"{2:.17g} {2:.17g}\" {3}/>\n",
                      i, plates ? fmt::format("_{}", i) : "", friction, rigid());
    }
    out_ += "</contact>\n";
  }

  const RobotFiles& files_;
  const SpatialTree& tree_;
  const Changes& changes_;
  const Setting& setting_;
  const Numerics& numerics_;
  std::vector<double> hinges_;
  std::string tail_link_;
  std::string out_;
};

}  // namespace

Numerics numerics_for(const RobotFiles& files, const Changes& changes, Numerics numerics) {
  double fastest = 0.0;  // [rad/s]
  if (const std::vector<double> hinges = shaft_hinges(files, changes); !hinges.empty()) {
    const SpatialLink& link = files.tree.links[at(files.tree.link_index(files.drag_links.front()))];
    const double piece = hinges.size() > 1 ? hinges[1] - hinges[0] : hinges[0];
    const double inertia = link.mass * piece / (2.0 * link.com.z()) * piece * piece / 12.0;
    fastest = std::sqrt(4.0 * hinge_stiffness(files, changes, hinges) / inertia);
  }
  if (std::isfinite(changes.floor_stiffness)) {
    fastest = std::max(fastest, std::sqrt(changes.floor_stiffness / kPlateMass));
  }
  if (fastest == 0.0) return numerics;
  numerics.runge_kutta = false;
  numerics.step = std::min(1e-4, 0.4 / fastest);
  return numerics;
}

std::vector<double> shaft_hinges(const RobotFiles& files, const Changes& changes) {
  std::vector<double> hinges;
  if (changes.shaft_segments <= 0 || files.drags.empty()) return hinges;
  const double piece = files.drags.front().start / changes.shaft_segments;
  for (int i = 0; i < changes.shaft_segments; ++i) hinges.push_back((i + 0.5) * piece);
  return hinges;
}

double restitution_of_damping_ratio(double ratio) {
  const double s = std::sqrt(std::abs(1.0 - ratio * ratio));
  if (s < 1e-6) return std::exp(-2.0);
  if (ratio < 1.0) {
    const double t = (std::numbers::pi - std::atan2(2.0 * ratio * s, 1.0 - 2.0 * ratio * ratio)) / s;
    return -std::exp(-ratio * t) * (std::cos(s * t) - ratio / s * std::sin(s * t));
  }
  const double slow = ratio - s, fast = ratio + s;
  const double t = std::log(fast / slow) / s;
  return (slow * std::exp(-slow * t) - fast * std::exp(-fast * t)) / (2.0 * s);
}

double damping_ratio_of_restitution(double restitution) {
  double low = 0.0, high = 3.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (restitution_of_damping_ratio(middle) > restitution ? low : high) = middle;
  }
  return high;
}

std::string mjcf(const RobotFiles& files, const Changes& changes, const Setting& setting, const Numerics& numerics) {
  return Writer(files, changes, setting, numerics).text();
}

}  // namespace jaculus::testbed
