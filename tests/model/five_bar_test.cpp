// Proposals of loops: two chains from one hip, however the file draws them.

#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/model/propose.h"
#include "jaculus/model/robot.h"
#include "model/support.h"
#include "support/input_error.h"

namespace jaculus::model {
namespace {

using test::holds;
using testing::Imported;
using testing::imported;

Imported without_loops(const std::string& urdf) {
  ProposeOptions options;
  options.loops = false;
  return imported(urdf, options);
}

/// One chain of a leg: where its links point with all joints at zero, from straight down about +y
/// [rad], how long they are [m], and what its joints may do.
struct Drawn {
  double upper = 0.0, lower = 0.0;
  double lower_length = 0.2;
  double hip = 0.0;                             ///< of its hip, forward of the leg's place [m]
  std::string hip_range = {}, knee_range = {};  ///< "lower=... upper=..."; empty: none
};

constexpr double kUpper = 0.1;  ///< length of upper links [m]

Vec2 along(double angle, double length) {
  return {-std::sin(angle) * length, -std::cos(angle) * length};
}

std::string link(const std::string& name, double mass, const Vec2& com,
                 const std::string& shape = "") {
  return fmt::format(
      "<link name=\"{}\"><inertial><origin xyz=\"{} 0 {}\"/><mass value=\"{}\"/><inertia "
      "ixx=\"0.01\" iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" "
      "iyz=\"0\"/></inertial>{}</link>\n",
      name, com.x(), com.y(), mass, shape);
}

std::string joint(const std::string& name, const std::string& parent, const std::string& child,
                  const Vec2& at, double effort, const std::string& range) {
  return fmt::format(
      "<joint name=\"{}\" type=\"{}\"><parent link=\"{}\"/><child link=\"{}\"/><origin xyz=\"{} 0 "
      "{}\"/><axis xyz=\"0 1 0\"/><limit {} effort=\"{}\" velocity=\"9\"/></joint>\n",
      name, range.empty() ? "continuous" : "revolute", parent, child, at.x(), at.y(), range,
      effort);
}

/// Four motors at two hips, each with an upper and a lower link.
std::string five_bars(const Drawn& a = {}, const Drawn& b = {}) {
  std::string text = "<robot name=\"m\">" + link("trunk", 5, {0, 0});
  for (const double x : {0.2, -0.2}) {
    for (const Drawn* chain : {&a, &b}) {
      const std::string name =
          fmt::format("{}_{}", x > 0.0 ? "front" : "rear", chain == &a ? "a" : "b");
      const Vec2 knee = along(chain->upper, kUpper);
      const Vec2 end = along(chain->lower, chain->lower_length);
      const std::string shape = fmt::format(
          "<collision><origin xyz=\"{} 0 {}\"/><geometry><sphere radius=\"0.01\"/></geometry>"
          "</collision>",
          end.x(), end.y());
      text += link(name + "_upper", 0.2, 0.5 * knee) + link(name + "_toe", 0.1, 0.5 * end, shape) +
              joint(name + "_motor", "trunk", name + "_upper", {x + chain->hip, 0}, 10,
                    chain->hip_range) +
              joint(name + "_knee", name + "_upper", name + "_toe", knee, 0, chain->knee_range);
    }
  }
  return text + "</robot>";
}

/// Knees and pin of a loop at rest, in space.
struct AtRest {
  Vec2 knee_a, knee_b, pin_a, pin_b;
};

std::vector<AtRest> at_rest(const Imported& robot) {
  const std::vector<testing::Pose> at = testing::poses(robot.robot.planar, {}, robot.proposal.rest);
  std::vector<AtRest> legs;
  for (const PlanarLoop& loop : robot.robot.planar.loops)
    legs.push_back({at[loop.body_a].p, at[loop.body_b].p, at[loop.body_a].at(loop.point_a),
                    at[loop.body_b].at(loop.point_b)});
  return legs;
}

void expect_closed(const Imported& robot) {
  const std::vector<AtRest> legs = at_rest(robot);
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const AtRest& leg = legs[i];
    EXPECT_NEAR((leg.pin_a - leg.pin_b).norm(), 0.0, 1e-4);
    const Vec2 u = leg.knee_b - leg.knee_a;
    const Vec2 v = leg.pin_a - leg.knee_a;
    EXPECT_GT(robot.robot.planar.loops[i].branch * (u.y() * v.x() - u.x() * v.y()), 0.0);
  }
}

std::string missing(const Imported& robot) {
  return fmt::format("{}", fmt::join(robot.proposal.missing, "\n"));
}

TEST(FiveBar, TwoAlikeChainsFromOneHipAreOne) {
  const Imported m = imported(five_bars());
  ASSERT_EQ(m.robot.planar.loops.size(), 2u);
  EXPECT_EQ(m.robot.planar.size(), 3 + 4);
  EXPECT_EQ(m.robot.planar.feet.size(), 2u);
  EXPECT_EQ(m.robot.planar.motors.size(), 4u);
  EXPECT_EQ(m.robot.planar.loops[0].point_a, Vec2(0.0, -0.2));
  expect_closed(m);

  const Imported apart = without_loops(five_bars());
  EXPECT_TRUE(apart.robot.planar.loops.empty());
  EXPECT_EQ(apart.robot.planar.feet.size(), 4u);
}

TEST(FiveBar, IsTheSameHoweverItsLegsAreDrawn) {
  const std::vector<AtRest> straight = at_rest(imported(five_bars()));
  // a diamond with its knees at 50 degrees, that closes
  const double out = 50.0 * M_PI / 180.0;
  const double in = std::asin(kUpper * std::sin(out) / 0.2);
  const std::string around = fmt::format("lower=\"{}\" upper=\"{}\"", 2 * M_PI - 1, 2 * M_PI + 1);
  const std::vector<std::pair<const char*, std::string>> drawings = {
      {"a diamond", five_bars({-out, in}, {out, -in})},
      {"splayed", five_bars({-M_PI / 2, -M_PI / 2}, {M_PI / 2, M_PI / 2})},
      {"one leg up, one down", five_bars({M_PI, M_PI}, {0, 0})},
      {"a joint's zero a turn away", five_bars({-out, in, 0.2, 0.0, around}, {out, -in})}};

  for (const auto& [how, text] : drawings) {
    SCOPED_TRACE(how);
    const Imported drawn = imported(text);
    expect_closed(drawn);
    const std::vector<AtRest> legs = at_rest(drawn);
    ASSERT_EQ(legs.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_NEAR((legs[i].pin_a - straight[i].pin_a).norm(), 0.0, 1e-4);
      EXPECT_NEAR((legs[i].knee_a - straight[i].knee_a).norm(), 0.0, 1e-3);
      EXPECT_NEAR((legs[i].knee_b - straight[i].knee_b).norm(), 0.0, 1e-3);
    }
  }
}

TEST(FiveBar, KneesStayOnTheSidesThatTheyAreDrawnOn) {
  const double out = 50.0 * M_PI / 180.0;
  const double in = std::asin(kUpper * std::sin(out) / 0.2);
  for (const double side : {1.0, -1.0}) {
    const Imported m = imported(five_bars({-side * out, side * in}, {side * out, -side * in}));
    for (const AtRest& leg : at_rest(m)) EXPECT_GT(side * (leg.knee_a.x() - leg.knee_b.x()), 0.1);
  }
}

TEST(FiveBar, SaysWhetherItsPinIsDrawnOrAGuess) {
  const Imported closed = imported(five_bars());
  EXPECT_TRUE(holds(missing(closed), "both lower links end there with all joints at zero"));
  EXPECT_FALSE(holds(missing(closed), "is a guess"));

  const Imported open = imported(five_bars({M_PI, M_PI}, {0, 0}));
  EXPECT_TRUE(holds(missing(open), "0.2 m from both knees, where a lower link ends, is a guess"));
  EXPECT_TRUE(holds(missing(open), "the ends lie 0.6 m apart"));
  EXPECT_TRUE(holds(open.proposal.yaml, "  # 0.2 m from both knees"));
}

TEST(FiveBar, IsPinnedWhereTheShorterLowerLinkEndsAndStandsOnTheLonger) {
  Drawn longer;
  longer.lower_length = 0.225;
  for (const bool first : {true, false}) {
    const Imported m = imported(first ? five_bars(longer, {}) : five_bars({}, longer));
    ASSERT_EQ(m.robot.planar.loops.size(), 2u);
    expect_closed(m);
    for (const PlanarLoop& loop : m.robot.planar.loops) {
      EXPECT_EQ(loop.point_a, Vec2(0.0, -0.2));
      EXPECT_EQ(loop.point_b, Vec2(0.0, -0.2));
    }
    ASSERT_EQ(m.robot.planar.feet.size(), 2u);
    EXPECT_EQ(m.robot.planar.feet[0].position, Vec2(0.0, -0.225));
    const PlanarLoop& loop = m.robot.planar.loops[0];
    EXPECT_EQ(m.robot.planar.feet[0].body, first ? loop.body_a : loop.body_b);
    EXPECT_TRUE(holds(missing(m), "where the shorter lower link ends"));
  }
}

TEST(FiveBar, HipsMayLieApart) {
  Drawn front, back;
  front.hip = 0.025;
  back.hip = -0.025;
  const Imported m = imported(five_bars(front, back));
  ASSERT_EQ(m.robot.planar.loops.size(), 2u);
  expect_closed(m);
  EXPECT_NEAR(at_rest(m)[0].pin_a.x(), 0.2, 1e-4);
}

/// Angle between the lower links at the pin [rad], from the knees' distance; NaN: they can't meet.
double at_pin(const Imported& robot, double extension, double angle) {
  const PlanarModel& model = robot.robot.planar;
  Vector q = Vector::Zero(model.size());
  q[model.coordinate_index("front_extension")] = extension;
  q[model.coordinate_index("front_angle")] = angle;
  std::map<std::string, double> joints = robot.proposal.rest;
  for (const std::string name : {"front_a_motor", "front_b_motor"})
    joints[name] = model.joint_map.row(model.body_of_joint(name)).dot(q);
  const std::vector<testing::Pose> at = testing::poses(model, {}, joints);
  const PlanarLoop& loop = model.loops.front();
  const double a = loop.point_a.norm();
  const double b = loop.point_b.norm();
  const double apart = (at[loop.body_a].p - at[loop.body_b].p).squaredNorm();
  return std::acos((a * a + b * b - apart) / (2.0 * a * b));
}

TEST(FiveBar, CoordinatesOfALegKeepItFromFoldingHoweverItSwings) {
  Drawn front, back;
  front.hip = 0.01;
  back.hip = -0.01;
  for (const Imported& m : {imported(five_bars()), imported(five_bars(front, back))}) {
    const PlanarModel& model = m.robot.planar;
    ASSERT_GE(model.coordinate_index("front_extension"), 0);
    ASSERT_GE(model.coordinate_index("front_angle"), 0);
    const Bounds& extension = model.coordinates[model.coordinate_index("front_extension")].range;
    const Bounds& angle = model.coordinates[model.coordinate_index("front_angle")].range;

    double least = kInfinity, least_beyond = kInfinity;
    for (int k = 0; k <= 16; ++k) {
      const double swung = angle.lower + (angle.upper - angle.lower) * k / 16;
      for (const double end : {extension.lower, extension.upper})
        least = std::min(least, at_pin(m, end, swung));
      for (const double end : {extension.lower - 0.02, extension.upper + 0.02})
        least_beyond = std::min(least_beyond, at_pin(m, end, swung));
    }
    // sampled to a milliradian, and at nine swings
    EXPECT_GT(least, 0.2 - 0.01);
    EXPECT_LT(least, 0.2 + 0.01);
    EXPECT_FALSE(least_beyond >= 0.2 - 0.005);
  }
}

TEST(FiveBar, ALegIsLongerTheMoreItIsExtended) {
  for (const double side : {1.0, -1.0}) {
    const double out = 50.0 * M_PI / 180.0;
    const double in = std::asin(kUpper * std::sin(out) / 0.2);
    const Imported m = imported(five_bars({-side * out, side * in}, {side * out, -side * in}));
    const PlanarModel& model = m.robot.planar;
    const int extension = model.coordinate_index("front_extension");
    ASSERT_GE(extension, 0);
    std::map<std::string, double> longer = m.proposal.rest;
    for (const char* name : {"front_a_motor", "front_b_motor"})
      longer[name] += 0.2 * model.joint_map(model.body_of_joint(name), extension);
    const auto knees = [&](const std::map<std::string, double>& joints) {
      const std::vector<testing::Pose> at = testing::poses(model, {}, joints);
      return at[model.loops[0].body_a].p.y() + at[model.loops[0].body_b].p.y();
    };
    EXPECT_LT(knees(longer), knees(m.proposal.rest) - 0.01);
  }
}

TEST(FiveBar, MotorsWithRangesOfTheirOwnStayCoordinates) {
  Drawn ranged;
  ranged.hip_range = "lower=\"-3\" upper=\"3\"";
  const Imported m = imported(five_bars(ranged, {}));
  ASSERT_EQ(m.robot.planar.loops.size(), 2u);
  EXPECT_EQ(m.robot.planar.coordinate_index("front_extension"), -1);
  EXPECT_GE(m.robot.planar.coordinate_index("front_a_motor"), 0);
}

TEST(FiveBar, ChainsThatCannotMeetStayOpenOnFeetOfTheirOwn) {
  // b hangs straight down, a's knee is bent
  Drawn a, b;
  a.knee_range = "lower=\"1.9\" upper=\"2\"";
  b.hip_range = b.knee_range = "lower=\"-0.1\" upper=\"0.1\"";
  const Imported m = imported(five_bars(a, b));
  EXPECT_TRUE(m.robot.planar.loops.empty());
  ASSERT_EQ(m.robot.planar.feet.size(), 4u);
  EXPECT_EQ(m.robot.planar.feet[1].name, "front_b_foot");
  EXPECT_TRUE(holds(missing(m), "left open after all"));
  EXPECT_TRUE(holds(m.proposal.yaml, "# fill in if a pin joins these two chains"));
  EXPECT_TRUE(holds(m.proposal.yaml, "#   \"rear_leg\":"));
  // one section, whatever a user takes the marks away from
  EXPECT_EQ(m.proposal.yaml.find("# loops:"), m.proposal.yaml.rfind("# loops:"));
}

TEST(FiveBar, UnlikeChainsAreLeftApartWithTheLinesForAPin) {
  Drawn longer;
  longer.lower_length = 0.3;
  const Imported m = imported(five_bars({}, longer));
  EXPECT_TRUE(m.robot.planar.loops.empty());
  EXPECT_EQ(m.robot.planar.feet.size(), 4u);
  EXPECT_TRUE(holds(missing(m), "a five-bar's would be alike"));
  EXPECT_TRUE(holds(m.proposal.yaml, "left open: they aren't alike"));
  EXPECT_TRUE(without_loops(five_bars({}, longer)).proposal.yaml.find("loops") ==
              std::string::npos);
}

}  // namespace
}  // namespace jaculus::model
