// Staircases of a sampled loop on the grid of predictions.

#include "diagnosis/forward/grid_simulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "jaculus/core/error.h"
#include "jaculus/core/installation.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::diagnosis {
namespace {

constexpr double kEnd = 0.15, kCell = 1e-3;  // s

Vector evenly(double step, double from, double to) {
  std::vector<double> times;
  for (double t = from; t < to + 0.5 * step; t += step) times.push_back(std::min(t, to));
  return Eigen::Map<Vector>(times.data(), static_cast<Eigen::Index>(times.size()));
}

/// The shipped leap, its loop at 1 kHz: arrivals and points of the grid coincide.
struct Leap {
  Leap()
      : experiment(simulation::read_experiment(source_folder() / "problems" / "leap_trials.yaml")) {
    const model::Robot robot = simulation::dataset_robot(experiment.setup);
    plant = simulation::dataset_plant(experiment.setup, robot.planar);
    controller = simulation::experiment_controller(experiment, robot.planar);
    start = simulation::reference_start(plant, controller.reference);
    // Off the plan a little, so that the loop answers with steps.
    plant.actuation.torque_scale = {{"tail", 0.8}, {"rear_a", 0.9}};
    options.duration = kEnd;
    options.sample_times = evenly(kCell, 0.0, kEnd);
  }
  [[nodiscard]] simulation::Simulation delayed(double delay) {
    plant.actuation.delay = delay;
    return simulate_on_grid(plant, controller, start, options);
  }

  simulation::Experiment experiment;
  simulation::Plant plant;
  simulation::Controller controller;
  simulation::StartState start;
  simulation::SimulationOptions options;
};

double departure(const simulation::Simulation& a, const simulation::Simulation& b) {
  return (a.current - b.current).cwiseAbs().maxCoeff() / a.current.cwiseAbs().maxCoeff();
}

TEST(GridSimulation, IsContinuousInTheDelay) {
  Leap leap;
  const simulation::Simulation prompt = leap.delayed(0.0), hardly = leap.delayed(1e-8);
  ASSERT_EQ(prompt.status, simulation::SimulationStatus::done) << prompt.message;
  ASSERT_EQ(prompt.time.size(), leap.options.sample_times.size());
  EXPECT_LT(departure(prompt, hardly), 1e-4);
  // Neither does it jump where arrivals pass points of the grid or middles of its cells.
  for (const double at : {0.5e-3, 1e-3, 1.5e-3})
    EXPECT_LT(departure(leap.delayed(at - 1e-8), leap.delayed(at + 1e-8)), 1e-4) << at;
}

/// Mean of a finely sampled simulation over the cell about t.
Matrix mean_about(const simulation::Simulation& dense, double t) {
  Matrix sum = Matrix::Zero(dense.current.rows(), 3);
  double bus = 0.0;
  int count = 0;
  for (Eigen::Index i = 0; i < dense.time.size(); ++i) {
    if (std::abs(dense.time[i] - t) > 0.5 * kCell) continue;
    sum.col(0) += dense.current.col(i);
    sum.col(1) += dense.torque.col(i);
    sum.col(2) += dense.voltage.col(i);
    bus += dense.bus_voltage[i];
    ++count;
  }
  Matrix means(sum.rows(), 4);
  means << sum / count, Vector::Constant(sum.rows(), bus / count);
  return means;
}

TEST(GridSimulation, GivesTheStaircasesMeanOverACell) {
  // a part a hold, two, and holds that no cell knows
  for (const double rate : {1000.0, 500.0, 700.0}) {
    SCOPED_TRACE(rate);
    Leap leap;
    leap.plant.battery.resistance = 0.02;
    leap.plant.actuation.late_start = 0.2e-3;
    leap.controller.rate_hz = rate;
    const simulation::Simulation grid = leap.delayed(0.3e-3);
    ASSERT_EQ(grid.status, simulation::SimulationStatus::done) << grid.message;
    simulation::SimulationOptions fine = leap.options;
    fine.sample_times = evenly(2e-5, 1e-5, kEnd - 1e-5);
    const simulation::Simulation dense =
        simulation::simulate(leap.plant, leap.controller, leap.start, fine);
    const double largest[] = {dense.current.cwiseAbs().maxCoeff(),
                              dense.torque.cwiseAbs().maxCoeff(),
                              dense.voltage.cwiseAbs().maxCoeff(), dense.bus_voltage.maxCoeff()};
    for (const int k : {5, 40, 90, 130}) {
      Matrix own(grid.current.rows(), 4);
      own << grid.current.col(k), grid.torque.col(k), grid.voltage.col(k),
          Vector::Constant(grid.current.rows(), grid.bus_voltage[k]);
      const Matrix off = (mean_about(dense, k * kCell) - own).cwiseAbs();
      for (int c = 0; c < 4; ++c)
        EXPECT_LT(off.col(c).maxCoeff(), 0.01 * largest[c]) << k << ' ' << c;
    }
  }
}

TEST(GridSimulation, LeavesWhatTheLoopDoesNotHoldAsItIs) {
  Leap leap;
  const simulation::Simulation grid = leap.delayed(0.4e-3);
  const simulation::Simulation plain =
      simulation::simulate(leap.plant, leap.controller, leap.start, leap.options);
  EXPECT_LT((grid.q - plain.q).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_LT((grid.motor_velocity - plain.motor_velocity).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(GridSimulation, IsTheSimulationItselfWhereNoLoopSamples) {
  Leap leap;
  leap.controller.rate_hz = kInfinity;
  const simulation::Simulation grid = leap.delayed(0.0);
  const simulation::Simulation plain =
      simulation::simulate(leap.plant, leap.controller, leap.start, leap.options);
  EXPECT_EQ(grid.current, plain.current);
  leap.controller.rate_hz = 0.0;
  EXPECT_THROW(leap.delayed(0.0), InputError);
}

}  // namespace
}  // namespace jaculus::diagnosis
