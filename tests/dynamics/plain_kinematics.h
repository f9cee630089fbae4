#pragma once
// The robot's kinematics once more, straight from the definitions at the top of planar.h: body by
// body, no absolute coordinates, no Jacobians. An independent witness for the tests.

#include <cmath>
#include <vector>

#include "jaculus/dynamics/loop_closure.h"
#include "jaculus/model/planar.h"

namespace jaculus::dynamics::plain {

struct Frame {
  Vec2 position;
  double angle;
};

inline Vec2 turned(double phi, const Vec2& v) {
  return {std::cos(phi) * v.x() + std::sin(phi) * v.y(),
          -std::sin(phi) * v.x() + std::cos(phi) * v.y()};
}

inline Vec2 point_of(const Frame& f, const Vec2& in_body) {
  return f.position + turned(f.angle, in_body);
}

/// Frames of all bodies from the base's pose (x, z, pitch) and every joint's value.
inline std::vector<Frame> frames(const model::PlanarModel& model, const Eigen::Vector3d& base,
                                 const Vector& joints) {
  std::vector<Frame> out{{Vec2(base[0], base[1]), base[2]}};
  for (int b = 1; b < count_of(model.bodies); ++b) {
    const model::PlanarBody& link = model.bodies[b];
    const Frame& parent = out[link.parent];
    const double theta = joints[b];
    const bool revolute = link.kind == model::JointKind::revolute;
    out.push_back({point_of(parent, revolute ? link.origin : link.origin + theta * link.axis),
                   parent.angle + link.angle_offset + (revolute ? link.sign * theta : 0.0)});
  }
  return out;
}

/// Frames at generalised coordinates q; only the dependent joints' values come from the library.
inline std::vector<Frame> frames(const model::PlanarModel& model, const AbsoluteTree& tree,
                                 const Vector& q) {
  Motion motion(tree);
  if (!set_configuration(tree, q, motion)) return {};
  Eigen::Vector3d base = model.base_pose;
  int column = 0;
  for (int i = 0; i < 3; ++i)
    if (model.base_free[i]) base[i] = q[column++];
  Vector joints = model.joint_map * q + model.joint_offset;
  for (int k = 0; k < count_of(model.dependent); ++k) joints[model.dependent[k]] = motion.d[k];
  return frames(model, base, joints);
}

/// Reflected rotor energy [J] at rates v, from the motors' own data.
inline double rotor_energy(const model::PlanarModel& model, const Vector& v) {
  double sum = 0.0;
  for (const model::PlanarMotor& m : model.motors) {
    const double rate = m.gear * model.joint_map.row(m.body).dot(v);
    sum += 0.5 * m.count * m.rotor_inertia * rate * rate;
  }
  return sum;
}

}  // namespace jaculus::dynamics::plain
