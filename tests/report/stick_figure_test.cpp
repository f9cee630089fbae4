// Stick figures against the kinematics that they stand on, and what they do with what was not
// measured.

#include "report/render/stick_figure.h"

#include <gtest/gtest.h>

#include <cmath>

#include "jaculus/dynamics/loop_closure.h"
#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/model/robot.h"

namespace jaculus::report {
namespace {

constexpr double kTolerance = 1e-12;

model::PlanarModel minitaur() {
  return model::read_robot(model::find_robot("minitaur_tail", std::filesystem::current_path()))
      .planar;
}

/// Two samples of a motion in all coordinates, with rates.
MotionChannels two_samples(const model::PlanarModel& model, const Vector& a, const Vector& b) {
  MotionChannels channels;
  for (int i = 0; i < model.size(); ++i) {
    const std::string& name = model.coordinates[i].name;
    channels[name] = {{0.0, 0.1}, {a[i], b[i]}};
    const double rate = (b[i] - a[i]) / 0.1;
    channels[name + "_velocity"] = {{0.0, 0.1}, {rate, rate}};
  }
  return channels;
}

Vector posture(const model::PlanarModel& model, double lift) {
  Vector q = Vector::Zero(model.size());
  for (const auto& [name, value] : std::map<std::string, double>{{"z", 0.2 + lift},
                                                                 {"front_extension", 1.2},
                                                                 {"rear_extension", 1.2},
                                                                 {"tail", 0.5 - lift}})
    q[model.coordinate_index(name)] = value;
  return q;
}

const ActorBody& body(const Actor& actor, BodyKind kind) {
  for (const ActorBody& b : actor.bodies)
    if (b.kind == kind) return b;
  throw std::logic_error("no such body");
}

TEST(StickFigure, FollowsTheKinematics) {
  const model::PlanarModel model = minitaur();
  const Vector a = posture(model, 0.0), b = posture(model, 0.3);
  const Actor actor = stick_figure(model, two_samples(model, a, b), {.name = "robot"});
  ASSERT_EQ(actor.time.size(), 2U);
  const dynamics::AbsoluteTree tree(model);
  dynamics::Motion motion(tree);
  ASSERT_TRUE(dynamics::set_configuration(tree, b, motion));
  const Vec2 com = dynamics::centre_of_mass(tree, motion);
  EXPECT_NEAR(actor.com[2], com.x(), kTolerance);
  EXPECT_NEAR(actor.com[3], com.y(), kTolerance);
  const ActorBody& scoop = body(actor, BodyKind::scoop);
  const model::PlanarDrag& drag = model.drags[0];
  const Vec2 tip = position(tree.path_to(model, drag.body, drag.end * drag.direction), motion.pose);
  EXPECT_NEAR(scoop.xz[6], tip.x(), kTolerance);
  EXPECT_NEAR(scoop.xz[7], tip.y(), kTolerance);
}

TEST(StickFigure, DragOpposesTheTailAndGrowsOutwards) {
  const model::PlanarModel model = minitaur();
  Vector a = posture(model, 0.0), b = a;
  b[model.coordinate_index("tail")] += 1.0;  // 10 rad/s forwards
  const Actor actor = stick_figure(model, two_samples(model, a, b), {.name = "robot"});
  const model::PlanarDrag& drag = model.drags[0];
  std::vector<double> sizes;
  for (const ActorArrow& arrow : actor.arrows) {
    if (arrow.kind != ArrowKind::drag) continue;
    EXPECT_LT(arrow.force[0], 0.0);
    sizes.push_back(std::hypot(arrow.force[0], arrow.force[1]));
  }
  ASSERT_EQ(sizes.size(), 5U);
  EXPECT_TRUE(std::is_sorted(sizes.begin(), sizes.end()));
  // The middle of the scoop moves at 10 rad/s times its distance.
  const double speed = 10.0 * 0.5 * (drag.start + drag.end);
  EXPECT_NEAR(sizes[2], 0.5 * drag.density * drag.coefficient * drag.width * speed * speed, 1e-9);
}

TEST(StickFigure, MotorAnglesGiveTheLegsAndTheFloorTheHeight) {
  const model::PlanarModel model = minitaur();
  MotionChannels channels;
  for (const char* joint : {"front_a", "front_b", "rear_a", "rear_b"})
    channels[joint] = {{0.0, 0.1}, {1.2, 1.4}};
  channels["tail"] = {{0.0, 0.1}, {0.0, 0.0}};
  const Actor actor = stick_figure(model, channels, {.name = "log"});
  Vector q = posture(model, 0.0);
  q[model.coordinate_index("tail")] = 0.0;
  const dynamics::AbsoluteTree tree(model);
  dynamics::Motion motion(tree);
  ASSERT_TRUE(dynamics::set_configuration(tree, q, motion));
  const double height = q[model.coordinate_index("z")] - position(tree.feet[0], motion.pose).y();
  const ActorBody& base = body(actor, BodyKind::base);
  // The base's first point is a hip, at the height of the base's origin.
  EXPECT_NEAR(base.xz[1], height, 1e-9);
}

TEST(StickFigure, WhatNothingDeterminesIsNotDrawn) {
  const model::PlanarModel model = minitaur();
  MotionChannels channels;
  for (const char* coordinate : {"x", "z", "pitch"})
    channels[coordinate] = {{0.0, 0.1, 0.2}, {0.2, kNaN, 0.3}};
  const Actor actor = stick_figure(model, channels, {.name = "mocap alone"});
  ASSERT_EQ(actor.bodies.size(), 1U);
  EXPECT_EQ(actor.bodies[0].kind, BodyKind::base);
  EXPECT_TRUE(actor.com.empty()) << "the legs' place is not known";
  EXPECT_TRUE(std::isfinite(actor.bodies[0].xz[0]));
  const std::size_t row = static_cast<std::size_t>(actor.bodies[0].points) * 2;
  EXPECT_TRUE(std::isnan(actor.bodies[0].xz[row])) << "a gap in the data is a gap in the picture";
}

TEST(StickFigure, LongMotionsAreDrawnAtSoManyInstants) {
  const model::PlanarModel model = minitaur();
  MotionChannels channels;
  MotionChannel z;
  for (int i = 0; i < 10'000; ++i) {
    z.time.push_back(1e-3 * i);
    z.value.push_back(0.2 + 1e-5 * i);
  }
  channels["z"] = z;
  const Actor actor = stick_figure(model, channels, {.name = "long", .most_frames = 100});
  EXPECT_EQ(actor.time.size(), 100U);
  EXPECT_DOUBLE_EQ(actor.time.back(), z.time.back());
}

}  // namespace
}  // namespace jaculus::report
