// With no effect, a plan comes back: the plant plays what the solver planned. Remainders are of the
// plan's grid, whose fourth order shows where it is refined.

#include <gtest/gtest.h>

#include <numbers>

#include "jaculus/solver/plan.h"
#include "simulation/support.h"
#include "support/shared_data.h"
#include "transcription/example_problems.h"

namespace jaculus::simulation {
namespace {

using namespace test;

/// Largest differences of a playback from its plan up to lift-off, at the plan's own samples.
struct Departure {
  double position = 0.0;  ///< of x and z [m]
  double pitch = 0.0;     ///< [rad]
  double velocity = 0.0;  ///< of x and z [m/s]
};

struct Solved {
  model::PlanarModel model;
  trajectory::Table plan;
};

/// The robot of a problem, its overrides applied and coordinates locked, with its own friction and
/// battery in place of the margins that the plan keeps.
model::PlanarModel robot_of(const transcription::Problem& problem) {
  const model::PlanarModel own = model::read_robot(problem.robot_folder, problem.overrides).planar;
  model::PlanarModel model = model_of(problem);
  model.friction = own.friction;
  for (model::PlanarMotor& motor : model.motors) motor = own.motors[own.motor_index(motor.joint)];
  return model;
}

Solved solve(const std::string& name, const std::vector<int>& grid = {}) {
  transcription::Problem problem = transcription::read_problem(problem_file(name));
  if (!grid.empty()) problem = on_grid(problem, grid);
  const model::Robot robot = model::read_robot(problem.robot_folder, problem.overrides);
  const solver::Plan plan = solver::make_plan(problem, robot.planar);
  EXPECT_TRUE(plan.converged()) << name;
  return {robot_of(problem), trajectory::to_table(*plan.trajectory)};
}

Simulation play(const Solved& solved, double rate_hz, double kp, double kd) {
  Controller c;
  c.rate_hz = rate_hz;
  c.reference = plan_reference(solved.plan, solved.model, Quantity::torque, 16.0, "plan.csv");
  const auto motors = std::ssize(c.reference.motors);
  c.kp = Vector::Constant(motors, kp);
  c.kd = Vector::Constant(motors, kd);
  const Plant plant = nominal_plant(solved.model);
  SimulationOptions options;
  options.duration = c.reference.duration;
  options.sample_times = c.reference.time;
  const Simulation s = simulate(plant, c, reference_start(plant, c.reference), options);
  EXPECT_EQ(s.status, SimulationStatus::done) << s.message;
  return s;
}

Departure departure(const Solved& solved, const Simulation& s) {
  Departure d;
  EXPECT_EQ(s.time.size(), solved.plan.values.rows());
  const auto worst = [&](const std::string& name, const Matrix& values, double& out) {
    const int i = solved.model.coordinate_index(name.substr(0, name.find('_')));
    const Vector plan = solved.plan.values.col(solved.plan.column(name)).head(s.time.size());
    out = std::max(out, (values.row(i).transpose() - plan).cwiseAbs().maxCoeff());
  };
  for (const std::string axis : {"x", "z"}) {
    worst(axis, s.q, d.position);
    worst(axis + "_velocity", s.v, d.velocity);
  }
  worst("pitch", s.q, d.pitch);
  return d;
}

void print(const std::string& what, const Departure& d) {
  std::printf("%-34s %.3f mm  %.4f deg  %.5f m/s\n", what.c_str(), 1e3 * d.position,
              d.pitch * 180.0 / std::numbers::pi, d.velocity);
}

constexpr double kTenthDegree = 0.1 * std::numbers::pi / 180.0;

class Playback : public ::testing::TestWithParam<const char*> {};

TEST_P(Playback, PlanComesBackWithFeedback) {
  const Solved solved = solve(GetParam());
  const Departure d = departure(solved, play(solved, kInfinity, 20.0, 0.4));
  print(std::string(GetParam()) + ", with PD", d);
  EXPECT_LT(d.position, 1e-3);
  EXPECT_LT(d.pitch, kTenthDegree);
  EXPECT_LT(d.velocity, 0.02);
  const Departure sampled = departure(solved, play(solved, 1000.0, 20.0, 0.4));
  print("  sampled at 1 kHz", sampled);
  EXPECT_LT(sampled.position, 2e-3);
  EXPECT_LT(sampled.pitch, 2.0 * kTenthDegree);
}

TEST_P(Playback, PlanComesBackByFeedForwardAlone) {
  const Solved solved = solve(GetParam());
  const Departure d = departure(solved, play(solved, kInfinity, 0.0, 0.0));
  print(std::string(GetParam()) + ", feed-forward", d);
  EXPECT_LT(d.position, 1e-3);
  EXPECT_LT(d.velocity, 0.02);
}

TEST(FinerPlan, ComesBackCloserByFeedForwardAlone) {
  const Solved solved = solve("leap_tail_as_published", {45, 15});
  const Departure d = departure(solved, play(solved, kInfinity, 0.0, 0.0));
  print("leap_tail on a finer grid", d);
  EXPECT_LT(d.position, 1e-3);
  EXPECT_LT(d.pitch, kTenthDegree);
  EXPECT_LT(d.velocity, 0.02);
}

INSTANTIATE_TEST_SUITE_P(
    Leaps, Playback,
    ::testing::Values("leap_tailless", "leap_tail", "leap_tailless_as_published",
                      "leap_inactive_as_published", "leap_inertial_as_published",
                      "leap_tail_as_published", "leap_tailless_15deg_as_published",
                      "leap_inertial_15deg_as_published", "leap_tail_15deg_as_published",
                      "leap_inactive_0deg_as_published"),
    [](const auto& p) { return std::string(p.param); });

/// The authors' own plans, duty of their own 7 V on a bus of 16 V as they were replayed, under
/// joint PD: they must come back stably.
TEST(AuthorsPlans, PlayBackStablyWithFeedback) {
  JACULUS_REQUIRE_SHARED_DATA(folder);
  for (const char* name :
       {"notail_V7", "aerotail_V7_nodes82", "aerotail_V7_stableland", "aerotail_V7",
        "inactivetail_V7", "notail_Vel15_V8", "aerotail_Vel15_V8"}) {
    const std::string plan = name;
    const bool tailless = plan.starts_with("notail"), inactive = plan.starts_with("inactive");
    transcription::Problem problem = transcription::read_problem(
        problem_file(tailless ? "leap_tailless" : (inactive ? "leap_inactive" : "leap_tail")));
    const Solved solved{robot_of(problem),
                        trajectory::read_csv(folder / "plans" / (plan + ".csv"))};
    for (const Quantity quantity : {Quantity::torque, Quantity::duty}) {
      Controller c;
      c.quantity = quantity;
      c.reference = plan_reference(solved.plan, solved.model, quantity, 16.0, plan);
      const auto motors = std::ssize(c.reference.motors);
      const bool duty = quantity == Quantity::duty;
      c.kp = Vector::Constant(motors, duty ? 2.0 : 20.0);
      c.kd = Vector::Constant(motors, duty ? 0.04 : 0.4);
      const Plant plant = nominal_plant(solved.model);
      SimulationOptions options;
      options.duration = c.reference.duration;
      options.sample_times = c.reference.time;
      const Simulation s = simulate(plant, c, reference_start(plant, c.reference), options);
      ASSERT_EQ(s.status, SimulationStatus::done) << plan << ": " << s.message;
      const Departure d = departure(solved, s);
      print(plan + (duty ? ", duty" : ", torque"), d);
      EXPECT_LT(d.position, 0.01) << plan;
      EXPECT_LT(d.pitch, 0.03) << plan;
      EXPECT_LT(d.velocity, 0.15) << plan;
    }
  }
}

}  // namespace
}  // namespace jaculus::simulation
