// A robot file of somebody else's, from the file to a simulation, through the program.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "cli/program.h"
#include "jaculus/core/installation.h"
#include "jaculus/trajectory/dataset.h"
#include "support/input_error.h"
#include "support/robot_texts.h"
#include "support/temporary_folder.h"

namespace jaculus::cli {
namespace {

using nlohmann::json;
using test::bytes_of;
using test::expect_refusal;
using test::holds;
using test::Outcome;
using test::run_program;
using test::TemporaryFolder;

void write(const std::string& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

TEST(RobotImport, AQuadrupedIsImportedLoadedAndStands) {
  const TemporaryFolder folder;
  write(folder / "hound.urdf", test::quadruped_urdf());
  const std::string out = folder / "hound";
  const Outcome import = run_program({"robot", "import", folder / "hound.urdf", "--out", out});
  ASSERT_EQ(import.exit_code, 0) << import.err;
  EXPECT_TRUE(holds(import.out, "hound: 5 planar bodies, 12 kg, 7 coordinates, 4 motors"));
  EXPECT_TRUE(holds(import.out, "assumed: unknown element <contact> in <link>: skipped (4 times"));
  EXPECT_TRUE(holds(import.out, "dropped: sideways places of 6 kg"));

  const Outcome check = run_program({"check", out});
  EXPECT_EQ(check.exit_code, 0) << check.err;

  const Outcome stand = run_program({"simulate", out + "/stand.yaml", "--out", folder / "stand"});
  ASSERT_EQ(stand.exit_code, 0) << stand.err;
  const trajectory::Dataset dataset = trajectory::read_dataset(folder / "stand");
  const trajectory::Stream& mocap = dataset.trials.at(0).streams.at(0);
  const Eigen::Index last = mocap.time.size() - 1;
  const int z = mocap.channel("z");
  const int pitch = mocap.channel("pitch");
  // it sags under its weight by less than its gains allow, and doesn't tip over
  EXPECT_NEAR(mocap.values(z, 0), 0.3, 0.002);
  EXPECT_NEAR(mocap.values(z, last), 0.3, 0.02);
  EXPECT_NEAR(mocap.values(pitch, last), 0.0, 0.02);
}

TEST(RobotImport, OfMjcfTheFrictionOfFeetIsKept) {
  const TemporaryFolder folder;
  const std::string text = test::kHopperMjcf;
  write(folder / "hopper.xml",
        std::regex_replace(text, std::regex("<worldbody>"),
                           "<default><geom friction=\".4 .1 .1\"/></default><worldbody>"));
  const std::string out = folder / "hopper";
  const Outcome import = run_program({"robot", "import", folder / "hopper.xml", "--out", out});
  if (holds(import.err, "made without it")) GTEST_SKIP() << "no MuJoCo";
  ASSERT_EQ(import.exit_code, 0) << import.err;
  EXPECT_TRUE(holds(bytes_of(out + "/robot.yaml"), "friction: 0.4   # of the feet, by the file"));
  EXPECT_FALSE(holds(import.out, "friction: 0.8"));
}

TEST(RobotImport, TheLeapThatItProposesIsSolvedVerifiedAndExported) {
  const TemporaryFolder folder;
  write(folder / "hound.urdf", test::quadruped_urdf());
  const std::string out = folder / "hound";
  const Outcome import = run_program({"robot", "import", folder / "hound.urdf", "--out", out});
  ASSERT_EQ(import.exit_code, 0) << import.err;

  const Outcome solve = run_program({"solve", out + "/leap.yaml", "--out", folder / "leap"});
  ASSERT_EQ(solve.exit_code, 0) << solve.out << solve.err;
  EXPECT_TRUE(holds(solve.out, "verification: passed"));
  // of several optima the best
  EXPECT_TRUE(holds(solve.out, "of 4 starts converged")) << solve.out;
  const Outcome exported = run_program(
      {"export", folder / "leap", "--as", "csv", "--rate", "1000", "--out", folder / "t.csv"});
  EXPECT_EQ(exported.exit_code, 0) << exported.err;

  // the testbed plays it on the same folder, its abduction held
  const Outcome played = run_program({"testbed", "run", folder / "leap/plan.csv", "--robot", out,
                                      "--trials", "1", "--out", folder / "bed"});
  EXPECT_TRUE(played.exit_code == 0 || holds(played.err, "without MuJoCo")) << played.err;
}

TEST(RobotImport, FaultsOfItsLineAreItsOwn) {
  const Outcome two = run_program({"robot", "import", "a.urdf", "b.urdf", "--tail", "10 %"});
  EXPECT_EQ(two.exit_code, 2);
  EXPECT_TRUE(holds(two.err, "robot import: ")) << two.err;
  EXPECT_TRUE(holds(two.err, "b.urdf")) << two.err;
  const Outcome flag = run_program({"robot", "import", "a.urdf", "--tial", "10 %"});
  EXPECT_TRUE(holds(flag.err, "robot import: unknown flag '--tial', did you mean '--tail'?"))
      << flag.err;
}

TEST(RobotImport, DryFrictionOnLightLinksIsNoHindranceToAPlan) {
  const TemporaryFolder folder;
  std::string rubbing = test::quadruped_urdf();
  const auto all = [&](const char* what, const char* with) {
    rubbing = std::regex_replace(rubbing, std::regex(what), with);
  };
  all("<mass value=\"0.2\"/><inertia ixx=\"2e-3\" iyy=\"3e-3\" izz=\"2e-3\"",
      "<mass value=\"0.05\"/><inertia ixx=\"1e-4\" iyy=\"1e-4\" izz=\"1e-4\"");
  all("(upper=\"-0.9\" effort=\"25\" velocity=\"20\"/>)", "$1<dynamics friction=\"0.5\"/>");
  write(folder / "hound.urdf", rubbing);
  const std::string out = folder / "hound";
  const Outcome import = run_program({"robot", "import", folder / "hound.urdf", "--out", out});
  ASSERT_EQ(import.exit_code, 0) << import.err;
  ASSERT_TRUE(holds(bytes_of(out + "/robot.yaml"), "dry_friction: 0.5"));

  // in the equations of motion it keeps the second start from converging
  write(out + "/coarse.yaml",
        "format: jaculus-problem/1\nextends: leap.yaml\nname: coarse\n"
        "refinement: {max_rounds: 0}\nsolver: {starts: 2}\n");
  const Outcome solve = run_program({"solve", out + "/coarse.yaml", "--json"});
  ASSERT_EQ(solve.exit_code, 0) << solve.err;
  EXPECT_TRUE(holds(json::parse(solve.out)["warnings"].dump(), "2 of 2 starts converged"));

  // a robot.yaml that has it not says what a plan can't know
  const std::string yaml = bytes_of(out + "/robot.yaml");
  write(out + "/robot.yaml", std::regex_replace(yaml, std::regex(", dry_friction: 0.5"), ""));
  const Outcome unknowing = run_program({"solve", out + "/coarse.yaml", "--json"});
  EXPECT_TRUE(holds(json::parse(unknowing.out)["warnings"].dump(),
                    "robot.urdf states dry friction [N m] that robot.yaml has not"));
  EXPECT_TRUE(holds(run_program({"check", out}).out, "plans and simulations don't know it"));
}

TEST(RobotImport, ALimbThatBearsNothingIsHeldByGainsOfItsOwn) {
  const TemporaryFolder folder;
  write(folder / "hound.urdf", test::quadruped_with_limb(0.2, 0.05, "0.15 0 0"));
  const std::string out = folder / "hound";
  ASSERT_EQ(run_program({"robot", "import", folder / "hound.urdf", "--out", out}).exit_code, 0);
  const Outcome stand = run_program({"simulate", out + "/stand.yaml", "--out", folder / "stand"});
  EXPECT_EQ(stand.exit_code, 0) << stand.out;
}

TEST(RobotImport, WhyAnExperimentDidNotEndIsPrintedQuietlyToo) {
  const TemporaryFolder folder;
  write(folder / "hound.urdf", test::quadruped_with_limb(0.2, 0.05, "0.15 0 0"));
  const std::string out = folder / "hound";
  ASSERT_EQ(run_program({"robot", "import", folder / "hound.urdf", "--out", out}).exit_code, 0);
  std::string stand = bytes_of(out + "/stand.yaml");
  // without gains of its own the finger has those of a leg
  stand = std::regex_replace(stand, std::regex(", \"wrist\": [0-9.e-]+"), "");
  write(out + "/stand.yaml", stand);

  const Outcome quiet = run_program({"simulate", out + "/stand.yaml", "--quiet"});
  EXPECT_EQ(quiet.exit_code, 1);
  EXPECT_EQ(quiet.out, "");
  EXPECT_TRUE(holds(quiet.err, "jaculus: trial_01: at 0.")) << quiet.err;
}

TEST(RobotImport, PlaceHoldersOfAFirstDraftAreSaidAndInertiasReplacedOnRequest) {
  const TemporaryFolder folder;
  std::string draft = test::quadruped_urdf();
  draft = std::regex_replace(draft, std::regex("ixx=\"[^\"]*\" iyy=\"[^\"]*\" izz=\"[^\"]*\""),
                             "ixx=\"100\" iyy=\"100\" izz=\"100\"");
  draft = std::regex_replace(draft, std::regex("velocity=\"[^\"]*\""), "velocity=\"0.5\"");
  write(folder / "draft.urdf", draft);

  const auto import = [&](const std::string& inertias) {
    const Outcome done = run_program({"robot", "import", folder / "draft.urdf", "--out",
                                      folder / inertias, "--inertias", inertias, "--json"});
    EXPECT_EQ(done.exit_code, 0) << done.err;
    return json::parse(done.out);
  };
  const json as_drawn = import("file");
  const json of_shapes = import("shapes");
  const auto inertia = [](const json& told) {
    return told["kept_and_dropped"]["pitch_inertia_kg_m2"].get<double>();
  };
  EXPECT_GT(inertia(as_drawn), 1300.0);
  EXPECT_LT(inertia(of_shapes), 1.0);
  EXPECT_EQ(of_shapes["kept_and_dropped"]["mass_kg"], as_drawn["kept_and_dropped"]["mass_kg"]);
  EXPECT_TRUE(holds(of_shapes["notes"].dump(), "assumed: inertias of 13 links are those of"));
  EXPECT_TRUE(holds(as_drawn["to_fill_in"].dump(), "(--inertias shapes takes those"));
  EXPECT_FALSE(holds(of_shapes["to_fill_in"].dump(), "--inertias"));
  EXPECT_TRUE(holds(of_shapes["to_fill_in"].dump(), "motors.front_hip: at the file's 0.5 rad/s"));
}

TEST(RobotImport, AFaultLeavesNoFolderBehind) {
  const TemporaryFolder folder;
  write(folder / "hound.urdf", test::quadruped_urdf());
  const std::string out = folder / "hound";
  for (const char* tail : {"abc", "-1 kg", "0", "3 m"}) {
    const Outcome bad =
        run_program({"robot", "import", folder / "hound.urdf", "--out", out, "--tail", tail});
    expect_refusal(bad);
    EXPECT_TRUE(holds(bad.err, std::string("--tail: '") + tail + "' given; allowed: a mass"));
    EXPECT_FALSE(std::filesystem::exists(out)) << tail;
  }

  // all else is well with the arm, but nothing of it bears a tail
  const Outcome arm =
      run_program({"robot", "import", (source_folder() / "models/arm/robot.urdf").string(), "--out",
                   out, "--tail", "1 kg"});
  expect_refusal(arm);
  EXPECT_TRUE(holds(arm.err, "--tail: the robot has no rear_foot"));
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(RobotImport, AnXacroFileNeedsTheProgramThatExpandsIt) {
  const TemporaryFolder folder;
  write(folder / "hound.urdf.xacro", test::quadruped_urdf());
  const std::string out = folder / "hound";
  write(folder / "xacro", "#!/bin/sh\ncat \"$1\"\n");
  std::filesystem::permissions(folder / "xacro", std::filesystem::perms::owner_all);

  const std::string path = std::getenv("PATH");
  ::setenv("PATH", folder.path().c_str(), 1);
  const Outcome without_cat =
      run_program({"robot", "import", folder / "hound.urdf.xacro", "--out", out});
  ::setenv("PATH", "/nowhere", 1);
  const Outcome without =
      run_program({"robot", "import", folder / "hound.urdf.xacro", "--out", out});
  ::setenv("PATH", (folder.path().string() + ":" + path).c_str(), 1);
  const Outcome with = run_program({"robot", "import", folder / "hound.urdf.xacro", "--out", out});
  ::setenv("PATH", path.c_str(), 1);

  expect_refusal(without);
  EXPECT_TRUE(holds(without.err, "the program xacro expands, and it is not on the PATH"))
      << without.err;
  expect_refusal(without_cat);
  EXPECT_TRUE(holds(without_cat.err, "xacro refuses it: ")) << without_cat.err;
  ASSERT_EQ(with.exit_code, 0) << with.err;
  EXPECT_TRUE(holds(with.out, "hound: 5 planar bodies, 12 kg"));
}

TEST(RobotUrdf, NeedsNoRobotYaml) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "arm");
  std::filesystem::copy_file(source_folder() / "models/arm/robot.urdf", folder / "arm/robot.urdf");
  const Outcome urdf = run_program({"robot", "urdf", folder / "arm", "--out", folder / "a.urdf"});
  EXPECT_EQ(urdf.exit_code, 0) << urdf.err;
}

TEST(RobotImport, ATailIsProposedSolvedAndSwitchedFromTheCommandLine) {
  const TemporaryFolder folder;
  write(folder / "hound.urdf", test::quadruped_urdf());
  const std::string out = folder / "hound";
  const Outcome import =
      run_program({"robot", "import", folder / "hound.urdf", "--out", out, "--tail", "10 %"});
  ASSERT_EQ(import.exit_code, 0) << import.err;
  EXPECT_TRUE(holds(import.out, "hound: 6 planar bodies, 13.2 kg, 8 coordinates, 5 motors"));
  EXPECT_TRUE(holds(run_program({"check", out}).out, "'tail' is attached to 'trunk': 1.2 kg"));

  const auto tail_and_motors = [&](const std::string& kind) {
    const Outcome solve =
        run_program({"solve", out + "/leap.yaml", "--override", "attach.tail.kind=" + kind,
                     "--json", "--out", folder / kind});
    EXPECT_EQ(solve.exit_code, 0) << solve.err;
    const json told = json::parse(solve.out);
    EXPECT_TRUE(told["verification"]["passed"].get<bool>()) << kind;
    std::vector<std::string> motors;
    for (const json& motor : told["motors"]) motors.push_back(motor["motor"]);
    return std::pair(!told["tail_momentum_share"].is_null(), motors.size());
  };
  EXPECT_EQ(tail_and_motors("drag"), std::pair(true, std::size_t{5}));
  EXPECT_EQ(tail_and_motors("none"), std::pair(false, std::size_t{4}));

  const Outcome whole = run_program({"robot", "urdf", out, "--out", folder / "whole.urdf"});
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  const Outcome again =
      run_program({"robot", "import", folder / "whole.urdf", "--out", folder / "again"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  // with a motor as strong as the tail's, 0.6 of weight times leg length
  EXPECT_TRUE(holds(again.out, "hound: 6 planar bodies, 13.2 kg, 8 coordinates, 5 motors"));

  const Outcome bad = run_program({"solve", out + "/leap.yaml", "--override", "attach.tail.kind"});
  expect_refusal(bad);
  EXPECT_TRUE(holds(bad.err, "--override: 'attach.tail.kind' given; allowed: PATH=VALUE"));
  const Outcome wing =
      run_program({"solve", out + "/leap.yaml", "--override", "attach.tail.kind=wing"});
  expect_refusal(wing);
  EXPECT_TRUE(
      holds(wing.err,
            "jaculus: --override attach.tail.kind: 'wing' given; allowed: none, inertial, drag"));
  EXPECT_FALSE(holds(wing.err, "leap_template.yaml")) << wing.err;

  const Outcome nobody = run_program({"solve", out + "/leap.yaml", "--robot", "nobody"});
  expect_refusal(nobody);
  EXPECT_TRUE(holds(nobody.err, "jaculus: --robot: unknown robot 'nobody'")) << nobody.err;
  const Outcome pendulum = run_program({"solve", out + "/leap.yaml", "--robot", "pendulum"});
  expect_refusal(pendulum);
  EXPECT_TRUE(holds(pendulum.err, "jaculus: with --robot pendulum: ")) << pendulum.err;
  EXPECT_TRUE(holds(pendulum.err, "robot 'pendulum': no feet or no gravity")) << pendulum.err;
}

TEST(SolveRobot, TheTemplateIsSolvedForARobotOfTheCommandLine) {
  const TemporaryFolder folder;
  const std::string file = (source_folder() / "problems" / "leap_template.yaml").string();
  const Outcome solve = run_program({"solve", file, "--robot", "minitaur", "--json"});
  ASSERT_EQ(solve.exit_code, 0) << solve.err;
  EXPECT_TRUE(json::parse(solve.out)["verification"]["passed"].get<bool>());
  const Outcome unknown = run_program({"solve", file, "--robot", "minitor"});
  expect_refusal(unknown);
  EXPECT_TRUE(holds(unknown.err, "unknown robot 'minitor', did you mean 'minitaur'?"));
}

TEST(RobotImport, JsonHoldsWhatWasAssumedDecidedAndDropped) {
  const TemporaryFolder folder;
  write(folder / "hound.urdf", test::quadruped_urdf());
  const Outcome import =
      run_program({"robot", "import", folder / "hound.urdf", "--out", folder / "hound", "--json"});
  ASSERT_EQ(import.exit_code, 0) << import.err;
  const json told = json::parse(import.out);
  EXPECT_EQ(told["coordinates"], 7);
  EXPECT_EQ(told["feet"], 2);
  EXPECT_EQ(told["trial"], "stand.yaml");
  EXPECT_NEAR(told["kept_and_dropped"]["mass_kg"].get<double>(), 12.0, 1e-9);
}

TEST(RobotImport, AnMjcfRobotIsImportedAndSimulated) {
  const TemporaryFolder folder;
  write(folder / "hopper.xml", test::kHopperMjcf);
  const Outcome import =
      run_program({"robot", "import", folder / "hopper.xml", "--out", folder / "hopper"});
  if (import.err.find("made without it") != std::string::npos) GTEST_SKIP() << "no MuJoCo";
  ASSERT_EQ(import.exit_code, 0) << import.err;
  const Outcome stand =
      run_program({"simulate", folder / "hopper" / "stand.yaml", "--out", folder / "stand"});
  EXPECT_EQ(stand.exit_code, 0) << stand.err;
}

TEST(RobotImport, RefusesWhatIsThereAlreadyAndWhereStrictWhatItWouldAssume) {
  const TemporaryFolder folder;
  write(folder / "hound.urdf", test::quadruped_urdf());
  const std::string out = folder / "hound";
  const Outcome strict =
      run_program({"robot", "import", folder / "hound.urdf", "--out", out, "--strict"});
  expect_refusal(strict);
  EXPECT_TRUE(holds(strict.err, "unknown element <contact> in <link>"));
  EXPECT_FALSE(std::filesystem::exists(out));

  ASSERT_EQ(run_program({"robot", "import", folder / "hound.urdf", "--out", out}).exit_code, 0);
  const Outcome again = run_program({"robot", "import", folder / "hound.urdf", "--out", out});
  expect_refusal(again);
  EXPECT_TRUE(holds(again.err, "--replace"));
  EXPECT_EQ(
      run_program({"robot", "import", folder / "hound.urdf", "--out", out, "--replace"}).exit_code,
      0);

  const Outcome checked = run_program({"check", out, "--strict"});
  expect_refusal(checked);
  EXPECT_TRUE(holds(checked.err, "robot.urdf:"));
}

}  // namespace
}  // namespace jaculus::cli
