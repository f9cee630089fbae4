// Textbook robots: mass matrices, bias forces and leg kinematics in closed form.

#include <gtest/gtest.h>

#include <cmath>

#include "dynamics/planar_builder.h"
#include "jaculus/dynamics/rigid_body.h"

namespace jaculus::dynamics {
namespace {

using test_support::link;
using test_support::on_fixed_base;

Motion at(const AbsoluteTree& tree, const Vector& q, const Vector& v) {
  Motion m(tree);
  EXPECT_TRUE(set_configuration(tree, q, m));
  set_rates(tree, v, m);
  return m;
}

TEST(ClosedForms, FreeRod) {
  model::PlanarModel model;
  model.bodies = {link("rod", -1, Vec2::Zero(), 3.0, Vec2(0.0, 0.25), 0.2)};
  model = test_support::with_coordinates(model, {});
  const AbsoluteTree tree(model);
  const double phi = 0.7, w = 2.0, c = 0.25;
  const Motion m = at(tree, Vector{{0.3, -0.1, phi}}, Vector{{1.0, 0.5, w}});
  // Centre of mass at c (sin, cos).
  Matrix M(3, 3);
  M << 3.0, 0.0, 3.0 * c * std::cos(phi), 0.0, 3.0, -3.0 * c * std::sin(phi),
      3.0 * c * std::cos(phi), -3.0 * c * std::sin(phi), 0.2 + 3.0 * c * c;
  EXPECT_LT((mass_matrix(tree, m) - M).cwiseAbs().maxCoeff(), 1e-15);
  const Vector h{{-3.0 * c * w * w * std::sin(phi), 3.0 * (kGravity - c * w * w * std::cos(phi)),
                  -3.0 * kGravity * c * std::sin(phi)}};
  EXPECT_LT((bias(tree, m) - h).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(ClosedForms, DoublePendulum) {
  const double m1 = 1.1, m2 = 0.7, l1 = 0.5, c1 = 0.2, c2 = 0.3, i1 = 0.03, i2 = 0.02;
  const AbsoluteTree tree(on_fixed_base({link("first", 0, Vec2::Zero(), m1, Vec2(0.0, c1), i1),
                                         link("second", 1, Vec2(0.0, l1), m2, Vec2(0.0, c2), i2)},
                                        {"first", "second"}));
  const Vector q{{0.4, 1.1}}, v{{1.3, -2.2}};
  const Motion m = at(tree, q, v);
  const double cosine = std::cos(q[1]), k = m2 * l1 * c2 * std::sin(q[1]);
  const double m12 = i2 + m2 * (c2 * c2 + l1 * c2 * cosine), m22 = i2 + m2 * c2 * c2;
  Matrix M(2, 2);
  M << i1 + i2 + m1 * c1 * c1 + m2 * (l1 * l1 + c2 * c2 + 2.0 * l1 * c2 * cosine), m12, m12, m22;
  EXPECT_LT((mass_matrix(tree, m) - M).cwiseAbs().maxCoeff(), 1e-15);
  const double g2 = -m2 * kGravity * c2 * std::sin(q[0] + q[1]);
  const double g1 = -(m1 * c1 + m2 * l1) * kGravity * std::sin(q[0]) + g2;
  const Vector h{{-k * (2.0 * v[0] * v[1] + v[1] * v[1]) + g1, k * v[0] * v[0] + g2}};
  EXPECT_LT((bias(tree, m) - h).cwiseAbs().maxCoeff(), 1e-14);
}

/// Links of 0.1 and 0.2 m on one hip with a mass at the pin: its height is -(sqrt(l2^2 - l1^2 sin^2
/// q) - l1 cos q) where both motors stand at q, and the mass matrix in the directions together and
/// apart is m (dr/dq)^2 and m r^2.
TEST(ClosedForms, SymmetricFiveBarLeg) {
  model::PlanarModel model =
      on_fixed_base({link("a", 0, Vec2::Zero(), 0.0, Vec2::Zero(), 0.0, -1.0),
                     link("b", 0, Vec2::Zero(), 0.0, Vec2::Zero(), 0.0),
                     link("a_knee", 1, Vec2(0.0, 0.1), 2.0, Vec2(0.0, -0.2), 0.0, -1.0),
                     link("b_knee", 2, Vec2(0.0, 0.1), 0.0, Vec2::Zero(), 0.0)},
                    {"a", "b"});
  model.loops = {{"leg", 3, Vec2(0.0, -0.2), 4, Vec2(0.0, -0.2), 1.0}};
  model.dependent = {3, 4};
  const AbsoluteTree tree(model);
  for (const double angle : {0.5, 1.0, 1.57, 2.4}) {
    const Motion m = at(tree, Vector{{angle, angle}}, Vector::Zero(2));
    const double s = 0.1 * std::sin(angle), root = std::sqrt(0.04 - s * s),
                 r = root - 0.1 * std::cos(angle);
    EXPECT_LT((point_position({{1.0, tree.loops[0].a}}, m) - Vec2(0.0, -r)).norm(), 1e-15);
    const double slope = 0.1 * std::sin(angle) - s * 0.1 * std::cos(angle) / root;
    const Vector together{{1.0, 1.0}}, apart{{1.0, -1.0}};
    const Matrix M = mass_matrix(tree, m);
    EXPECT_NEAR(together.dot(M * together), 2.0 * slope * slope, 1e-15);
    EXPECT_NEAR(apart.dot(M * apart), 2.0 * r * r, 1e-14);
    EXPECT_NEAR(together.dot(M * apart), 0.0, 1e-15);
  }
}

TEST(ClosedForms, LoopOutOfReachIsAStatus) {
  model::PlanarModel model =
      on_fixed_base({link("a", 0, Vec2(-0.3, 0.0), 0.1, Vec2::Zero(), 0.0, -1.0),
                     link("b", 0, Vec2(0.3, 0.0), 0.1, Vec2::Zero(), 0.0),
                     link("a_knee", 1, Vec2(0.0, 0.1), 0.1, Vec2::Zero(), 1e-3, -1.0),
                     link("b_knee", 2, Vec2(0.0, 0.1), 0.1, Vec2::Zero(), 1e-3)},
                    {"a", "b"});
  model.loops = {{"leg", 3, Vec2(0.0, -0.2), 4, Vec2(0.0, -0.2), 1.0}};
  model.dependent = {3, 4};
  const AbsoluteTree tree(model);
  Motion m(tree);
  // knees 0.8 m apart, links of 0.2 m
  EXPECT_FALSE(set_configuration(tree, Vector{{1.5, 1.5}}, m));
}

/// Two feet at one place hold each other: no unique forces, so a status and not a number.
TEST(ClosedForms, RedundantStanceIsAStatus) {
  model::PlanarModel model;
  model.bodies = {link("body", -1, Vec2::Zero(), 3.0, Vec2::Zero(), 0.2)};
  model.feet = {{"one", 0, Vec2(0.1, 0.0), 1}, {"two", 0, Vec2(-0.1, 0.0), 1}};
  model = test_support::with_coordinates(model, {});
  const AbsoluteTree tree(model);
  const Vector v{{0.2, -1.0, 0.3}};
  const Motion m = at(tree, Vector{{0.0, 0.0, 0.2}}, v);
  EXPECT_TRUE(forward_dynamics(tree, m, Vector::Zero(3), {0}).ok);
  EXPECT_FALSE(forward_dynamics(tree, m, Vector::Zero(3), {0, 1}).ok);
  EXPECT_FALSE(plastic_impact(tree, m, v, {0, 1}).ok);
}

/// A rod falling flat on one end: the impulse of a rigid rod struck at its tip, m v / (1 + m c^2 /
/// I).
TEST(ClosedForms, RodLandingOnItsTip) {
  const double mass = 2.0, half = 0.4, inertia = mass * half * half / 3.0, speed = 1.7;
  model::PlanarModel model;
  model.bodies = {link("rod", -1, Vec2::Zero(), mass, Vec2::Zero(), inertia)};
  model.feet = {{"tip", 0, Vec2(half, 0.0), 1}};
  model = test_support::with_coordinates(model, {});
  const AbsoluteTree tree(model);
  const Vector v{{0.0, -speed, 0.0}};
  const ContactSolution x = plastic_impact(tree, at(tree, Vector::Zero(3), v), v, {0});
  ASSERT_TRUE(x.ok);
  // a quarter of m v
  EXPECT_NEAR(x.force[1], mass * speed / (1.0 + mass * half * half / inertia), 1e-14);
  EXPECT_NEAR(x.force[0], 0.0, 1e-14);
  // about +y an upward push in front turns nose-up
  EXPECT_NEAR(x.motion[2], -x.force[1] * half / inertia, 1e-14);
}

}  // namespace
}  // namespace jaculus::dynamics
