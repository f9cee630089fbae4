#include "jaculus/studies/reorientation.h"

#include <gtest/gtest.h>

#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "jaculus/components/motor.h"
#include "jaculus/components/tail_drag.h"
#include "studies/reorientation_systems.h"

namespace jaculus::studies {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kTight = 1e-10;

// A tail of Fig. 3: no shaft, width 0.18 m, normalised inertia x.
ReorientationCase fig3_case(double length, double x, int gear) {
  ReorientationCase c = paper_case();
  c.drag.start = 0.0;
  c.drag.end = length;
  c.tail_inertia = c.body_inertia * x / (1.0 - x);
  c.motor.gear = gear;
  return c;
}

double best_effectiveness(double length, double x) {
  double best = 0.0;
  for (int gear = 1; gear <= 50; ++gear) {
    best = std::max(best, simulate_reorientation(fig3_case(length, x, gear)).effectiveness);
  }
  return best;
}

TEST(Reorientation, TailAsBuiltMatchesTheEquations) {
  const ReorientationResult r = simulate_reorientation(paper_case(), kTight);
  ASSERT_TRUE(r.converged);
  EXPECT_NEAR(fall_time(0.5), 0.3193, 5e-5);
  EXPECT_NEAR(-r.body_angle / kDegree, 93.701, 5e-4);
  EXPECT_NEAR(r.effectiveness, 0.5206, 5e-5);
  ASSERT_TRUE(r.time_to_target && r.stop);
  EXPECT_NEAR(*r.time_to_target, 0.30485, 5e-6);
  EXPECT_NEAR(r.stop->time, 0.17673, 5e-6);
  EXPECT_NEAR(-r.stop->body_angle / kDegree, 55.248, 5e-4);
  EXPECT_NEAR(r.stop->tail_rate, 25.28, 5e-3);
  EXPECT_NEAR(r.stop->body_rate_before, -10.07, 5e-3);
  EXPECT_NEAR(r.stop->body_rate_after, -4.98, 5e-3);
  EXPECT_NEAR(r.rotation_after_stop / kDegree, 93.701 - 55.248, 1e-3);
}

TEST(Reorientation, WithoutDragAllRotationCeasesAtTheStop) {
  ReorientationCase c = paper_case();
  c.drag.kind = model::DragKind::none;
  const ReorientationResult r = simulate_reorientation(c, kTight);
  ASSERT_TRUE(r.stop);
  EXPECT_NEAR(-r.body_angle / kDegree, 36.250, 5e-4);
  EXPECT_NEAR(r.stop->time, 0.14643, 5e-6);
  EXPECT_NEAR(r.stop->tail_rate, 36.05, 5e-3);
  EXPECT_NEAR(r.body_rate, 0.0, 1e-12);
  EXPECT_FALSE(r.time_to_target);
}

TEST(Reorientation, GearFiveBeatsTheGearThatWasBuilt) {
  double best = 0.0;
  int best_gear = 0;
  for (int gear = 1; gear <= 50; ++gear) {
    ReorientationCase c = paper_case();
    c.motor.gear = gear;
    const double e = simulate_reorientation(c).effectiveness;
    if (e > best) {
      best = e;
      best_gear = gear;
    }
  }
  EXPECT_EQ(best_gear, 5);
  EXPECT_NEAR(best * 180.0, 97.061, 5e-4 + 180.0 * 1e-6);
}

TEST(Reorientation, FigureThree) {
  EXPECT_NEAR(best_effectiveness(1.0, 0.01), 0.631, 5e-4);
  EXPECT_NEAR(best_effectiveness(1.0, 0.05), 0.615, 5e-4);
  EXPECT_NEAR(best_effectiveness(1.0, 0.204), 0.564, 5e-4);
  EXPECT_NEAR(best_effectiveness(1.0, 0.37), 0.554, 5e-4);
  EXPECT_NEAR(best_effectiveness(1.0, 0.5), 0.590, 5e-4);
  EXPECT_NEAR(best_effectiveness(0.5, 0.01), 0.167, 5e-4);
}

// Boost's Dormand-Prince on the equations as printed, with states thb, tht and their rates: shares
// no code path.
std::vector<double> printed_equations(const ReorientationCase& c, double until) {
  namespace odeint = boost::numeric::odeint;
  using State = std::vector<double>;
  const double b = components::rotation_drag_factor(c.drag.density, c.drag.coefficient,
                                                    c.drag.width, c.drag.start, c.drag.end);
  const auto f = [&](const State& y, State& dy, double) {
    const double current =
        (c.motor.voltage - c.motor.torque_constant * c.motor.gear * y[3]) / c.motor.resistance;
    double tau = 0.0;  // Newton's method on equation 7
    for (int i = 0; i < 60; ++i) {
      tau -= (0.539 * tau * tau * tau + 8.93 * tau - current) / (3.0 * 0.539 * tau * tau + 8.93);
    }
    const double omega = y[2] + y[3];
    const double drag = -b * omega * std::abs(omega);
    const double torque = c.motor.gear * tau;
    dy = {y[2], y[3], -torque / c.body_inertia,
          torque / c.body_inertia + (torque + drag) / c.tail_inertia};
  };
  State y(4, 0.0);
  odeint::integrate_adaptive(
      odeint::make_controlled<odeint::runge_kutta_dopri5<State>>(1e-12, 1e-12), f, y, 0.0, until,
      1e-5);
  return y;
}

TEST(Reorientation, AgreesWithAnIndependentIntegrator) {
  for (double gear : {1.0, 4.0, 20.0}) {
    ReorientationCase c = paper_case();
    c.motor.gear = gear;
    c.duration = 0.1;  // before any stop
    const ReorientationResult r = simulate_reorientation(c, kTight);
    const std::vector<double> y = printed_equations(c, 0.1);
    ASSERT_FALSE(r.stop);
    EXPECT_NEAR(r.body_angle, y[0], 2e-9);
    EXPECT_NEAR(r.tail_angle, y[1], 2e-9);
    EXPECT_NEAR(r.body_rate, y[2], 2e-8);
    EXPECT_NEAR(r.tail_rate, y[3], 2e-8);
  }
}

TEST(Reorientation, InertialRotationIsTheStrokeTimesTheInertiaRatio) {
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int k = 0; k < 200; ++k) {
    ReorientationCase c = paper_case();
    c.drag.kind = model::DragKind::none;
    c.body_inertia = 0.01 + unit(rng);
    c.tail_inertia = 0.001 + unit(rng);
    c.motor.gear = 1.0 + 49.0 * unit(rng);
    c.motor.voltage = 1.0 + 30.0 * unit(rng);
    c.motor.saturation_cubic = k % 3 == 0 ? 0.0 : 2.0 * unit(rng);
    c.motor_limits = k % 2 == 0;
    c.motor.torque_limit = 0.5 + 3.0 * unit(rng);
    c.stroke = 0.3 + 6.0 * unit(rng);
    c.duration = 5.0;
    const ReorientationResult r = simulate_reorientation(c);
    ASSERT_TRUE(r.converged && r.tail_angle > 0.0);
    EXPECT_NEAR(-r.body_angle, r.tail_angle * c.tail_inertia / (c.body_inertia + c.tail_inertia),
                1e-9);
    if (r.stop) {
      EXPECT_NEAR(r.tail_angle, c.stroke, 1e-12);
    }
  }
}

TEST(Reorientation, TheStopKeepsTheMomentum) {
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int stops = 0;
  for (int k = 0; k < 200; ++k) {
    ReorientationCase c = paper_case();
    c.tail_inertia = 0.002 + 0.3 * unit(rng);
    c.motor.gear = std::floor(1.0 + 12.0 * unit(rng));
    if (k % 4 == 0) c.root_stiffness = 50.0 + 100.0 * unit(rng);
    const ReorientationResult r = simulate_reorientation(c);
    ASSERT_TRUE(r.converged);
    if (!r.stop) continue;
    ++stops;
    const StopEvent& s = *r.stop;
    EXPECT_NEAR(s.momentum_before, s.momentum_after, 1e-12);
    EXPECT_NEAR(
        s.momentum_before,
        c.body_inertia * s.body_rate_before + c.tail_inertia * (s.body_rate_before + s.tail_rate),
        1e-12);
    // What the stop takes from the tail it gives to the body.
    EXPECT_NEAR(s.impulse, -c.body_inertia * (s.body_rate_after - s.body_rate_before), 1e-12);
  }
  EXPECT_GT(stops, 100);
}

TEST(Reorientation, MomentumChangesByTheDragImpulseAlone) {
  std::vector<ReorientationSample> history;
  const ReorientationCase c = paper_case();
  const ReorientationResult r = simulate_reorientation(c, 1e-11, &history);
  const double b = components::rotation_drag_factor(1.225, 2.0, 0.18, 0.6, 1.0);
  double impulse = 0.0;
  for (std::size_t i = 1; i < history.size() && history[i].time < r.stop->time; ++i) {
    const auto drag = [&](const ReorientationSample& s) {
      const double omega = s.body_rate + s.tail_rate;
      return -b * omega * std::abs(omega);
    };
    impulse +=
        0.5 * (history[i].time - history[i - 1].time) * (drag(history[i]) + drag(history[i - 1]));
  }
  EXPECT_NEAR(impulse, r.stop->momentum_before, 0.05 * std::abs(r.stop->momentum_before));
}

TEST(Reorientation, StiffnessTakesNoManySteps) {
  ReorientationCase c = fig3_case(1.0, 0.01, 50);
  const ReorientationResult r = simulate_reorientation(c);
  ASSERT_TRUE(r.converged);
  EXPECT_LT(r.steps, 60);
  // The motor's no-load rate bounds what so high a gear can reach.
  EXPECT_LT(r.tail_rate, c.motor.voltage / (c.motor.torque_constant * 50.0));
  EXPECT_NEAR(r.effectiveness, simulate_reorientation(c, 1e-11).effectiveness, 1e-5);
}

TEST(Reorientation, DefaultToleranceKeepsEffectivenessWithinTenMicro) {
  for (double length : {0.5, 0.75, 1.0}) {
    for (double x : {0.01, 0.1, 0.3, 0.6}) {
      for (int gear = 1; gear <= 50; gear += 3) {
        ReorientationCase c = fig3_case(length, x, gear);
        EXPECT_NEAR(simulate_reorientation(c).effectiveness,
                    simulate_reorientation(c, kTight).effectiveness, 1e-5);
      }
    }
  }
}

TEST(Reorientation, ARootSpringDelaysTheBodyAndAStiffOneDoesNot) {
  ReorientationCase c = paper_case();
  const double rigid = *simulate_reorientation(c, kTight).time_to_target;
  double last = rigid;
  for (double k : {1e6, 150.0, 100.0, 50.0}) {
    c.root_stiffness = k;
    const ReorientationResult r = simulate_reorientation(c, 1e-8);
    ASSERT_TRUE(r.converged && r.time_to_target);
    if (k == 1e6) {
      EXPECT_NEAR(*r.time_to_target, rigid, 1e-6);
    } else {
      EXPECT_GT(*r.time_to_target, last + 1e-4);
    }
    last = *r.time_to_target;
  }
}

TEST(Reorientation, WindOfNoSpeedIsStillAir) {
  ReorientationCase c = paper_case();
  const ReorientationResult still = simulate_reorientation(c, kTight);
  c.drag.kind = model::DragKind::distributed;
  EXPECT_NEAR(simulate_reorientation(c, kTight).body_angle, still.body_angle, 1e-12);
  c.pivot_velocity = Vec2(1e-9, 0.0);  // through the other branch
  EXPECT_NEAR(simulate_reorientation(c, kTight).body_angle, still.body_angle, 1e-7);
  c.pivot_velocity = Vec2(3.0, 1.0);
  c.drag.wind_W = Vec2(3.0, 1.0);  // air that moves along
  EXPECT_NEAR(simulate_reorientation(c, kTight).body_angle, still.body_angle, 1e-12);
}

TEST(Reorientation, ForwardSpeedAgainstTheSwingHelps) {
  ReorientationCase c = paper_case();
  c.drag.kind = model::DragKind::distributed;
  const double still = std::abs(simulate_reorientation(c).body_angle);
  // an upright tail that swings forwards, running forwards: faster through the air
  c.pivot_velocity = Vec2(3.0, 0.0);
  EXPECT_GT(std::abs(simulate_reorientation(c).body_angle), still + 0.01);
}

TEST(Reorientation, TorqueLimitHolds) {
  ReorientationCase c = paper_case();
  c.motor.current_limit = 20.0;
  c.motor_limits = true;
  std::vector<ReorientationSample> history;
  const ReorientationResult r = simulate_reorientation(c, 1e-8, &history);
  const double largest = components::largest_joint_torque(c.motor).value;
  double peak = 0.0;
  for (const ReorientationSample& s : history) peak = std::max(peak, s.joint_torque);
  EXPECT_NEAR(peak, largest, 1e-12);
  EXPECT_LT(std::abs(r.body_angle), std::abs(simulate_reorientation(paper_case()).body_angle));
}

// Jacobians against central differences, on states along and off the motion.
template <class System>
void check_jacobian(const System& system, std::mt19937& rng) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int k = 0; k < 50; ++k) {
    typename System::State y = system.scale(0.3);
    for (double& v : y) v *= 0.5 * unit(rng);
    const auto j = system.jacobian(y);
    for (int col = 0; col < System::N; ++col) {
      const double h = 1e-6 * system.scale(0.3)[col];
      typename System::State a = y, b = y;
      a[col] += h;
      b[col] -= h;
      const typename System::State slope = (system.rhs(a) - system.rhs(b)) / (2.0 * h);
      for (int row = 0; row < System::N + System::Q; ++row) {
        EXPECT_NEAR(j(row, col), slope[row], 2e-5 * (1.0 + j.col(col).cwiseAbs().maxCoeff()))
            << row << "," << col;
      }
    }
  }
}

TEST(Reorientation, JacobiansAgreeWithDifferences) {
  ReorientationCase c = paper_case();
  const detail::Bodies in(c);
  const detail::MotorCurve motor(c);
  const detail::Air still(c);
  c.drag.kind = model::DragKind::distributed;
  c.pivot_velocity = Vec2(4.0, -1.0);
  c.initial_tail_angle = 0.4;
  const detail::Air moving(c);
  std::mt19937 rng(11);
  check_jacobian(detail::RigidStill{in, motor, still}, rng);
  check_jacobian(detail::RigidWind{in, motor, moving}, rng);
  check_jacobian(detail::Sprung{in, motor, moving, 90.0}, rng);
  check_jacobian(detail::Locked{in, moving, 2.0}, rng);
}

TEST(Reorientation, RosenbrockStepIsOfOrderFour) {
  const ReorientationCase c = paper_case();
  const detail::Bodies in(c);
  const detail::MotorCurve motor(c);
  const detail::Air air(c);
  const detail::RigidStill system{in, motor, air};
  const auto angle_after = [&](int steps) {
    detail::RigidStill::State y = system.start(), error;
    for (int i = 0; i < steps; ++i) y = detail::RosenbrockStep(system, y).step(0.1 / steps, error);
    return y[2];
  };
  const double exact = angle_after(3000);
  const double order =
      std::log2(std::abs(angle_after(40) - exact) / std::abs(angle_after(80) - exact));
  EXPECT_NEAR(order, 4.0, 0.5);
}

TEST(Reorientation, FaultsAreNamed) {
  EXPECT_EQ(check_case(paper_case()), "");
  const auto fault = [](auto edit) {
    ReorientationCase c = paper_case();
    edit(c);
    return check_case(c);
  };
  EXPECT_NE(fault([](auto& c) { c.body_inertia = 0.0; }).find("body inertia"), std::string::npos);
  EXPECT_NE(fault([](auto& c) { c.tail_inertia = -1.0; }).find("tail inertia"), std::string::npos);
  EXPECT_NE(fault([](auto& c) { c.motor.gear = 0.0; }).find("gear"), std::string::npos);
  EXPECT_NE(fault([](auto& c) { c.drag.start = 1.2; }).find("shaft"), std::string::npos);
  EXPECT_NE(fault([](auto& c) { c.motor.voltage = kNaN; }).find("voltage"), std::string::npos);
  EXPECT_NE(fault([](auto& c) {
              c.motor_limits = true;
              c.motor.torque_limit = 0.0;
            }).find("no torque"),
            std::string::npos);
}

}  // namespace
}  // namespace jaculus::studies
