// The robot that exports are played on, where its file can't be played as it is: five-bars whose
// chains lie side by side, in planes that may lean.

#include "long/played_robot.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "jaculus/model/propose.h"
#include "jaculus/model/urdf.h"
#include "long/planar_pose.h"
#include "model/support.h"

namespace jaculus::test {
namespace {

/// One chain of a five-bar, `y` to the left on a frame that leans; its lower link ends 0.2 m below.
std::string chain(const std::string& name, const std::string& frame, double x, double y) {
  const auto link = [](const std::string& link_name, double com, const std::string& shape) {
    return fmt::format(
        "<link name=\"{}\"><inertial><origin xyz=\"0 0 {}\"/><mass value=\"0.1\"/><inertia "
        "ixx=\"0.01\" iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" "
        "iyz=\"0\"/></inertial>{}</link>",
        link_name, com, shape);
  };
  const auto joint = [](const std::string& joint_name, const std::string& parent,
                        const std::string& child, const std::string& at, int effort) {
    return fmt::format(
        "<joint name=\"{}\" type=\"continuous\"><parent link=\"{}\"/><child link=\"{}\"/><origin "
        "xyz=\"{}\"/><axis xyz=\"0 1 0\"/><limit effort=\"{}\" velocity=\"30\"/></joint>",
        joint_name, parent, child, at, effort);
  };
  const std::string toe =
      "<collision><origin xyz=\"0 0 -0.2\"/><geometry><sphere radius=\"0.01\"/></geometry>"
      "</collision>";
  return link(name + "_upper", -0.05, "") + link(name + "_lower_foot", -0.1, toe) +
         joint(name + "_motor", frame, name + "_upper", fmt::format("{} {} 0", x, y), 10) +
         joint(name + "_knee", name + "_upper", name + "_lower_foot", "0 0 -0.1", 0);
}

/// Five-bars at four hips, their chains 3 cm apart sideways, left and right frames leaning apart.
std::string robot_text(double lean) {
  const std::string trunk =
      "<inertial><mass value=\"5\"/><inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" "
      "ixz=\"0\" iyz=\"0\"/></inertial>";
  std::string text = "<robot name=\"m\"><link name=\"trunk\">" + trunk + "</link>";
  for (const int side : {1, -1}) {
    const std::string name = side > 0 ? "left" : "right";
    text += fmt::format(
        "<link name=\"{0}_frame\"/><joint name=\"{0}_fixed\" type=\"fixed\"><parent "
        "link=\"trunk\"/><child link=\"{0}_frame\"/><origin xyz=\"0 {1} 0\" rpy=\"{2} 0 0\"/>"
        "</joint>",
        name, 0.1 * side, side * lean);
    for (const double x : {0.2, -0.2})
      for (const char* which : {"a", "b"})
        text += chain(fmt::format("{}_{}_{}", x > 0.0 ? "front" : "rear", name, which),
                      name + "_frame", x, *which == 'a' ? 0.015 * side : -0.015 * side);
  }
  return text + "</robot>";
}

struct Imported {
  testing::Folder folder;
  model::Robot robot;
  Ends ends;
};

/// Imported, at rest in the air.
std::unique_ptr<Imported> imported(double lean) {
  auto result = std::make_unique<Imported>();
  const std::string text = robot_text(lean);
  const model::Proposal proposal = model::propose_robot(model::parse_urdf(text, "robot.urdf"));
  result->folder.write("robot.urdf", text);
  result->folder.write("robot.yaml", proposal.yaml);
  result->robot = model::read_robot(result->folder.path());
  result->ends.first_base = result->ends.last_base = Eigen::Vector3d(0.0, 0.5, 0.0);
  result->ends.first = proposal.rest;
  return result;
}

/// Largest force of a pin along y, per unit of its force in the plane, with every motor pulling.
double sideways_share(PlayedRobot& robot) {
  const mjModel& m = robot.model();
  mjData& d = robot.data();
  for (int v = 6; v < m.nv; ++v) d.qfrc_applied[v] = v % 2 == 0 ? 1.0 : -0.5;
  mj_forward(&m, &d);

  double sideways = 0.0, in_plane = 0.0;
  for (int e = 0; e < m.neq; ++e) {
    const double* force = d.efc_force + 3 * e;
    sideways = std::max(sideways, std::abs(force[1]));
    in_plane = std::max(in_plane, std::hypot(force[0], force[2]));
  }
  return sideways / in_plane;
}

TEST(PlayedRobot, PinsOfChainsSideBySideAreOneAxle) {
  for (const double lean : {0.0, 0.05}) {
    SCOPED_TRACE(lean);
    const std::unique_ptr<Imported> m = imported(lean);
    ASSERT_EQ(m->robot.planar.loops.size(), 2u);
    PlayedRobot robot(m->robot.planar, m->robot.urdf, model::read_tree(m->folder.path()), m->ends);
    ASSERT_EQ(robot.model().neq, 4);
    mj_forward(&robot.model(), &robot.data());
    ASSERT_EQ(robot.data().ne, 12);
    // what the solver has to pull together
    for (int row = 0; row < robot.data().ne; ++row)
      EXPECT_NEAR(robot.data().efc_pos[row], 0.0, 1e-12) << "row " << row;
    // a pin that leans takes a share of its load along y
    EXPECT_LT(sideways_share(robot), std::tan(lean) + 1e-3);
  }
}

TEST(PlayedRobot, StandsOnItsOwnFloorNotOnThePlansLimitOfFriction) {
  const std::unique_ptr<Imported> m = imported(0.0);
  const double own = m->robot.planar.friction;
  transcription::Problem problem;
  problem.friction = 0.5 * own;
  problem.locks = {{"pitch", 0.1}};
  ASSERT_LT(transcription::planning_model(problem, m->robot.planar).friction, own);

  const model::PlanarModel played = played_model(problem, m->robot.planar);
  EXPECT_EQ(played.friction, own);
  EXPECT_FALSE(played.base_free[2]);  // what the plan locks is locked
}

TEST(PlayedRobot, TorquesAreHeldAgainstTheProblemsLimits) {
  const std::unique_ptr<Imported> m = imported(0.0);
  transcription::Problem problem;
  EXPECT_EQ(planned_limit(problem, m->robot.planar, "front_right_a_motor"), 10.0);
  problem.torque = 4.0;
  EXPECT_EQ(planned_limit(problem, m->robot.planar, "front_right_a_motor"), 4.0);
  EXPECT_EQ(planned_limit(problem, m->robot.planar, "front_right_a_knee"), kInfinity);
}

TEST(PlayedRobot, FeetLieInThePlaneThatTheirLegTurnsInAsHighAsPlanned) {
  const double lean = 0.05;
  const std::unique_ptr<Imported> m = imported(lean);
  const model::PlanarModel& planar = m->robot.planar;
  PlayedRobot robot(planar, m->robot.urdf, model::read_tree(m->folder.path()), m->ends);
  const mjModel& model = robot.model();
  mj_kinematics(&model, &robot.data());
  const int floor = mj_name2id(&model, mjOBJ_GEOM, "floor_of_play");
  ASSERT_GE(floor, 0);

  const std::vector<Eigen::Vector3d> places =
      place_bodies(planar, m->ends.first_base, m->ends.first);
  const model::PlanarPoint& foot = planar.feet.at(0);
  const Eigen::Vector3d& shank = places.at(static_cast<std::size_t>(foot.body));
  const double planned = shank.y() + (Eigen::Rotation2Dd(-shank[2]) * foot.position).y();
  int feet = 0;
  for (int g = 0; g < model.ngeom; ++g) {
    const char* name = mj_id2name(&model, mjOBJ_GEOM, g);
    if (name == nullptr || !std::string(name).starts_with("foot_of_play")) continue;
    ++feet;
    // in the frame of the lower link, whose joint turns about y
    EXPECT_NEAR(model.geom_pos[3 * g + 1], 0.0, 1e-12) << name;
    const double radius = model.geom_size[3 * g];
    const double above = robot.data().geom_xpos[3 * g + 2] - model.geom_pos[3 * floor + 2] - radius;
    EXPECT_NEAR(above, planned, 1e-5) << name;  // MuJoCo's file has six digits
  }
  EXPECT_EQ(feet, 4);
}

/// The same robot in a file whose forward is its -x leaves the floor in the same pose.
TEST(PlayedRobot, AFileThatLiesBackwardsIsTurnedAsItsAxesSay) {
  const std::unique_ptr<Imported> m = imported(0.0);
  const std::string yaml = read_text_file(m->folder.path() / "robot.yaml", "robot");
  const std::string forwards = "\nformat: jaculus-robot/1\n";
  const std::size_t at = yaml.find(forwards);
  ASSERT_NE(at, std::string::npos);
  std::string turned = yaml;
  turned.insert(at + forwards.size(), "axes: {forward: -x, up: +z}\n");
  m->folder.write("robot.yaml", turned);
  m->ends.first_base[2] = 0.1;

  const model::Robot robot = model::read_robot(m->folder.path());
  PlayedRobot played(robot.planar, robot.urdf, played_tree(robot, {}), m->ends);
  mj_kinematics(&played.model(), &played.data());
  EXPECT_LT((played.base() - m->ends.first_base).norm(), 1e-12);
  EXPECT_NEAR(played.out_of_plane()[1], 0.0, 1e-6);
  const std::vector<Eigen::Vector3d> places =
      place_bodies(robot.planar, m->ends.first_base, m->ends.first);
  for (int b = 1; b < count_of(robot.planar.bodies); ++b) {
    for (const int side : played.sides(b))
      EXPECT_NEAR(played.data().xpos[3 * side], places[static_cast<std::size_t>(b)].x(), 1e-6);
  }
}

/// A trunk on slides and a hinge, as planar files have it, with a leg whose hip has two joints.
TEST(PlayedRobot, APlanarFileIsPlayedFromItsBaseOnAndLinksWithoutMassToo) {
  const auto link = [](const std::string& name, double mass) {
    const std::string inertial = fmt::format(
        "<inertial><origin xyz=\"0 0 -0.1\"/><mass value=\"{}\"/><inertia ixx=\"0.01\" "
        "iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>",
        mass);
    return fmt::format("<link name=\"{}\">{}</link>", name, mass > 0.0 ? inertial : "");
  };
  const auto joint = [](const std::string& name, const std::string& type, const std::string& parent,
                        const std::string& child, const std::string& axis) {
    return fmt::format(
        "<joint name=\"{}\" type=\"{}\"><parent link=\"{}\"/><child link=\"{}\"/><axis "
        "xyz=\"{}\"/><limit lower=\"-2\" upper=\"2\" effort=\"9\" velocity=\"9\"/></joint>",
        name, type, parent, child, axis);
  };
  const testing::Folder folder;
  folder.write("robot.urdf", "<robot name=\"m\">" + link("world", 0) + link("a", 0) + link("b", 0) +
                                 link("trunk", 5) + link("hip", 0) + link("leg", 1) +
                                 joint("x", "prismatic", "world", "a", "1 0 0") +
                                 joint("z", "prismatic", "a", "b", "0 0 1") +
                                 joint("pitch", "revolute", "b", "trunk", "0 1 0") +
                                 joint("abduct", "revolute", "trunk", "hip", "1 0 0") +
                                 joint("swing", "revolute", "hip", "leg", "0 1 0") + "</robot>");
  folder.write("robot.yaml",
               "format: jaculus-robot/1\nbase_link: trunk\nbase: floating\nfriction: 0.8\n"
               "fixed_joints: {abduct: 0}\nfeet: {foot: {link: leg, point: [0, -0.2]}}\n");
  const model::Robot robot = model::read_robot(folder.path());
  Ends ends;
  ends.first_base = ends.last_base = Eigen::Vector3d(0.3, 0.5, 0.1);
  ends.first = {{"swing", 0.4}};

  const BodiesFile bodies(robot);
  PlayedRobot played(robot.planar, bodies.path(), played_tree(robot, {}), ends);
  mj_kinematics(&played.model(), &played.data());
  EXPECT_LT((played.base() - ends.first_base).norm(), 1e-12);
  EXPECT_EQ(played.model().nv, 6 + 2);  // a free base and the hip's two joints
  EXPECT_NEAR(mj_getTotalmass(&played.model()), 6.0, 1e-6);
}

/// Freed of friction, joints rub as the plan's model has it.
TEST(PlayedRobot, IsFreedOfWhatThePlansModelLacks) {
  const std::unique_ptr<Imported> m = imported(0.0);
  m->robot.planar.motors[0].dry_friction = 0.3;
  PlayedRobot robot(m->robot.planar, m->robot.urdf, played_tree(m->robot, {}), m->ends);
  std::fill_n(robot.model().dof_frictionloss, robot.model().nv, 0.7);
  robot.without(Part::friction);
  const model::PlanarMotor& motor = m->robot.planar.motors[0];
  const auto& joints = m->robot.planar.bodies[static_cast<std::size_t>(motor.body)].file_joints;
  for (int j = 1; j < robot.model().njnt; ++j) {
    const std::string name = mj_id2name(&robot.model(), mjOBJ_JOINT, j);
    const bool rubs = std::any_of(joints.begin(), joints.end(),
                                  [&](const auto& joint) { return joint.name == name; });
    EXPECT_EQ(robot.model().dof_frictionloss[robot.model().jnt_dofadr[j]], rubs ? 0.3 : 0.0);
  }
}

}  // namespace
}  // namespace jaculus::test
