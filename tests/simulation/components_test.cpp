// Components of the plant: nominal values change no bit, small values little, and closed forms
// where there are any.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "jaculus/core/error.h"
#include "jaculus/model/robot.h"
#include "simulation/integrate/start.h"
#include "simulation/support.h"

namespace jaculus::simulation {
namespace {

using namespace test;

/// Minitaur pushes off from a crouch under joint PD: the legs stretch, the tail swings.
struct PushOff {
  Plant plant;
  Controller controller;
  StartState start;
};

PushOff push_off() {
  const model::PlanarModel model = model::read_robot(model::find_robot("minitaur_tail", "")).planar;
  PushOff p{nominal_plant(model), {}, {}};
  Reference& r = p.controller.reference;
  const auto motors = std::ssize(model.motors);
  r.time = Vector::LinSpaced(3, 0.0, 0.1);
  r.duration = 0.1;
  r.position = Matrix(motors, 3);
  r.velocity = Matrix::Zero(motors, 3);
  r.feedforward = Matrix::Constant(motors, 3, 0.2);
  for (Eigen::Index m = 0; m < motors; ++m) {
    r.motors.push_back(model.motors[m].joint);
    const bool tail = r.motors.back() == "tail";
    const double from = 1.0, to = tail ? 0.6 : 1.35;
    r.position.row(m) << from, 0.5 * (from + to), to;
    r.initial[r.motors.back()] = from;
  }
  p.controller.kp = Vector::Constant(motors, 6.0);
  p.controller.kd = Vector::Constant(motors, 0.1);
  p.controller.kp[motors - 1] = 0.4;
  p.controller.kd[motors - 1] = 0.02;
  p.start = reference_start(p.plant, r);
  return p;
}

Simulation run(const PushOff& p, double duration = 0.1) {
  SimulationOptions options = options_for(duration, 21);
  const Simulation s = simulate(p.plant, p.controller, p.start, options);
  EXPECT_EQ(s.status, SimulationStatus::done) << s.message;
  return s;
}

TEST(Components, NominalValuesChangeNoBit) {
  PushOff p = push_off();
  const Simulation bare = run(p);
  p.plant.friction = {{"tail", 0, 0, 0, 1, 0, 0.1}, {"front_a_knee", 0, 0, 0, 1, 0, 0.1}};
  p.plant.transmissions = {{"tail", 0, 0.3, 0}, {"front_a", 0, 0, 0}};
  p.plant.battery.resistance = 0.0;
  p.plant.actuation.torque_scale = {{"tail", 1.0}};
  p.plant.sensing.offset = {{"tail", 0.0}};
  p.plant.sensing.scale = {{"tail", 1.0}};
  p.plant.sensing.latency = {{"mocap", 0.01}};
  const Simulation dressed = run(p);
  EXPECT_TRUE((bare.q.array() == dressed.q.array()).all());
  EXPECT_TRUE((bare.v.array() == dressed.v.array()).all());
  EXPECT_TRUE((bare.force.array() == dressed.force.array()).all());
}

/// Largest change of the coordinates against the bare plant.
double influence(const std::function<void(PushOff&)>& edit) {
  PushOff p = push_off();
  const Simulation bare = run(p);
  edit(p);
  const Simulation with = run(p);
  if (with.q.cols() != bare.q.cols()) return kNaN;
  return (with.q - bare.q).cwiseAbs().maxCoeff();
}

TEST(Components, InfluenceGoesToZeroWithTheParameter) {
  const std::vector<std::pair<std::string, std::function<void(PushOff&, double)>>> edits = {
      {"compliance",
       [](PushOff& p, double s) {
         p.plant.transmissions = {{"tail", 0.01 * s, 0.1, 0}};
       }},
      {"compliance of a leg",
       [](PushOff& p, double s) {
         p.plant.transmissions = {{"rear_a", 0.01 * s, 0.2, 0}};
       }},
      {"play",
       [](PushOff& p, double s) {
         p.plant.transmissions = {{"tail", 0, 0.1, 0.02 * s}};
       }},
      {"delay", [](PushOff& p, double s) { p.plant.actuation.delay = 3e-3 * s; }},
      {"late start", [](PushOff& p, double s) { p.plant.actuation.late_start = 3e-3 * s; }},
      {"coulomb friction",
       [](PushOff& p, double s) {
         p.plant.friction = {{"tail", 0.2 * s, 0, 0, 1, 0, 0.1}};
       }},
      {"friction of a knee",
       [](PushOff& p, double s) {
         p.plant.friction = {{"rear_a_knee", 0.2 * s, 0, 0, 1, 0, 0.1}};
       }},
      {"ground compliance",
       [](PushOff& p, double s) {
         p.plant.ground.compliance = 3e-5 * s;
         p.plant.ground.damping_ratio = 0.3;
         p.start = reference_start(p.plant, p.controller.reference);
       }},
      {"foot radius",
       [](PushOff& p, double s) {
         p.plant.ground.foot_radius = 0.01 * s;
         p.start = reference_start(p.plant, p.controller.reference);
       }},
      {"torque",
       [](PushOff& p, double s) { p.plant.actuation.torque_scale["rear_a"] = 1.0 - 0.1 * s; }},
      {"filter of rates",
       [](PushOff& p, double s) { p.plant.actuation.velocity_filter = 3e-3 * s; }},
      {"winding", [](PushOff& p, double s) { p.plant.winding.heat = s; }},
      {"encoder", [](PushOff& p, double s) { p.plant.sensing.offset["rear_a"] = 0.01 * s; }}};
  for (const auto& [name, edit] : edits) {
    const double large = influence([&](PushOff& p) { edit(p, 1.0); });
    const double small = influence([&](PushOff& p) { edit(p, 0.1); });
    EXPECT_LT(small, 0.25 * large + 1e-9)
        << name << ": " << large << " and a tenth of it " << small;
    EXPECT_LT(large, 0.3) << name;
    // torque commands hardly feel a warm winding
    EXPECT_GT(large, name == "winding" ? -1.0 : 1e-6) << name;
  }
}

TEST(Components, DelayShiftsARobotThatStandsStill) {
  PushOff p = push_off();
  const Simulation bare = run(p, 0.08);
  p.plant.actuation.late_start = 0.02;
  const Simulation late = run(p, 0.1);
  for (int i = 0; i < 8; ++i) EXPECT_NEAR(late.q(i, 20), bare.q(i, 20), 1e-6) << i;
  EXPECT_NEAR(late.q(1, 3), p.start.q[1], 1e-8);  // 15 ms: nothing has moved
}

TEST(Components, HeldWhileItWaitsFromWhateverStart) {
  // Feet that stand leave one combination of torques without effect, and none of it may be asked
  // for: the rank decides, start by start.
  for (int k = 0; k < 60; ++k) {
    PushOff p = push_off();
    for (Eigen::Index m = 0; m < 4; ++m)
      p.controller.reference.initial[p.controller.reference.motors[m]] +=
          0.004 * std::sin(1.0 + 7.3 * k + 2.1 * static_cast<double>(m));
    p.start = reference_start(p.plant, p.controller.reference);
    level_feet(p.plant, p.start.q);
    p.plant.actuation.late_start = 0.02;
    const Simulation s = run(p, 0.015);
    EXPECT_LT(s.v.cwiseAbs().maxCoeff(), 1e-6) << k;
    EXPECT_LT(s.torque.cwiseAbs().maxCoeff(), 2.0) << k;
  }
}

/// An arm held still by its stop, driven by one motor.
Plant stalled_arm() {
  model::PlanarModel model =
      test_support::on_fixed_base({link("arm", 0, Vec2::Zero(), 1.0, Vec2::Zero(), 0.02)}, {"arm"});
  model.gravity = 0.0;
  model::PlanarMotor motor;
  motor.joint = "arm";
  motor.body = 1;
  motor.count = 2;
  motor.torque_constant = 0.1;
  motor.resistance = 0.2;
  motor.saturation_linear = 10.0;
  motor.voltage = 16.0;
  model.motors = {motor};
  Plant plant = nominal_plant(model);
  plant.stops = {{"arm", {-kInfinity, 0.0}, 0.0}};
  return plant;
}

Controller constant(Quantity quantity, double value) {
  Controller c = no_controller();
  c.quantity = quantity;
  c.after_end = AfterEnd::repeat;
  c.reference.motors = {"arm"};
  c.reference.time = Vector::Zero(1);
  c.reference.feedforward = Matrix::Constant(1, 1, value);
  return c;
}

TEST(Components, FrictionOfTheMotorsSlowsAFreeArmInClosedForm) {
  // Two of them at one arm, no stop, no command. Viscous: w = w_0 exp(-2 b t/I); dry, fast: a
  // steady 2 c/I.
  Plant plant = stalled_arm();
  plant.stops.clear();
  plant.model.motors[0].viscous_friction = 0.05;
  const auto rate_after = [&](double duration) {
    const Simulation s =
        simulate(plant, no_controller(), start_at({0}, {10.0}), options_for(duration, 2));
    return s.v(0, 1);
  };
  EXPECT_NEAR(rate_after(0.1), 10.0 * std::exp(-2.0 * 0.05 * 0.1 / 0.02), 1e-6);

  plant.model.motors[0].viscous_friction = 0.0;
  plant.model.motors[0].dry_friction = 0.3;
  EXPECT_NEAR(rate_after(0.2), 10.0 - 2.0 * 0.3 * 0.2 / 0.02, 1e-6);
}

TEST(Components, BatterySagsByItsResistance) {
  // Two stalled motors at duty d: i = d V/R, the bus carries 2 d i, so V = V0/(1 + 2 d^2 R_b/R).
  Plant plant = stalled_arm();
  plant.battery.resistance = 0.05;
  for (double duty : {0.1, 0.5, 0.9}) {
    const Simulation s =
        simulate(plant, constant(Quantity::duty, duty), start_at({0}, {0}), options_for(0.01, 2));
    const double bus = 16.0 / (1.0 + 2.0 * duty * duty * 0.05 / 0.2);
    EXPECT_NEAR(s.bus_voltage[1], bus, 1e-9);
    EXPECT_NEAR(s.voltage(0, 1), duty * bus, 1e-9);
    EXPECT_NEAR(s.current(0, 1), duty * bus / 0.2, 1e-8);
    EXPECT_NEAR(s.torque(0, 1), duty * bus / 0.2 / 10.0, 1e-9);
  }
}

TEST(Components, WindingWarmsByItsOwnLoss) {
  // A torque command keeps the current while k_t's fall is small beside 1: T' = h i^2 R_0 (1 +
  // 0.0039 T) to first order in it.
  Plant plant = stalled_arm();
  plant.winding.heat = 0.05;
  const double duration = 0.5, voltage = 2.0;
  const Simulation s = simulate(plant, constant(Quantity::voltage, voltage), start_at({0}, {0}),
                                options_for(duration, 101));
  // At constant voltage: (1 + a T) T' = h V^2/R_0, so T + a T^2/2 = h V^2/R_0 t.
  const double a = 0.0039, c = 0.05 * voltage * voltage / 0.2 * duration;
  const double temperature = (std::sqrt(1.0 + 2.0 * a * c) - 1.0) / a;
  EXPECT_NEAR(s.current(0, 100), voltage / (0.2 * (1.0 + a * temperature)), 1e-7);
  EXPECT_NEAR(s.torque(0, 100), s.current(0, 100) / 10.0 * (1.0 - 0.001 * temperature), 1e-8);
}

TEST(Components, HingeSwingsAtItsFrequency) {
  // Motor held by its armature (large), link on a spring: a torsion pendulum of sqrt(k/I).
  model::PlanarModel model =
      test_support::on_fixed_base({link("arm", 0, Vec2::Zero(), 1.0, Vec2::Zero(), 0.05)}, {"arm"});
  model.gravity = 0.0;
  model::PlanarMotor motor;
  motor.joint = "arm";
  motor.body = 1;
  motor.rotor_inertia = 0.01;
  model.motors = {motor};
  Plant plant = nominal_plant(model);
  const double stiffness = 100.0, link_inertia = 0.05, rotor = 0.01;
  plant.transmissions = {{"arm", 1.0 / stiffness, 0.0, 0.0}};
  // A steady torque: the motor's side runs ahead by (tau/(J + I)) I/k (1 - cos(w t)), w = sqrt(k
  // (1/I + 1/J)).
  const Simulation s =
      simulate(plant, constant(Quantity::torque, 0.5), start_at({0}, {0}), options_for(0.2, 101));
  const double w = std::sqrt(stiffness * (1.0 / link_inertia + 1.0 / rotor)),
               alpha = 0.5 / (link_inertia + rotor);
  for (int k : {13, 50, 100}) {
    const double t = s.time[k], hinge = -alpha * link_inertia / stiffness * (1.0 - std::cos(w * t));
    const double centre = 0.5 * alpha * t * t;  // (J motor + I link)/(J + I)
    EXPECT_NEAR(s.motor_position(0, k), centre - link_inertia / (link_inertia + rotor) * hinge,
                1e-7);
  }
}

TEST(Components, JointFrictionBringsASpinToRest) {
  model::PlanarModel model =
      test_support::on_fixed_base({link("arm", 0, Vec2::Zero(), 1.0, Vec2::Zero(), 0.02)}, {"arm"});
  model.gravity = 0.0;
  Plant plant = nominal_plant(model);
  plant.friction = {{"arm", 0.0, 0.05, 0.0, 1.0, 0.0, 0.1}};
  Simulation s = simulate(plant, no_controller(), start_at({0}, {10}), options_for(0.5, 2));
  EXPECT_NEAR(s.v(0, 1), 10.0 * std::exp(-0.05 / 0.02 * 0.5), 1e-6);
  plant.friction = {{"arm", 0.1, 0.0, 0.0, 1.0, 0.0, 1e-3}};
  s = simulate(plant, no_controller(), start_at({0}, {10}), options_for(0.5, 2));
  EXPECT_NEAR(s.v(0, 1), 10.0 - 0.1 / 0.02 * 0.5, 1e-6);
}

TEST(Components, BadInputIsToldByName) {
  PushOff p = push_off();
  p.plant.friction = {{"tale", 0.1, 0, 0, 1, 0, 0.1}};
  EXPECT_THROW(run(p), InputError);
  p = push_off();
  p.controller.reference.motors[0] = "front";
  EXPECT_THROW(run(p), InputError);
  p = push_off();
  p.controller.rate_hz = 0.0;
  EXPECT_THROW(run(p), InputError);
  p = push_off();
  p.plant.ground_points = {"nose"};
  EXPECT_THROW(run(p), InputError);
  p = push_off();
  p.controller.reference.initial.erase("tail");
  EXPECT_THROW(reference_start(p.plant, p.controller.reference), InputError);
}

TEST(Components, StartsWhereEncodersShowTheStatedPoseButNotBeyondAStop) {
  PushOff p = push_off();
  const int tail = p.plant.model.coordinate_index("tail");
  const double stated = p.start.q[tail];
  p.plant.stops = {{"tail", {stated, stated + 2.0}, 0.0}};
  const auto started = [&](double reads_more, double off) {
    p.plant.sensing.offset["tail"] = reads_more;
    const Vector scatter = off * Vector::Unit(p.plant.model.size(), tail);
    return reference_start(p.plant, p.controller.reference, scatter).q[tail];
  };
  EXPECT_NEAR(started(-0.01, 0.0), stated + 0.01, 1e-12);
  EXPECT_NEAR(started(-0.01, 0.004), stated + 0.014, 1e-12);
  EXPECT_NEAR(started(0.01, 0.004), stated, 1e-12);
  p.start = reference_start(p.plant, p.controller.reference);
  EXPECT_EQ(run(p, 0.02).status, SimulationStatus::done);

  // Files that contradict themselves are not mended.
  p.plant.stops = {{"tail", {stated + 0.1, stated + 2.0}, 0.0}};
  EXPECT_NEAR(started(0.0, 0.0), stated, 1e-12);
}

TEST(Components, AStateAsReadIsLessItsEncodersOffsetsAndByTheirScales) {
  PushOff p = push_off();
  const int tail = p.plant.model.coordinate_index("tail");
  StartState read = p.start;
  read.v[tail] = 3.0;
  EXPECT_EQ(state_as_read(p.plant, read).q, read.q);
  p.plant.sensing.offset["tail"] = 0.03;
  p.plant.sensing.scale["tail"] = 1.2;
  const StartState state = state_as_read(p.plant, read);
  EXPECT_NEAR(1.2 * state.q[tail] + 0.03, read.q[tail], 1e-12);
  EXPECT_NEAR(1.2 * state.v[tail], read.v[tail], 1e-12);
  Vector others = state.q - read.q;
  others[tail] = 0.0;
  EXPECT_LT(others.cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Components, StepsBetweenCommandsKeepWellBelowTheTolerance) {
  // At 1e-13 no step of the short method is accepted: the reference is Dormand and Prince's alone.
  PushOff p = push_off();
  for (const double friction : {0.8, 0.25}) {  // standing fast, and slipping
    p.plant.ground.friction = friction;
    SimulationOptions options = options_for(0.1, 21);
    const auto run_at = [&](double tolerance) {
      options.relative_tolerance = tolerance;
      options.absolute_tolerance = 1e-2 * tolerance;
      const Simulation s = simulate(p.plant, p.controller, p.start, options);
      EXPECT_EQ(s.status, SimulationStatus::done) << s.message;
      return s;
    };
    const Simulation tight = run_at(1e-13), usual = run_at(1e-6);
    EXPECT_LT((usual.q - tight.q).cwiseAbs().maxCoeff(), 1e-7) << friction;
    EXPECT_LT((usual.v - tight.v).cwiseAbs().maxCoeff(), 1e-5) << friction;
    EXPECT_LT(usual.evaluations, 0.8 * static_cast<double>(tight.evaluations)) << friction;
  }
}

TEST(Components, LegsDrivenTowardsTheirSingularPoseMeetTheEndBeforeIt) {
  PushOff p = push_off();
  const int a = p.plant.model.motor_index("front_a"), b = p.plant.model.motor_index("front_b");
  for (const int m : {a, b}) {
    p.controller.reference.position.row(m) << 1.0, 2.2, 3.4;  // at pi both knees coincide
    p.controller.kp[m] = 30.0;
  }
  const Simulation s = simulate(p.plant, p.controller, p.start, options_for(0.3, 301));
  ASSERT_EQ(s.status, SimulationStatus::done) << s.message;

  const Vector extension = 0.5 * (s.motor_position.row(a) + s.motor_position.row(b));
  EXPECT_LT(extension.maxCoeff(), std::numbers::pi);
  EXPECT_GT(extension.maxCoeff(), std::numbers::pi - 0.1);
}

TEST(Components, DivergenceIsAStatusWithItsTime) {
  PushOff p = push_off();
  p.plant.stops.clear();
  // Drives the faster, the faster it turns: exp(100 t).
  p.plant.friction.push_back({.joint = "tail", .viscous = -5.0});
  const Simulation s = simulate(p.plant, p.controller, p.start, options_for(2.0, 21));
  EXPECT_NE(s.status, SimulationStatus::done);
  EXPECT_LT(s.end_time, 2.0);
  EXPECT_FALSE(s.message.empty());
  EXPECT_LT(s.time.size(), 21);
}

}  // namespace
}  // namespace jaculus::simulation
