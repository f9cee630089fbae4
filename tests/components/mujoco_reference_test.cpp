// Minitaur with tail against MuJoCo: tests/data/mujoco_minitaur_tail.txt, written by
// scripts/mujoco_reference, which explains its rows. MuJoCo reads the same URDF as bodies in space;
// nothing else is shared: neither the reduction to the plane, nor the loops' elimination, nor a
// line of dynamics. Drag off, rotor reflected.

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "components/authors_plan.h"
#include "jaculus/core/installation.h"
#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/model/robot.h"

namespace jaculus::test {
namespace {

using State = std::map<std::string, Vector>;

std::vector<State> read_states() {
  const auto file = source_folder() / "tests/data/mujoco_minitaur_tail.txt";
  std::ifstream stream(file);
  EXPECT_TRUE(stream.good()) << file;
  std::vector<State> states;
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::string key;
    words >> key;
    std::vector<double> values;
    for (double x = 0.0; words >> x;) values.push_back(x);
    if (key == "q") states.emplace_back();
    states.back()[key] = Eigen::Map<const Vector>(values.data(), values.size());
  }
  return states;
}

/// The file's order of coordinates: base, then these joints.
const std::vector<std::string> kJoints{"front_a",      "front_a_knee", "front_b",
                                       "front_b_knee", "rear_a",       "rear_a_knee",
                                       "rear_b",       "rear_b_knee",  "tail"};

/// Rows of the file's order among the opened robot's coordinates.
std::vector<int> order(const model::PlanarModel& open) {
  std::vector<int> rows{0, 1, 2};
  for (const std::string& joint : kJoints) rows.push_back(open.coordinate_index(joint));
  return rows;
}

double relative(const Vector& ours, const Vector& theirs) {
  return (ours - theirs).cwiseAbs().maxCoeff() / (1.0 + theirs.cwiseAbs().maxCoeff());
}

model::PlanarModel without_drag() {
  model::PlanarModel model = model::read_robot(source_folder() / "models" / "minitaur_tail").planar;
  model.drags.clear();
  return model;
}

TEST(MujocoReference, MassMatrixAndBiasOfTheTree) {
  const model::PlanarModel open = opened(without_drag());
  const dynamics::AbsoluteTree tree(open);
  const std::vector<int> rows = order(open);
  const std::vector<State> states = read_states();
  ASSERT_EQ(states.size(), 4U);
  for (const State& s : states) {
    Vector q(12), v(12), w(12);
    for (int i = 0; i < 12; ++i) {
      const int row = rows[i];
      q[row] = s.at("q")[i];
      v[row] = s.at("v")[i];
      w[row] = i + 1;
    }
    dynamics::Motion motion(tree);
    ASSERT_TRUE(dynamics::set_configuration(tree, q, motion));
    dynamics::set_rates(tree, v, motion);
    EXPECT_LT(relative((dynamics::mass_matrix(tree, motion) * w)(rows), s.at("M_w")), 1e-12);
    EXPECT_LT(relative(dynamics::bias(tree, motion)(rows), s.at("h")), 1e-12);
  }
}

TEST(MujocoReference, AccelerationsAndForcesWithLoopsAndStance) {
  const model::PlanarModel model = without_drag();
  const components::Equations equations(model);
  const int front = model.foot_index("front_foot"), rear = model.foot_index("rear_foot");
  for (const State& s : read_states()) {
    PlanNode node;
    const int bodies = count_of(model.bodies);
    node.joints = node.joint_v = node.joint_a = Vector::Zero(bodies);
    node.base_q = s.at("q").head<3>();
    node.base_v = s.at("v").head<3>();
    for (int i = 0; i < 9; ++i) {
      const int body = model.body_of_joint(kJoints[i]);
      node.joints[body] = s.at("q")[3 + i];
      node.joint_v[body] = s.at("v")[3 + i];
    }
    Vector u(5);
    for (int m = 0; m < 5; ++m) {
      static const char* const names[5] = {"front_a", "front_b", "rear_a", "rear_b", "tail"};
      u[model.motor_index(names[m])] = s.at("torque")[m];
    }
    struct Stance {
      std::string key;
      std::vector<int> feet;
    };
    const Coordinates c = coordinates(model, node);
    for (const Stance& stance :
         {Stance{"stance", {front, rear}}, Stance{"rear", {rear}}, Stance{"air", {}}}) {
      components::EquationsPoint p(equations, stance.feet);
      ASSERT_TRUE(equations.evaluate(c.q, c.v, u, p));
      const Vector& theirs = s.at(stance.key + "_a");
      Vector ours(12);
      ours.head<3>() = p.a.head<3>();
      for (int i = 0; i < 9; ++i) {
        const int body = model.body_of_joint(kJoints[i]);
        const model::PlanarBody& link = model.bodies[body];
        const double turn = p.A[dynamics::AbsoluteTree::angle_index(body)] -
                            p.A[dynamics::AbsoluteTree::angle_index(link.parent)];
        ours[3 + i] = link.sign * turn;
      }
      EXPECT_LT(relative(ours, theirs), 1e-9) << stance.key;
      if (stance.feet.empty()) continue;
      EXPECT_LT(relative(p.force, s.at(stance.key + "_f")), 1e-9) << stance.key;
    }
    for (int k = 0; k < count_of(model.dependent); ++k) {
      components::EquationsPoint p(equations, {});
      ASSERT_TRUE(equations.evaluate(c.q, c.v, u, p));
      EXPECT_NEAR(p.motion.d[k], node.joints[model.dependent[k]], 1e-12);
    }
  }
}

}  // namespace
}  // namespace jaculus::test
