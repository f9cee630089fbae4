// The models of Minitaur against the published numbers and the authors' solved plans.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "jaculus/model/robot.h"
#include "jaculus/trajectory/csv.h"
#include "model/support.h"

namespace jaculus::model {
namespace {

namespace fs = std::filesystem;
using testing::kModels;

const PlanarBody& body_at(const PlanarModel& model, const std::string& joint) {
  return model.bodies.at(model.body_of_joint(joint));
}

double about_joint(const PlanarBody& body) {
  return body.inertia + body.mass * body.com.squaredNorm();
}

TEST(Minitaur, HasThePublishedMasses) {
  const PlanarModel bare = read_robot(kModels / "minitaur").planar;
  const PlanarModel tail = read_robot(kModels / "minitaur_tail").planar;
  EXPECT_NEAR(bare.total_mass(), 7.040, 1e-12);
  EXPECT_NEAR(tail.total_mass(), 7.8433, 1e-12);
  EXPECT_DOUBLE_EQ(bare.bodies[0].mass, 6.192);
  EXPECT_DOUBLE_EQ(bare.bodies[0].inertia, 0.1817);
  EXPECT_EQ(bare.bodies[0].com, Vec2(0.0, 0.0));
  const PlanarBody& upper = body_at(bare, "front_a");
  EXPECT_EQ(upper.count, 2);
  EXPECT_DOUBLE_EQ(upper.mass, 0.080);
  EXPECT_EQ(upper.com, Vec2(0.0, 0.0404));
  EXPECT_DOUBLE_EQ(upper.inertia, 2 * 1.37e-4);
  EXPECT_EQ(upper.origin, Vec2(0.2, 0.0));
  const PlanarBody& toe = body_at(bare, "rear_a_knee");
  EXPECT_DOUBLE_EQ(toe.mass, 0.162);
  EXPECT_DOUBLE_EQ(toe.com.y(), -0.14);
  EXPECT_DOUBLE_EQ(toe.inertia, 2 * 3.374e-4);
  const PlanarBody& other = body_at(bare, "rear_b_knee");
  EXPECT_DOUBLE_EQ(other.mass, 0.102);
  EXPECT_DOUBLE_EQ(other.com.y(), -0.10);
  EXPECT_DOUBLE_EQ(other.inertia, 2 * 2.165e-4);
  const PlanarBody& t = body_at(tail, "tail");
  EXPECT_EQ(t.origin, Vec2(-0.1, 0.1));
  EXPECT_NEAR(t.mass, 0.1, 1e-15);
  // Shaft about the pivot by Steiner, and the scoop as a point with its own small moment.
  EXPECT_NEAR(about_joint(t), 0.0047 + 0.057 * 0.25 + 4.6e-6 + 0.043 * 0.64, 1e-12);
  EXPECT_NEAR(about_joint(t), 0.0465, 5e-5);
  // The base carries mount and rotor at the pivot: moments about the base's origin.
  const PlanarBody& base = tail.bodies[0];
  EXPECT_NEAR(about_joint(base), 0.1817 + 1e-6 + 7.2e-5 + 0.7033 * 0.02, 1e-12);
}

TEST(Minitaur, KnowsHowFarItsMassesLieFromTheirCentres) {
  const PlanarModel bare = read_robot(kModels / "minitaur").planar;
  const PlanarModel tail = read_robot(kModels / "minitaur_tail").planar;
  // (I_yy + I_zz - I_xx)/2 of mass times distance along x, (I_xx + I_yy - I_zz)/2 along z.
  const Vec2& base = bare.bodies[0].spread;
  EXPECT_NEAR(base.x(), std::sqrt(0.17335 / 6.192), 1e-12);
  EXPECT_NEAR(base.y(), std::sqrt(0.00835 / 6.192), 1e-12);
  EXPECT_GT(tail.bodies[0].spread.y(), 1.1 * base.y());  // the mount stands 0.1 m above
  for (const PlanarModel& model : {bare, tail})
    for (const PlanarBody& body : model.bodies)
      EXPECT_NEAR(body.mass * body.spread.squaredNorm(), body.inertia, 1e-12) << body.name;
}

TEST(Minitaur, HasTheCoordinatesOfTheLegs) {
  const PlanarModel m = read_robot(kModels / "minitaur_tail").planar;
  std::vector<std::string> names;
  for (const Coordinate& c : m.coordinates) names.push_back(c.name);
  EXPECT_EQ(names, (std::vector<std::string>{"x", "z", "pitch", "front_extension", "front_angle",
                                             "rear_extension", "rear_angle", "tail"}));
  EXPECT_FALSE(m.coordinates[1].angular);
  EXPECT_TRUE(m.coordinates[2].angular);
  EXPECT_DOUBLE_EQ(m.coordinates[3].range.lower, 0.4);
  EXPECT_DOUBLE_EQ(m.coordinates[3].range.upper, M_PI - 0.4);
  EXPECT_DOUBLE_EQ(m.coordinates[7].range.lower, -M_PI / 2);
  Vector q(8);
  q << 9, 9, 9, 1.0, 0.2, 1.5, -0.3, 0.7;
  const Vector theta = m.joint_map * q + m.joint_offset;
  // extension = (a + b)/2, angle = (b - a)/2
  EXPECT_DOUBLE_EQ(theta[m.body_of_joint("front_a")], 0.8);
  EXPECT_DOUBLE_EQ(theta[m.body_of_joint("front_b")], 1.2);
  EXPECT_DOUBLE_EQ(theta[m.body_of_joint("rear_a")], 1.8);
  EXPECT_DOUBLE_EQ(theta[m.body_of_joint("rear_b")], 1.2);
  EXPECT_DOUBLE_EQ(theta[m.body_of_joint("tail")], 0.7);
  EXPECT_EQ(m.dependent.size(), 4u);
  for (const int b : m.dependent) EXPECT_TRUE(m.joint_map.row(b).isZero(0.0));
}

TEST(Minitaur, HasTheMotorsAndTheScoop) {
  const PlanarModel m = read_robot(kModels / "minitaur_tail").planar;
  ASSERT_EQ(m.motors.size(), 5u);
  const PlanarMotor& leg = m.motors[m.motor_index("rear_b")];
  EXPECT_EQ(leg.count, 2);
  EXPECT_EQ(leg.resistance, 0.186);
  EXPECT_EQ(leg.gear, 1.0);
  const PlanarMotor& tail = m.motors[m.motor_index("tail")];
  EXPECT_EQ(tail.count, 1);
  EXPECT_EQ(tail.gear, 4.0);
  EXPECT_EQ(tail.rotor_inertia, 7.2e-5);
  EXPECT_EQ(tail.saturation_cubic, 0.539);
  ASSERT_EQ(m.drags.size(), 1u);
  EXPECT_EQ(m.drags[0].kind, DragKind::distributed);
  EXPECT_EQ(m.drags[0].body, m.body_of_joint("tail"));
  EXPECT_EQ(m.drags[0].end, 1.0);
  ASSERT_EQ(m.feet.size(), 2u);
  EXPECT_EQ(m.feet[0].name, "front_foot");
  EXPECT_EQ(m.feet[0].count, 2);
}

/// Deviations of one plan from this model, over all its nodes.
struct Deviation {
  double foot = 0.0;         ///< worst, of the toe by this model from the plan's columns [m]
  double closure = 0.0;      ///< worst gap of a loop at the plan's own knee angles [m]
  double closure_rms = 0.0;  ///< root mean square of the gaps [m]
  double branch = 1.0;       ///< 1 where every node is on the stated branch, else -1
  double ground = 0.0;       ///< worst height of the feet in the first phase, where all stand [m]
};

Deviation deviation(const trajectory::Table& plan, const PlanarModel& model) {
  Deviation worst;
  double squares = 0.0;
  const auto value = [&](int row, const std::string& name) {
    const int column = plan.column(name);
    EXPECT_GE(column, 0) << name;
    return column < 0 ? kNaN : plan.values(row, column);
  };
  for (int row = 0; row < plan.values.rows(); ++row) {
    std::map<std::string, double> joints;
    for (std::size_t b = 1; b < model.bodies.size(); ++b)
      joints[model.bodies[b].joint] = value(row, model.bodies[b].joint);
    const testing::Pose base{{value(row, "x"), value(row, "z")}, value(row, "pitch")};
    const std::vector<testing::Pose> poses = testing::poses(model, base, joints);
    for (const PlanarPoint& foot : model.feet) {
      const Vec2 toe = poses[foot.body].at(foot.position);
      worst.foot =
          std::max(worst.foot,
                   (toe - Vec2(value(row, foot.name + "_x"), value(row, foot.name + "_z"))).norm());
      if (plan.phase.at(row) == plan.phase.front())
        worst.ground = std::max(worst.ground, std::abs(toe.y()));
    }
    for (const PlanarLoop& loop : model.loops) {
      const testing::Pose& a = poses[loop.body_a];
      const testing::Pose& b = poses[loop.body_b];
      const Vec2 pin = a.at(loop.point_a);
      const double gap = (pin - b.at(loop.point_b)).norm();
      worst.closure = std::max(worst.closure, gap);
      squares += gap * gap;
      const Vec2 u = b.p - a.p;
      const Vec2 v = pin - a.p;
      worst.branch =
          std::min(worst.branch, loop.branch * (u.y() * v.x() - u.x() * v.y() > 0.0 ? 1.0 : -1.0));
    }
  }
  worst.closure_rms = std::sqrt(squares / static_cast<double>(plan.values.rows() * 2));
  return worst;
}

// The plans' equality rows are relaxed by 1e-4 and stance and closure are held through rates, so
// positions drift along a plan: the loops by 0.25 mm (root mean square), notail_Vel15_V8 by more,
// which misses its torque rows too; the feet of the two slow plans (Vel15) by 0.8 and 1.6 mm.
TEST(Minitaur, AgreesWithTheSolvedPlans) {
  const fs::path data = testing::data_folder();
  if (data.empty()) {
    ASSERT_EQ(std::getenv("CI"), nullptr) << "the real data must be there: set JACULUS_DATA";
    GTEST_SKIP() << "no real data: set JACULUS_DATA or put it in ../shared/data";
  }
  int plans = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(data / "plans")) {
    if (entry.path().extension() != ".csv") continue;
    ++plans;
    const trajectory::Table plan = trajectory::read_csv(entry.path());
    const bool tail = plan.column("tail") >= 0;
    const PlanarModel model = read_robot(kModels / (tail ? "minitaur_tail" : "minitaur")).planar;
    const Deviation worst = deviation(plan, model);
    EXPECT_LT(worst.foot, 1e-8) << entry.path();
    const bool loose = entry.path().stem() == "notail_Vel15_V8";
    EXPECT_LT(worst.closure_rms, loose ? 3.6e-4 : 2.6e-4) << entry.path();
    EXPECT_LT(worst.closure, loose ? 9e-4 : 5.1e-4) << entry.path();
    EXPECT_EQ(worst.branch, 1.0) << entry.path();
    const bool slow = entry.path().stem().string().find("Vel15") != std::string::npos;
    EXPECT_LT(worst.ground, slow ? 1.7e-3 : 3e-4) << entry.path();
  }
  EXPECT_EQ(plans, 8);
}

}  // namespace
}  // namespace jaculus::model
