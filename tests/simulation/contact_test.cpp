// Stick, slip, lift, impact and stop against closed forms.

#include <gtest/gtest.h>

#include <cmath>

#include "simulation/support.h"

namespace jaculus::simulation {
namespace {

using namespace test;

constexpr double g = kGravity;

/// A box on an incline of angle a, seen in the incline's frame: gravity across it, a steady push
/// along it.
Plant box_on_incline(double angle, double friction) {
  model::PlanarModel model = body_with_feet(2.0, 0.05, {Vec2(-0.2, -0.05), Vec2(0.2, -0.05)});
  model.gravity = g * std::cos(angle);
  Plant plant = plant_of(model, friction);
  plant.pushes = {{0.0, 10.0, Vec2(2.0 * g * std::sin(angle), 0.0)}};
  return plant;
}

TEST(Contact, BoxOnAnInclineSticksBelowTheFrictionAngleAndSlidesAboveIt) {
  const double friction = 0.5, limit = std::atan(friction);
  for (double off : {-0.2, -0.01, -1e-4, 1e-4, 0.01, 0.2}) {
    const double angle = limit + off;
    const Simulation s = simulate(box_on_incline(angle, friction), no_controller(),
                                  start_at({0, 0.05, 0}, {0, 0, 0}), options_for(0.5));
    ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
    const double acceleration = std::max(0.0, g * (std::sin(angle) - friction * std::cos(angle)));
    EXPECT_NEAR(s.q(0, 100), 0.125 * acceleration, 1e-9) << off;
    EXPECT_NEAR(s.v(0, 100), 0.5 * acceleration, 1e-9) << off;
    EXPECT_NEAR(s.q(1, 100), 0.05, 1e-9);
    EXPECT_NEAR(s.force(1, 50) + s.force(3, 50), 2.0 * g * std::cos(angle), 1e-6);
    EXPECT_NEAR(s.force(0, 50) + s.force(2, 50),
                -std::min(2.0 * g * std::sin(angle), friction * 2.0 * g * std::cos(angle)), 1e-6);
  }
}

TEST(Contact, SlidingBoxComesToRestWhenFrictionHasTakenItsSpeed) {
  const double friction = 0.4, speed = 1.5, stop = speed / (friction * g);
  const Plant plant =
      plant_of(body_with_feet(2.0, 0.05, {Vec2(-0.3, -0.02), Vec2(0.3, -0.02)}), friction);
  const Simulation s =
      simulate(plant, no_controller(), start_at({0, 0.02, 0}, {speed, 0, 0}), options_for(0.6));
  ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
  EXPECT_NEAR(event_time(s, EventKind::stick, "foot_0"), stop, 1e-8);
  EXPECT_NEAR(s.q(0, 100), 0.5 * speed * stop, 1e-9);
  EXPECT_NEAR(s.v(0, 100), 0.0, 1e-12);
}

TEST(Contact, SlidingDiscRollsWhenFrictionHasTurnedIt) {
  // A disc of inertia I slides at v0 and rolls from t = v0/(mu g (1 + m r^2/I)) on, with v0/(1 +
  // I/(m r^2)).
  const double friction = 0.3, v0 = 1.0, r = 0.1, m = 1.5, inertia = 0.5 * m * r * r;
  Plant plant = plant_of(body_with_feet(m, inertia, {Vec2::Zero()}), friction);
  plant.ground.foot_radius = r;
  const Simulation s =
      simulate(plant, no_controller(), start_at({0, r, 0}, {v0, 0, 0}), options_for(0.3));
  ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
  const double rolls = v0 / (friction * g * (1.0 + m * r * r / inertia));
  EXPECT_NEAR(event_time(s, EventKind::stick, "foot_0"), rolls, 1e-8);
  EXPECT_NEAR(s.v(0, 100), v0 * 2.0 / 3.0, 1e-9);
  EXPECT_NEAR(s.v(2, 100), v0 * 2.0 / 3.0 / r, 1e-8);
}

TEST(Contact, FallingMassLandsOnTimeAndStaysDown) {
  const double height = 0.3;
  const Plant plant = plant_of(body_with_feet(1.0, 0.1, {Vec2(-0.1, 0.0), Vec2(0.1, 0.0)}), 0.5);
  const Simulation s =
      simulate(plant, no_controller(), start_at({0, height, 0}, {0, 0, 0}), options_for(0.5));
  ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
  EXPECT_NEAR(event_time(s, EventKind::land, "foot_0"), std::sqrt(2.0 * height / g), 1e-7);
  EXPECT_NEAR(s.q(1, 100), 0.0, 1e-9);
  EXPECT_LT(s.v.col(100).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(Contact, MassOnARailBouncesWithRestitutionAndComesToRest) {
  // Flights of 2 v0 e^k / g after the first fall; the sum of all is finite.
  const double height = 0.2, e = 0.5, v0 = std::sqrt(2.0 * g * height), fall = v0 / g;
  Plant plant = nominal_plant(mass_on_rail(1.3));
  plant.stops = {{"rail", {0.0, kInfinity}, e}};
  const Simulation s =
      simulate(plant, no_controller(), start_at({height}, {0}), options_for(1.0, 1001));
  ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
  std::vector<double> hits;
  for (const Event& event : s.events)
    if (event.kind == EventKind::stop) hits.push_back(event.time);
  ASSERT_GE(hits.size(), 5u);
  double expected = fall;
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR(hits[k], expected, 1e-7) << k;
    expected += 2.0 * v0 / g * std::pow(e, static_cast<double>(k + 1));
  }
  EXPECT_NEAR(hits.back(), fall + 2.0 * v0 / g * e / (1.0 - e), 1e-3);
  EXPECT_NEAR(s.q(0, 1000), 0.0, 1e-9);
  EXPECT_GE(s.q.minCoeff(), -1e-6);
}

/// A rod that falls flat-handed: tilted by `angle` from the level, at rest, centre `height` above
/// its lower end.
struct RodImpact {
  double normal, tangential;  ///< impulse [N s]
  Eigen::Vector3d v;          ///< rates after it
};

RodImpact rod_impact(double m, double length, double angle, double speed, bool sticks) {
  // The lower end's arm from the centre: half (-cos, -sin) of the rod at pitch `angle` (nose down,
  // the front end low).
  const double inertia = m * length * length / 12.0, ax = 0.5 * length * std::cos(angle),
               az = -0.5 * length * std::sin(angle);
  // v_x + az w, v_z - ax w of the end; impulse (t, n) turns by az t - ax n.
  Mat2 A;
  A << 1 / m + az * az / inertia, -ax * az / inertia, -ax * az / inertia, 1 / m + ax * ax / inertia;
  Vec2 impulse = sticks ? Vec2(A.inverse() * Vec2(0.0, speed)) : Vec2(0.0, speed / A(1, 1));
  return {
      impulse.y(),
      impulse.x(),
      {impulse.x() / m, -speed + impulse.y() / m, (az * impulse.x() - ax * impulse.y()) / inertia}};
}

TEST(Contact, RodDroppedOnItsEndFollowsTheImpulse) {
  const double m = 0.8, length = 0.6, angle = 0.7, height = 0.25,
               speed = std::sqrt(2.0 * g * height);
  for (bool sticks : {true, false}) {
    const model::PlanarModel model = body_with_feet(
        m, m * length * length / 12.0, {Vec2(-0.5 * length, 0.0), Vec2(0.5 * length, 0.0)});
    SimulationOptions options = options_for(speed / g + 1e-9, 3);
    const double z = height + 0.5 * length * std::sin(angle);
    const Simulation s = simulate(plant_of(model, sticks ? 5.0 : 0.0), no_controller(),
                                  start_at({0, z, angle}, {0, 0, 0}), options);
    ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
    const RodImpact expected = rod_impact(m, length, angle, speed, sticks);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(s.v(i, 2), expected.v[i], 1e-6) << i << sticks;
    ASSERT_FALSE(s.events.empty());
    EXPECT_EQ(s.events[0].what, "foot_1");
  }
}

TEST(Contact, TailHitsItsStopWithRestitutionAndMomentumStays) {
  // Body and tail on one pivot that is pinned: I_b w_b + I_t w_t stays, w_t - w_b turns into -e
  // times itself.
  const double body = 0.23, tail = 0.058, rate = 20.0;
  model::PlanarModel model;
  model.base_free = {false, false, true};
  model.gravity = 0.0;
  model.bodies = {link("", -1, Vec2::Zero(), 1.0, Vec2::Zero(), body),
                  link("tail", 0, Vec2::Zero(), 1.0, Vec2::Zero(), tail)};
  model = with_coordinates(model, {"tail"});
  for (double e : {0.0, 0.3, 1.0}) {
    Plant plant = nominal_plant(model);
    plant.stops = {{"tail", {-1.0, 1.0}, e}};
    const Simulation s =
        simulate(plant, no_controller(), start_at({0, 0}, {-2.0, rate}), options_for(0.06));
    ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
    EXPECT_NEAR(event_time(s, EventKind::stop, "tail"), 1.0 / rate, 1e-8);
    EXPECT_NEAR(s.v(1, 100), -e * rate, 1e-9);
    EXPECT_NEAR((body + tail) * s.v(0, 100) + tail * s.v(1, 100),
                (body + tail) * -2.0 + tail * rate, 1e-9);
    EXPECT_LE(s.q.row(1).maxCoeff(), 1.0 + 1e-6);
  }
}

TEST(Contact, LockedStopLetsGoWhenTorquePullsIt) {
  model::PlanarModel model =
      test_support::on_fixed_base({link("arm", 0, Vec2::Zero(), 1.0, Vec2::Zero(), 0.02)}, {"arm"});
  model.gravity = 0.0;
  model::PlanarMotor motor;
  motor.joint = "arm";
  motor.body = 1;
  model.motors = {motor};
  Plant plant = nominal_plant(model);
  plant.stops = {{"arm", {-kInfinity, 0.5}, 0.0}};
  Controller c = no_controller();
  c.after_end = AfterEnd::repeat;
  c.reference.motors = {"arm"};
  c.reference.time = Vector::LinSpaced(2, 0.0, 0.2);
  c.reference.duration = 0.4;
  c.reference.feedforward = Matrix(1, 2);
  c.reference.feedforward << 1.0, -1.0;  // into the stop, from 0.2 s on away from it
  const Simulation s = simulate(plant, c, start_at({0.45}, {0}), options_for(0.4));
  ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
  EXPECT_NEAR(event_time(s, EventKind::stop, "arm"), std::sqrt(2.0 * 0.05 * 0.02), 1e-8);
  EXPECT_NEAR(event_time(s, EventKind::release, "arm"), 0.2, 1e-9);
  EXPECT_NEAR(s.q(0, 100), 0.5 - 0.5 * 50.0 * 0.04, 1e-8);
}

TEST(Contact, FootThatIsPulledLifts) {
  // A push upwards that grows past the weight in steps: the box leaves at the step that exceeds it.
  Plant plant = plant_of(body_with_feet(1.0, 0.1, {Vec2(-0.1, 0.0), Vec2(0.1, 0.0)}), 0.5);
  plant.pushes = {{0.1, 1.0, Vec2(0.0, 0.9 * g)}, {0.2, 1.0, Vec2(0.0, 0.3 * g)}};
  const Simulation s =
      simulate(plant, no_controller(), start_at({0, 0, 0}, {0, 0, 0}), options_for(0.3));
  ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
  EXPECT_NEAR(event_time(s, EventKind::lift, "foot_0"), 0.2, 1e-12);
  EXPECT_NEAR(s.q(1, 100), 0.5 * 0.2 * g * 0.01, 1e-9);
  EXPECT_NEAR(s.force(1, 50), 0.05 * g, 1e-9);
}

TEST(Contact, CompliantGroundSettlesAtTheStaticDepthAndGoesToRigid) {
  const double m = 1.2;
  for (double compliance : {1e-3, 1e-4, 1e-5}) {
    Plant plant = plant_of(body_with_feet(m, 0.1, {Vec2(-0.1, 0.0), Vec2(0.1, 0.0)}), 0.5);
    plant.ground.compliance = compliance;
    plant.ground.damping_ratio = 0.3;
    const Simulation s =
        simulate(plant, no_controller(), start_at({0, 1e-3, 0}, {0, 0, 0}), options_for(2.0));
    ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
    EXPECT_NEAR(s.q(1, 100), -0.5 * m * g * compliance, 0.2 * 0.5 * m * g * compliance);
    EXPECT_NEAR(s.v(1, 100), 0.0, 0.02);
  }
}

TEST(Contact, CompliantSoleHoldsBelowTheFrictionAngleAndSlidesAboveIt) {
  // The sole gives way before it slides, by a displacement in proportion to the compliance.
  const double friction = 0.5, limit = std::atan(friction);
  for (double compliance : {1e-6, 1e-7}) {
    for (double off : {-0.05, 0.05}) {
      Plant plant = box_on_incline(limit + off, friction);
      plant.ground.compliance = compliance;
      plant.ground.damping_ratio = 1.0;
      const double rest = 0.05 - 0.5 * 2.0 * plant.model.gravity * compliance;
      const Simulation s =
          simulate(plant, no_controller(), start_at({0, rest, 0}, {0, 0, 0}), options_for(0.5));
      ASSERT_EQ(s.status, SimulationStatus::done) << s.message;
      const double acceleration =
          std::max(0.0, g * (std::sin(limit + off) - friction * std::cos(limit + off)));
      EXPECT_NEAR(s.q(0, 100), 0.125 * acceleration, 2e3 * compliance) << off;
    }
  }
}

}  // namespace
}  // namespace jaculus::simulation
