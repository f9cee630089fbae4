// The plant on a leap, without and with dry friction, and a drop: simulations a second, real-time
// factor, evaluations, and the error against a tight reference. And what an effect of a file costs
// beside the same in C++.

#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>

#include "jaculus/core/installation.h"
#include "jaculus/effects/user_effect.h"
#include "jaculus/model/robot.h"
#include "jaculus/simulation/experiment.h"
#include "jaculus/simulation/simulate.h"
#include "support/lugre.h"

namespace jaculus {
namespace {

struct Case {
  simulation::Plant plant;
  simulation::Controller controller;
  simulation::StartState start;
  double duration;
};

/// Minitaur with tail pushes off within 0.25 s under joint PD of torque, sampled at 1 kHz.
Case leap() {
  const model::PlanarModel model = model::read_robot(model::find_robot("minitaur_tail", "")).planar;
  Case c{simulation::nominal_plant(model), {}, {}, 0.25};
  simulation::Reference& r = c.controller.reference;
  const auto motors = std::ssize(model.motors);
  constexpr Eigen::Index samples = 26;
  r.time = Vector::LinSpaced(samples, 0.0, c.duration);
  r.duration = c.duration;
  r.position.resize(motors, samples);
  r.velocity.resize(motors, samples);
  for (Eigen::Index m = 0; m < motors; ++m) {
    r.motors.push_back(model.motors[m].joint);
    const double sweep =
        r.motors.back() == "tail" ? -1.2 : (r.motors.back().starts_with("rear") ? 1.2 : 0.9);
    for (Eigen::Index k = 0; k < samples; ++k) {
      const double s = r.time[k] / c.duration;
      r.position(m, k) = 1.0 + sweep * s * s;
      r.velocity(m, k) = 2.0 * sweep * s / c.duration;
    }
    r.initial[r.motors.back()] = 1.0;
  }
  c.controller.kp = Vector::Constant(motors, 8.0);
  c.controller.kd = Vector::Constant(motors, 0.15);
  c.controller.kp[motors - 1] = 0.5;
  c.controller.kd[motors - 1] = 0.02;
  c.start = simulation::reference_start(c.plant, r);
  return c;
}

/// The tail at full battery against its stop while the body falls.
Case drop() {
  const model::PlanarModel model = model::read_robot(model::find_robot("self_righting", "")).planar;
  Case c{simulation::nominal_plant(model), {}, {Vector::Zero(2), Vector::Zero(2)}, 0.32};
  c.plant.stops = {{"tail", {-kInfinity, std::numbers::pi}, 0.0}};
  c.controller.quantity = trajectory::Quantity::voltage;
  c.controller.rate_hz = kInfinity;
  c.controller.after_end = simulation::AfterEnd::repeat;
  c.controller.reference.motors = {"tail"};
  c.controller.reference.time = Vector::Zero(1);
  c.controller.reference.feedforward = Matrix::Constant(1, 1, 16.0);
  return c;
}

simulation::SimulationOptions options_of(const Case& c, int samples, double tolerance) {
  simulation::SimulationOptions options;
  options.duration = c.duration;
  options.sample_times = Vector::LinSpaced(samples, 0.0, c.duration);
  options.relative_tolerance = tolerance;
  options.absolute_tolerance = 1e-2 * tolerance;
  return options;
}

void run(benchmark::State& state, const Case& c, int samples) {
  const simulation::SimulationOptions options =
      options_of(c, samples, std::pow(10.0, -static_cast<double>(state.range(0))));
  simulation::Simulation s;
  for (auto _ : state) {
    s = simulation::simulate(c.plant, c.controller, c.start, options);
    benchmark::DoNotOptimize(s.q.data());
  }
  if (s.status != simulation::SimulationStatus::done) state.SkipWithError(s.message.c_str());
  const simulation::Simulation tight =
      simulation::simulate(c.plant, c.controller, c.start, options_of(c, samples, 1e-11));
  state.counters["evaluations"] = static_cast<double>(s.evaluations);
  state.counters["error_rad_or_m"] = (s.q - tight.q).cwiseAbs().maxCoeff();
  state.counters["real_time_factor"] = benchmark::Counter(
      c.duration, benchmark::Counter::kIsIterationInvariantRate, benchmark::Counter::kIs1000);
}

void leap_1khz(benchmark::State& state) { run(state, leap(), 61); }
BENCHMARK(leap_1khz)->Arg(4)->Arg(6)->Arg(8)->Unit(benchmark::kMillisecond);

void leap_with_dry_friction(benchmark::State& state) {
  Case c = leap();
  for (const model::PlanarMotor& motor : c.plant.model.motors)
    c.plant.friction.push_back({.joint = motor.joint, .coulomb = 0.3, .stribeck = 0.3});
  run(state, c, 61);
}
BENCHMARK(leap_with_dry_friction)->Arg(4)->Arg(6)->Arg(8)->Unit(benchmark::kMillisecond);

void drop_of_two_bodies(benchmark::State& state) { run(state, drop(), 77); }
BENCHMARK(drop_of_two_bodies)->Arg(4)->Arg(6)->Arg(8)->Unit(benchmark::kMillisecond);

/// A trial of pendulum_trials with LuGre friction.
void with_lugre(benchmark::State& state, bool by_file) {
  const simulation::Experiment experiment =
      simulation::read_experiment(source_folder() / "problems" / "pendulum_trials.yaml");
  const model::PlanarModel model = simulation::dataset_robot(experiment.setup).planar;
  const simulation::Controller controller = simulation::experiment_controller(experiment, model);
  const effects::UserEffect user =
      effects::read_user_effect(source_folder() / "effects" / "lugre.yaml");
  const Vector theta = user.effect.probed();
  simulation::Plant plant = simulation::dataset_plant(experiment.setup, model);
  if (by_file)
    user.effect.apply(theta, plant);
  else
    plant.laws = {test::lugre("pendulum", theta)};
  for (auto _ : state) {
    const auto trial = simulation::run_trial(experiment, plant, controller, 0, 1);
    benchmark::DoNotOptimize(trial.truth.q.data());
    state.counters["evaluations"] = static_cast<double>(trial.truth.evaluations);
  }
}
void lugre_in_cpp(benchmark::State& state) { with_lugre(state, false); }
BENCHMARK(lugre_in_cpp)->Unit(benchmark::kMillisecond);
void lugre_by_file(benchmark::State& state) { with_lugre(state, true); }
BENCHMARK(lugre_by_file)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace jaculus
