// Robots of MJCF files: what MuJoCo reads of them, and what is proposed then.

#include "jaculus/model/mjcf.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "jaculus/model/propose.h"
#include "model/support.h"
#include "support/input_error.h"
#include "support/robot_texts.h"

namespace jaculus::model {
namespace {

using test::holds;
using test::input_error_of;
using testing::Imported;
using testing::imported;
using testing::names;

Proposal proposed_of(const std::filesystem::path& file) {
  const MjcfRobot robot = read_mjcf(file);
  ProposeOptions options;
  options.surfaces = robot.surfaces;
  return propose_robot(robot.tree, options);
}

/// The hopper, or nothing where this build has no MuJoCo.
std::optional<MjcfRobot> hopper() {
  const testing::Folder folder;
  folder.write("hopper.xml", test::kHopperMjcf);
  EXPECT_TRUE(is_mjcf(folder.path() / "hopper.xml"));
  try {
    return read_mjcf(folder.path() / "hopper.xml");
  } catch (const InputError& error) {
    EXPECT_TRUE(holds(error.what(), "made without it"));
    return {};
  }
}

TEST(Mjcf, IsReadByMujocoWithGeomsInertiasAndActuators) {
  const std::optional<MjcfRobot> mjcf = hopper();
  if (!mjcf) GTEST_SKIP() << "no MuJoCo";
  const SpatialTree& tree = mjcf->tree;
  const SpatialLink& trunk = tree.links[tree.link_index("trunk")];
  // a box of 4 kg, 0.2 x 0.1 x 0.3 m
  EXPECT_NEAR(trunk.inertia(1, 1), 4.0 / 12.0 * (0.2 * 0.2 + 0.3 * 0.3), 1e-12);
  EXPECT_EQ(tree.joints[tree.joint_index("hip")].effort, 50.0);
  EXPECT_EQ(tree.joints[tree.joint_index("knee")].effort, 30.0);
  EXPECT_EQ(mjcf->armature.at("hip"), 0.02);
  EXPECT_FALSE(mjcf->floating);
}

TEST(Mjcf, OfANewerFileWhatMujocoDoesNotKnowIsLeftOutAndSaid) {
  if (!hopper()) GTEST_SKIP() << "no MuJoCo";
  std::string newer = test::kHopperMjcf;
  newer =
      testing::replaced(newer, "<worldbody>",
                        "<option integrator=\"soon\"/>\n<statistic glitter=\"1\"/>\n<worldbody>");
  const testing::Folder folder;
  folder.write("hopper.xml", newer);
  const MjcfRobot robot = read_mjcf(folder.path() / "hopper.xml");
  const std::string notes = fmt::format("{}", fmt::join(robot.notes, "\n"));
  EXPECT_TRUE(holds(notes, "assumed: no autolimits"));
  EXPECT_TRUE(holds(notes, "assumed: 'soon' of <option>, which MuJoCo"));
  EXPECT_TRUE(holds(notes, "assumed: 'glitter' of <statistic>, which MuJoCo"));

  // the robot is the same
  const MjcfRobot same = *hopper();
  EXPECT_EQ(write_urdf(robot.tree), write_urdf(same.tree));
  EXPECT_THROW((void)read_mjcf(folder.path() / "hopper.xml", Reading::strict), InputError);
  // what is no matter of versions is refused as it was
  folder.write("hopper.xml",
               testing::replaced(newer, "<worldbody>", "<worldbody><body mass=\"1\""));
  EXPECT_THROW((void)read_mjcf(folder.path() / "hopper.xml"), InputError);
}

TEST(Mjcf, WithoutItsMeshesIsReadWhereLinksStateTheirInertias) {
  const std::optional<MjcfRobot> usual = hopper();
  if (!usual) GTEST_SKIP() << "no MuJoCo";
  const std::string drawn =
      testing::replaced(test::kHopperMjcf, "<worldbody>",
                        "<asset><mesh name=\"shell\" file=\"shell.stl\"/></asset>\n<worldbody>");
  const std::string inertial =
      "<inertial pos=\"0 0 0\" mass=\"4\" diaginertia=\"0.03 0.04 0.02\"/>";
  const std::string box = "<geom name=\"box\"";
  const std::string shell = "<geom type=\"mesh\" mesh=\"shell\"/>";
  const testing::Folder folder;
  folder.write("hopper.xml", testing::replaced(drawn, box, inertial + shell + box));
  const MjcfRobot robot = read_mjcf(folder.path() / "hopper.xml");
  const std::string notes = fmt::format("{}", fmt::join(robot.notes, "\n"));
  EXPECT_TRUE(holds(notes, "a mesh whose file isn't there"));
  const SpatialTree& tree = robot.tree;
  EXPECT_NEAR(tree.links[tree.link_index("trunk")].inertia(1, 1), 0.04, 1e-12);
  EXPECT_THROW((void)read_mjcf(folder.path() / "hopper.xml", Reading::strict), InputError);

  // a link that has its mass from the mesh can't do without
  folder.write("hopper.xml", testing::replaced(drawn, box, shell + box));
  try {
    (void)read_mjcf(folder.path() / "hopper.xml");
    ADD_FAILURE() << "read";
  } catch (const InputError& error) {
    EXPECT_TRUE(holds(error.what(), "the file of mesh 'shell' isn't there"));
  }
}

TEST(Mjcf, WithoutAMeshALinkKeepsItsStatedMassWhereGeomsGiveMasses) {
  if (!hopper()) GTEST_SKIP() << "no MuJoCo";
  const auto inertial = [](double mass) {
    return fmt::format("<inertial pos=\"0 0 0\" mass=\"{}\" diaginertia=\"0.03 0.04 0.02\"/>",
                       mass);
  };
  std::string text = testing::replaced(test::kHopperMjcf, "<compiler angle=\"radian\"/>",
                                       "<compiler angle=\"radian\" inertiafromgeom=\"true\"/>"
                                       "<asset><mesh name=\"shell\" file=\"shell.stl\"/></asset>");
  text =
      testing::replaced(text, "<geom name=\"box\"",
                        inertial(6.0) + "<geom type=\"mesh\" mesh=\"shell\"/><geom name=\"box\"");
  text =
      testing::replaced(text, "<geom type=\"capsule\"", inertial(9.0) + "<geom type=\"capsule\"");
  const testing::Folder folder;
  folder.write("hopper.xml", text);
  const MjcfRobot robot = read_mjcf(folder.path() / "hopper.xml");

  const auto mass = [&](const char* link) {
    return robot.tree.links[robot.tree.link_index(link)].mass;
  };
  EXPECT_EQ(mass("trunk"), 6.0) << "4 kg of its box are not all of it";
  EXPECT_EQ(mass("thigh"), 1.0) << "of its geom, as MuJoCo has it";
  EXPECT_TRUE(holds(fmt::format("{}", fmt::join(robot.notes, "\n")),
                    "a mesh of link 'trunk' isn't there: the link's own <inertial> counts, 6 kg"));
}

TEST(Mjcf, ComesBackFromItsUrdfAndIsPlanar) {
  const std::optional<MjcfRobot> mjcf = hopper();
  if (!mjcf) GTEST_SKIP() << "no MuJoCo";
  ProposeOptions options;
  options.armature = mjcf->armature;
  const Imported robot = imported(write_urdf(mjcf->tree), options);
  const PlanarModel& m = robot.robot.planar;
  EXPECT_EQ(m.bodies[0].name, "trunk");
  EXPECT_EQ(names(m.coordinates), (std::vector<std::string>{"x", "z", "pitch", "hip", "knee"}));
  EXPECT_NEAR(m.total_mass(), 5.5, 1e-12);
  // the hip's anchor is 0.05 m above the thigh's frame, so its link begins there
  EXPECT_NEAR(m.bodies[1].origin.y(), -0.15, 1e-12);
  EXPECT_NEAR(m.bodies[1].com.y(), -0.15 - 0.05, 1e-12);
  EXPECT_NEAR(m.bodies[2].origin.y(), -0.35, 1e-12);
  EXPECT_EQ(m.bodies[2].sign, -1.0);
  EXPECT_EQ(m.motors[0].rotor_inertia, 0.02);
  EXPECT_EQ(m.motors[0].viscous_friction, 0.1);
  EXPECT_EQ(m.motors[1].viscous_friction, 0.0);
}

TEST(Propose, ACapsulesFootIsItsLowestPointAtRest) {
  const std::optional<MjcfRobot> mjcf = hopper();
  if (!mjcf) GTEST_SKIP() << "no MuJoCo";
  const Imported robot = imported(write_urdf(mjcf->tree));
  const PlanarModel& m = robot.robot.planar;
  ASSERT_EQ(m.feet.size(), 1u);

  // the shank ends in a cap of 0.02 m about (0, -0.3)
  const Vec2 from_cap = m.feet[0].position - Vec2(0.0, -0.3);
  EXPECT_NEAR(from_cap.norm(), 0.02, 1e-6);
  const std::vector<testing::Pose> at = testing::poses(m, {}, robot.proposal.rest);
  const testing::Pose& shank = at[static_cast<std::size_t>(m.feet[0].body)];
  const Vec2 down = shank.at(m.feet[0].position) - shank.at(Vec2(0.0, -0.3));
  EXPECT_NEAR(down.x(), 0.0, 1e-6);
  EXPECT_NEAR(down.y(), -0.02, 1e-6);

  // links of 0.35 and 0.3 m and the cap, drawn in to three quarters, below the hip
  EXPECT_NEAR(shank.at(m.feet[0].position).y(), -0.15 - 0.75 * (0.35 + 0.3 + 0.02), 1e-4);
  EXPECT_TRUE(holds(fmt::format("{}", fmt::join(robot.proposal.notes, "\n")), "doesn't roll"));
}

TEST(Mjcf, FeetHaveTheFrictionOfTheirGeoms) {
  const std::optional<MjcfRobot> usual = hopper();
  if (!usual) GTEST_SKIP() << "no MuJoCo";
  const Proposal assumed = propose_robot(usual->tree, {});
  EXPECT_TRUE(holds(assumed.yaml, "friction: 0.8   # fill in"));
  EXPECT_TRUE(holds(assumed.missing.at(0), "friction: 0.8"));

  const std::string foot = "size=\"0.02\" mass=\"0.5\"", floor = "size=\"5 5 1\"";
  const auto with = [&](const std::string& of_foot, const std::string& of_floor) {
    const testing::Folder folder;
    folder.write("hopper.xml",
                 testing::replaced(testing::replaced(test::kHopperMjcf, foot, foot + " " + of_foot),
                                   floor, floor + " " + of_floor));
    return proposed_of(folder.path() / "hopper.xml");
  };
  // the larger of both, unless one has priority
  const Proposal stated = with("friction=\"0.6\"", "friction=\"0.3\"");
  EXPECT_TRUE(holds(stated.yaml,
                    "friction: 0.6   # of the feet, by the file: 'foot' (0.6) on 'world' (0.3), "
                    "of which MuJoCo takes the larger"))
      << stated.yaml;
  for (const std::string& line : stated.missing) EXPECT_FALSE(holds(line, "friction: 0.8"));
  EXPECT_TRUE(holds(with("friction=\"0.6\"", "").yaml, "friction: 1   # of the feet"));
  EXPECT_TRUE(holds(with("friction=\"0.6\" priority=\"1\"", "").yaml, "friction: 0.6   # of the"));
  EXPECT_TRUE(holds(with("friction=\"0.6\" condim=\"1\"", "condim=\"1\"").missing.at(0),
                    "friction: 0.8, rubber on a dry floor, is assumed; the file has 'foot'"));
}

TEST(Mjcf, HoldsNoJointOfTheChainThatCarriesTheBase) {
  const std::optional<MjcfRobot> robot = hopper();
  if (!robot) GTEST_SKIP() << "no MuJoCo";
  ProposeOptions options;
  options.hold = {"slide_x"};
  EXPECT_TRUE(holds(input_error_of([&] { (void)propose_robot(robot->tree, options); }),
                    "--hold: 'slide_x' is of the chain that carries the base"));
  options.hold = {"knee"};
  EXPECT_NO_THROW((void)propose_robot(robot->tree, options));
}

TEST(Mjcf, FrictionIsThatOfDefaultsAndOfPairs) {
  const std::optional<MjcfRobot> usual = hopper();
  if (!usual) GTEST_SKIP() << "no MuJoCo";
  const testing::Folder folder;
  const std::string rubbed =
      testing::replaced(test::kHopperMjcf, "<worldbody>",
                        "<default><geom friction=\".4 .1 .1\"/></default>\n<worldbody>");
  folder.write("hopper.xml", rubbed);
  const Proposal of_defaults = proposed_of(folder.path() / "hopper.xml");
  EXPECT_TRUE(holds(of_defaults.yaml, "friction: 0.4   # of the feet"));

  // a wall that comes first is no floor
  folder.write("hopper.xml",
               testing::replaced(rubbed, "<geom type=\"plane\"",
                                 "<geom name=\"wall\" type=\"plane\" euler=\"0 1.2 0\" "
                                 "pos=\"-9 0 0\" size=\"5 5 1\" friction=\"0.9 .1 .1\"/>\n"
                                 "<geom type=\"plane\""));
  EXPECT_TRUE(
      holds(proposed_of(folder.path() / "hopper.xml").yaml, "friction: 0.4   # of the feet"));

  // pairs meet whatever the masks say, and files that have them switch these off
  std::string paired = testing::replaced(
      rubbed, "type=\"plane\"", "name=\"floor\" contype=\"0\" conaffinity=\"0\" type=\"plane\"");
  paired =
      testing::replaced(paired, "size=\"0.02\" mass=\"0.5\"",
                        "name=\"toe\" contype=\"0\" conaffinity=\"0\" size=\"0.02\" mass=\"0.5\"");
  paired = testing::replaced(paired, "<actuator>",
                             "<contact><pair geom1=\"toe\" geom2=\"floor\" "
                             "friction=\"0.7 0.7 0 0 0\"/></contact>\n<actuator>");
  folder.write("hopper.xml", paired);
  const Proposal of_pair = proposed_of(folder.path() / "hopper.xml");
  EXPECT_TRUE(holds(of_pair.yaml, "friction: 0.7   # of the feet, by the file: <pair> of 'toe'"));
}

TEST(Mjcf, IsToldFromUrdfByItsFirstElement) {
  const testing::Folder folder;
  folder.write("a",
               "<?xml version=\"1.0\"?>\n<!-- <mujoco> -->\n<robot name=\"r\"><mujoco/></robot>");
  folder.write("b", "<!-- a robot -->\n<mujoco/>");
  EXPECT_FALSE(is_mjcf(folder.path() / "a"));
  EXPECT_TRUE(is_mjcf(folder.path() / "b"));
  EXPECT_FALSE(is_mjcf(folder.path() / "none"));
}

}  // namespace
}  // namespace jaculus::model
