#include "support/sample_models.h"

namespace jaculus::test_support {

namespace {

model::PlanarBody body(const std::string& name, int parent, const Vec2& origin, double sign,
                       double mass, const Vec2& com, double inertia) {
  model::PlanarBody b;
  b.name = name;
  b.joint = name;
  b.parent = parent;
  b.origin = origin;
  b.sign = sign;
  b.mass = mass;
  b.com = com;
  b.inertia = inertia;
  return b;
}

model::PlanarMotor motor(const std::string& joint, int at, int count) {
  model::PlanarMotor m;
  m.joint = joint;
  m.body = at;
  m.count = count;
  m.gear = 3.0;
  m.rotor_inertia = 1e-3;
  return m;
}

void finish(model::PlanarModel& model, const std::vector<std::string>& coordinates) {
  const int bodies = count_of(model.bodies);
  for (std::size_t i = 0; i < 3; ++i) {
    static const char* const names[3] = {"x", "z", "pitch"};
    if (model.base_free[i]) model.coordinates.push_back({names[i], i == 2, {}});
  }
  const int base = model.size();
  for (const std::string& name : coordinates) model.coordinates.push_back({name, true, {}});
  model.joint_map = Matrix::Zero(bodies, model.size());
  model.joint_offset = Vector::Zero(bodies);
  for (int k = 0; k < count_of(coordinates); ++k)
    model.joint_map(model.body_of_joint(coordinates[k]), base + k) = 1.0;
}

model::PlanarModel pendulum() {
  model::PlanarModel m;
  m.base_free = {false, false, false};
  m.bodies = {body("base", -1, Vec2::Zero(), 1.0, 0.0, Vec2::Zero(), 0.0),
              body("arm", 0, Vec2(0.1, 0.2), -1.0, 1.3, Vec2(0.05, -0.7), 0.02)};
  m.motors = {motor("arm", 1, 1)};
  finish(m, {"arm"});
  return m;
}

model::PlanarModel slider_rod() {
  model::PlanarModel m;
  m.base_free = {true, false, false};
  m.bodies = {body("base", -1, Vec2::Zero(), 1.0, 2.0, Vec2(0.0, 0.1), 0.1),
              body("rod", 0, Vec2(0.1, 0.0), 1.0, 0.5, Vec2(0.0, 0.4), 0.01),
              body("telescope", 1, Vec2(0.0, 0.8), 1.0, 0.3, Vec2(0.02, 0.1), 0.004)};
  m.bodies[2].kind = model::JointKind::prismatic;
  m.bodies[2].axis = Vec2(0.6, 0.8);
  m.bodies[2].angle_offset = 0.3;
  m.motors = {motor("rod", 1, 1), motor("telescope", 2, 1)};
  finish(m, {"rod", "telescope"});
  return m;
}

/// Bodies 1 to 4 are a five-bar leg, 5 and 6 a hip with a prismatic shin, 7 a tail.
model::PlanarModel leaper() {
  model::PlanarModel m;
  m.bodies = {body("base", -1, Vec2::Zero(), 1.0, 6.0, Vec2(0.01, 0.02), 0.2),
              body("a", 0, Vec2(0.2, 0.0), -1.0, 0.08, Vec2(0.0, 0.04), 3e-4),
              body("b", 0, Vec2(0.22, 0.01), 1.0, 0.09, Vec2(0.01, 0.04), 3e-4),
              body("a_knee", 1, Vec2(0.0, 0.1), -1.0, 0.16, Vec2(0.0, -0.14), 7e-4),
              body("b_knee", 2, Vec2(0.0, 0.11), 1.0, 0.10, Vec2(0.0, -0.10), 4e-4),
              body("hip", 0, Vec2(-0.2, 0.0), 1.0, 0.1, Vec2(0.0, -0.1), 1e-3),
              body("shin", 5, Vec2(0.0, -0.1), 1.0, 0.2, Vec2(0.0, -0.1), 1e-3),
              body("tail", 0, Vec2(-0.1, 0.1), 1.0, 0.1, Vec2(0.0, 0.6), 5e-3)};
  m.bodies[6].kind = model::JointKind::prismatic;
  m.bodies[6].axis = Vec2(0.0, -1.0);
  m.loops = {{"leg", 3, Vec2(0.0, -0.2), 4, Vec2(0.0, -0.21), -1.0}};
  m.dependent = {3, 4};
  m.feet = {{"front", 3, Vec2(0.01, -0.24), 2}, {"rear", 6, Vec2(0.0, -0.15), 2}};
  m.motors = {motor("a", 1, 2), motor("b", 2, 2), motor("hip", 5, 2), motor("shin", 6, 2),
              motor("tail", 7, 1)};
  model::PlanarDrag drag;
  drag.name = "tail";
  drag.body = 7;
  drag.coefficient = 2.0;
  drag.width = 0.18;
  drag.start = 0.3;
  drag.end = 1.0;
  drag.point_distance = 0.8;
  drag.point_area = 0.072;
  drag.wind_W = Vec2(1.5, -0.3);
  m.drags = {drag};
  finish(m, {"a", "b", "hip", "shin", "tail"});
  for (const char* name : {"a", "b"}) m.coordinates[m.coordinate_index(name)].range = {0.8, 2.0};
  return m;
}

}  // namespace

std::vector<NamedModel> sample_models() {
  model::PlanarModel point = leaper(), rotation = leaper();
  point.drags[0].kind = model::DragKind::point;
  rotation.drags[0].kind = model::DragKind::rotation;
  return {{"Pendulum", pendulum()},
          {"SliderRod", slider_rod()},
          {"Leaper", leaper()},
          {"LeaperPointDrag", point},
          {"LeaperRotationDrag", rotation}};
}

}  // namespace jaculus::test_support
