#pragma once
// Planar models built by hand for closed forms.

#include <string>
#include <vector>

#include "jaculus/model/planar.h"

namespace jaculus::test_support {

inline model::PlanarBody link(const std::string& name, int parent, const Vec2& origin, double mass,
                              const Vec2& com, double inertia, double sign = 1.0) {
  model::PlanarBody b;
  b.name = b.joint = name;
  b.parent = parent;
  b.origin = origin;
  b.mass = mass;
  b.com = com;
  b.inertia = inertia;
  b.sign = sign;
  return b;
}

/// Makes the named joints coordinates, after the free ones of x, z and pitch.
inline model::PlanarModel with_coordinates(model::PlanarModel model,
                                           const std::vector<std::string>& joints) {
  static const char* const base[3] = {"x", "z", "pitch"};
  for (std::size_t i = 0; i < 3; ++i)
    if (model.base_free[i]) model.coordinates.push_back({base[i], i == 2, {}});
  const int first = model.size();
  for (const std::string& joint : joints) model.coordinates.push_back({joint, true, {}});
  const int bodies = count_of(model.bodies);
  model.joint_map = Matrix::Zero(bodies, model.size());
  model.joint_offset = Vector::Zero(bodies);
  for (int k = 0; k < count_of(joints); ++k)
    model.joint_map(model.body_of_joint(joints[k]), first + k) = 1.0;
  return model;
}

inline model::PlanarModel on_fixed_base(std::vector<model::PlanarBody> bodies,
                                        const std::vector<std::string>& joints) {
  model::PlanarModel model;
  model.base_free = {false, false, false};
  bodies.insert(bodies.begin(), link("base", -1, Vec2::Zero(), 0.0, Vec2::Zero(), 0.0));
  model.bodies = std::move(bodies);
  return with_coordinates(std::move(model), joints);
}

}  // namespace jaculus::test_support
