#pragma once
// The robot's kinematics once more, straight from the definitions at the top of planar.h: body by body, no absolute
// coordinates, no Jacobians. An independent witness for the tests.

#include <cmath>
#include <vector>

#include "jaculus/dynamics/loop_closure.h"
#include "jaculus/model/planar.h"

namespace jaculus::plain {

struct Frame {
  Vec2 position;
  double angle;
};

inline Vec2 turned(double phi, const Vec2& v) {
  return {std::cos(phi) * v.x() + std::sin(phi) * v.y(), -std::sin(phi) * v.x() + std::cos(phi) * v.y()};
}

inline Vec2 point_of(const Frame& f, const Vec2& in_body) { return f.position + turned(f.angle, in_body); }

/// Frames of all bodies from the base's pose (x, z, pitch) and every joint's value.
inline std::vector<Frame> frames(const PlanarModel& model, const Eigen::Vector3d& base, const Vector& joints) {
  std::vector<Frame> out{{Vec2(base[0], base[1]), base[2]}};
  for (size_t b = 1; b < model.bodies.size(); ++b) {
    const PlanarBody& link = model.bodies[b];
    const Frame& parent = out[static_cast<size_t>(link.parent)];
    const double theta = joints[static_cast<int>(b)];
    const bool revolute = link.kind == JointKind::revolute;
    out.push_back({point_of(parent, revolute ? link.origin : link.origin + theta * link.axis),
                   parent.angle + link.angle_offset + (revolute ? link.sign * theta : 0.0)});
  }
  return out;
}

/// Frames at generalised coordinates q; only the dependent joints' values come from the library.
inline std::vector<Frame> frames(const PlanarModel& model, const AbsoluteTree& tree, const Vector& q) {
  Motion motion(tree);
  if (!set_configuration(tree, q, motion)) return {};
  Eigen::Vector3d base = model.base_pose;
  int column = 0;
  for (int i = 0; i < 3; ++i)
    if (model.base_free[static_cast<size_t>(i)]) base[i] = q[column++];
  Vector joints = model.joint_map * q + model.joint_offset;
  for (size_t k = 0; k < model.dependent.size(); ++k) joints[model.dependent[k]] = motion.d[static_cast<int>(k)];
  return frames(model, base, joints);
}

/// Reflected rotor energy [J] at rates v, from the motors' own data.
inline double rotor_energy(const PlanarModel& model, const Vector& v) {
  double sum = 0.0;
  for (const PlanarMotor& m : model.motors) {
    const double rate = m.gear * model.joint_map.row(m.body).dot(v);
    sum += 0.5 * m.count * m.rotor_inertia * rate * rate;
  }
  return sum;
}

}  // namespace jaculus::plain
