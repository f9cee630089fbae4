// Laws of users: closed forms of their states, and that they do what the plant's own parts do.

#include "jaculus/simulation/law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/model/robot.h"
#include "simulation/support.h"
#include "support/input_error.h"

namespace jaculus::simulation {
namespace {

using namespace test;

/// A law without states whose actions are constant.
Law constant(std::vector<Action> actions, std::vector<double> values) {
  Law law;
  law.name = "constant";
  law.actions = std::move(actions);
  law.functions = [values] {
    const auto set = [values](const double*, const double*, double* out) {
      std::copy(values.begin(), values.end(), out);
    };
    return LawFunctions{
        set, [set](const double* r, const double* s, double* out, double*) { set(r, s, out); }};
  };
  return law;
}

Simulation run(const Plant& plant, const StartState& start) {
  const Simulation s = simulate(plant, no_controller(), start, options_for(0.5));
  EXPECT_EQ(s.status, SimulationStatus::done) << s.message;
  return s;
}

TEST(Laws, ForceAndMomentOnABodyAreThoseOfAPush) {
  model::PlanarModel model = body_with_feet(2.0, 0.05, {});
  const StartState start = start_at({0, 1, 0.3}, {0, 0, 1});
  Plant pushed = plant_of(model, 0.0), ruled = pushed;
  Push push{0.0, 1.0, Vec2(3.0, -1.0)};
  push.moment = 0.3;
  pushed.pushes = {push};
  ruled.laws = {constant({{ActionKind::point_force, "body"}, {ActionKind::body_moment, "body"}},
                         {3.0, -1.0, 0.3})};
  EXPECT_LT((run(pushed, start).q - run(ruled, start).q).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Laws, AForceOffTheOriginTurnsTheBody) {
  model::PlanarModel model = body_with_feet(2.0, 0.05, {});
  model.gravity = 0.0;
  Plant plant = plant_of(model, 0.0), turned = plant;
  // about +y an upward force ahead of the centre turns the nose up: the negative sense
  plant.laws = {constant({{ActionKind::point_force, "body", Vec2(0.1, 0.0)}}, {0.0, 1e-4})};
  turned.laws = {constant({{ActionKind::body_moment, "body"}}, {-1e-5})};
  const StartState start = start_at({0, 1, 0}, {0, 0, 0});
  EXPECT_NEAR(run(plant, start).v(2, 100), run(turned, start).v(2, 100), 1e-12);
}

/// x' = -x/T from x_0, and x is the force on a mass m: its way is x_0 T^2/m (t/T - 1 + e^(-t/T)).
TEST(Laws, StatesAreIntegratedWithTheMotion) {
  constexpr double kTime = 0.05, kForce = 2.0, kMass = 1.5;
  model::PlanarModel model = mass_on_rail(kMass);
  model.gravity = 0.0;
  for (const double scale : {1.0, 1e-3}) {
    Plant plant = plant_of(model, 0.0);
    Law law;
    law.name = "decay";
    law.actions = {{ActionKind::joint_torque, "rail"}};
    law.states = {{kForce, scale}};
    law.functions = [] {
      return LawFunctions{nullptr, [](const double*, const double* x, double* out, double* rate) {
                            out[0] = x[0];
                            rate[0] = -x[0] / kTime;
                          }};
    };
    plant.laws = {law};
    const Simulation s = run(plant, start_at({0}, {0}));
    for (const int k : {1, 20, 100}) {
      const double t = s.time[k] / kTime;
      EXPECT_NEAR(s.q(0, k), kForce * kTime * kTime / kMass * (t - 1.0 + std::exp(-t)), 1e-8);
    }
  }
}

/// Torque by the rate of the same joint.
Law by_own_rate(const std::string& joint, const std::function<double(double)>& torque) {
  Law law;
  law.name = "by own rate";
  law.readings = {{ReadingKind::joint_rate, joint}};
  law.actions = {{ActionKind::joint_torque, joint}};
  law.functions = [torque] {
    return LawFunctions{nullptr, [torque](const double* r, const double*, double* out, double*) {
                          out[0] = torque(r[0]);
                        }};
  };
  return law;
}

TEST(Laws, DryFrictionRestsAsFastAsThePlantsOwn) {
  constexpr double kMass = 0.01, kFriction = 2.0;  // N, 20 weights: 4e4 1/s where it rests
  const model::PlanarModel model = mass_on_rail(kMass);
  Plant own = plant_of(model, 0.0), ruled = own;
  JointFriction friction{.joint = "rail", .coulomb = kFriction};
  own.friction = {friction};
  ruled.laws = {by_own_rate("rail", [rate = friction.smoothing_rate](double v) {
    return -kFriction * std::tanh(v / rate);
  })};
  const StartState start = start_at({0}, {1});
  const Simulation expected = run(own, start), found = run(ruled, start);
  EXPECT_LT((found.q - expected.q).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_LT(found.evaluations, 2 * expected.evaluations) << "explicit steps would take 3e4";
}

/// v' = c v/m: what grows with its own rate is no fast part.
TEST(Laws, MayDriveTheirOwnRate) {
  model::PlanarModel model = mass_on_rail(1.0);
  model.gravity = 0.0;
  Plant plant = plant_of(model, 0.0);
  plant.laws = {by_own_rate("rail", [](double v) { return 10.0 * v; })};
  EXPECT_NEAR(run(plant, start_at({0}, {1})).v(0, 100), std::exp(5.0), 1e-5);
}

/// A spring that pushes away: q'' = k q/m, where nothing ends the motion.
TEST(Laws, ThatDriveAMotionBeyondAllMachinesEndIt) {
  model::PlanarModel model = mass_on_rail(1.0);
  model.gravity = 0.0;
  Plant plant = plant_of(model, 0.0);
  Law law = by_own_rate("rail", [](double q) { return 1e4 * q; });
  law.readings = {{ReadingKind::joint_position, "rail"}};
  plant.laws = {law};
  const Simulation s = simulate(plant, no_controller(), start_at({0}, {1}), options_for(10.0));
  EXPECT_EQ(s.status, SimulationStatus::diverged);
  EXPECT_TRUE(test::holds(s.message, "more than 1e5 rad/s or m/s"));
  // v = cosh(100 t)
  EXPECT_NEAR(s.end_time, std::acosh(1e5) / 100.0, 0.01);
}

/// A robot of motors, and what a law reads of them.
TEST(Laws, ReadTheRobot) {
  model::PlanarModel model =
      model::read_robot(source_folder() / "models" / "double_pendulum").planar;
  model::PlanarMotor& elbow = model.motors[model.motor_index("elbow")];
  elbow.current_limit = kInfinity;
  Plant plant = plant_of(model, 0.0);
  std::vector<double> seen;
  Law law;
  law.name = "reader";
  law.readings = {{ReadingKind::time},
                  {ReadingKind::joint_position, "elbow"},
                  {ReadingKind::joint_rate, "elbow"},
                  {ReadingKind::point_x, "lower", Vec2(0.0, -0.3)},
                  {ReadingKind::point_z, "lower", Vec2(0.0, -0.3)},
                  {ReadingKind::point_rate_x, "lower", Vec2(0.0, -0.3)},
                  {ReadingKind::body_angle, "lower"},
                  {ReadingKind::body_rate, "lower"},
                  {ReadingKind::joint_load, "elbow"},
                  {ReadingKind::bus_voltage},
                  {ReadingKind::motor_limit, "elbow"}};
  law.functions = [&seen] {
    return LawFunctions{nullptr, [&seen](const double* r, const double*, double*, double*) {
                          if (seen.empty()) seen.assign(r, r + 11);
                        }};
  };
  plant.laws = {law};
  run(plant, start_at({0.2, 0.3}, {1.0, -0.5}));

  ASSERT_EQ(seen.size(), 11u);
  EXPECT_EQ(seen[0], 0.0);
  EXPECT_NEAR(seen[1], 0.3, 1e-12);
  EXPECT_NEAR(seen[2], -0.5, 1e-12);
  // hanging at 0.2 and 0.5 from the vertical: p = -(l sin, l cos)
  EXPECT_NEAR(seen[3], -0.2 * std::sin(0.2) - 0.3 * std::sin(0.5), 1e-12);
  EXPECT_NEAR(seen[4], -0.2 * std::cos(0.2) - 0.3 * std::cos(0.5), 1e-12);
  EXPECT_NEAR(seen[5], -0.2 * std::cos(0.2) * 1.0 - 0.3 * std::cos(0.5) * 0.5, 1e-12);
  EXPECT_NEAR(seen[6], 0.5, 1e-12);
  EXPECT_NEAR(seen[7], 0.5, 1e-12);
  // gravity turns the lower link back, and the upper one's spin throws it outward: m c w^2 l sin
  const double gravity = -0.45 * 9.81 * 0.24 * std::sin(0.5);
  const double spin = -0.45 * 0.2 * 0.24 * 1.0 * std::sin(0.3);
  EXPECT_NEAR(seen[8], gravity + spin, 1e-9);
  EXPECT_EQ(seen[9], 24.0);
  EXPECT_EQ(seen[10], elbow.torque_limit * elbow.gear);
}

/// The double pendulum driven by voltages.
Simulation driven(const Plant& plant, Quantity quantity, double command) {
  Controller controller;
  controller.quantity = quantity;
  controller.rate_hz = 500.0;
  controller.reference.time = Vector::LinSpaced(2, 0.0, 0.5);
  controller.reference.motors = {"shoulder", "elbow"};
  controller.reference.feedforward = Matrix::Constant(2, 2, command);
  controller.reference.duration = 0.5;
  controller.kp = controller.kd = Vector::Zero(2);
  controller.after_end = AfterEnd::repeat;
  const Simulation s = simulate(plant, controller, start_at({0, 0}, {0, 0}), options_for(0.5));
  EXPECT_EQ(s.status, SimulationStatus::done) << s.message;
  return s;
}

TEST(Laws, ScaleATorqueAsTheActuationDoes) {
  Plant plant =
      plant_of(model::read_robot(source_folder() / "models" / "double_pendulum").planar, 0.0);
  Plant ruled = plant;
  plant.actuation.torque_scale["elbow"] = 0.7;
  ruled.laws = {constant({{ActionKind::torque_scale, "elbow"}}, {0.7})};
  EXPECT_LT((driven(plant, Quantity::torque, 0.3).q - driven(ruled, Quantity::torque, 0.3).q)
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
}

TEST(Laws, ADropOfTheBusIsALowerVoltage) {
  Plant plant =
      plant_of(model::read_robot(source_folder() / "models" / "double_pendulum").planar, 0.0);
  for (const double resistance : {0.0, 0.1}) {
    plant.battery.resistance = resistance;
    Plant lower = plant, ruled = plant;
    for (model::PlanarMotor& motor : lower.model.motors) motor.voltage -= 20.0;
    ruled.laws = {constant({{ActionKind::bus_drop}}, {20.0})};
    const Simulation a = driven(lower, Quantity::duty, 0.5), b = driven(ruled, Quantity::duty, 0.5);
    EXPECT_LT((a.q - b.q).cwiseAbs().maxCoeff(), 1e-12) << resistance;
    EXPECT_GT((a.q - driven(plant, Quantity::duty, 0.5).q).cwiseAbs().maxCoeff(), 0.1);
  }
}

TEST(Laws, OfWhatIsNotThereAreRefused) {
  Plant plant = plant_of(body_with_feet(2.0, 0.05, {}), 0.0);
  const StartState start = start_at({0, 1, 0}, {0, 0, 0});
  const auto refused = [&](const Law& law) {
    plant.laws = {law};
    return input_error_of([&] { (void)simulate(plant, no_controller(), start, options_for(0.1)); });
  };
  EXPECT_TRUE(holds(refused(constant({{ActionKind::joint_torque, "elbow"}}, {1.0})),
                    "constant: the robot has no joint 'elbow'"));
  EXPECT_TRUE(holds(refused(constant({{ActionKind::body_moment, "arm"}}, {1.0})),
                    "constant: the robot has no body 'arm'"));
}

}  // namespace
}  // namespace jaculus::simulation
