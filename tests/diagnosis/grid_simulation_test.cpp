// Staircases of a sampled loop on the grid of predictions.

#include "diagnosis/grid_simulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "jaculus/simulation/experiment.h"

namespace jaculus {
namespace {

constexpr double kEnd = 0.15, kCell = 1e-3;  // s

Vector evenly(double step, double from, double to) {
  std::vector<double> times;
  for (double t = from; t < to + 0.5 * step; t += step) times.push_back(std::min(t, to));
  return Eigen::Map<Vector>(times.data(), static_cast<Eigen::Index>(times.size()));
}

/// The shipped leap, its loop at 1 kHz: arrivals and points of the grid coincide.
struct Leap {
  Leap() : experiment(read_experiment(std::filesystem::path(JACULUS_SOURCE_DIR) / "problems" / "leap_trials.yaml")) {
    const Robot robot = dataset_robot(experiment.setup);
    plant = dataset_plant(experiment.setup, robot.planar);
    controller = experiment_controller(experiment, robot.planar);
    start = reference_start(plant, controller.reference);
    // Off the plan a little, so that the loop answers with steps.
    plant.actuation.torque_scale = {{"tail", 0.8}, {"rear_a", 0.9}};
    options.duration = kEnd;
    options.sample_times = evenly(kCell, 0.0, kEnd);
  }
  [[nodiscard]] Simulation delayed(double delay) {
    plant.actuation.delay = delay;
    return simulate_on_grid(plant, controller, start, options);
  }

  Experiment experiment;
  Plant plant;
  Controller controller;
  StartState start;
  SimulationOptions options;
};

double departure(const Simulation& a, const Simulation& b) {
  return (a.current - b.current).cwiseAbs().maxCoeff() / a.current.cwiseAbs().maxCoeff();
}

TEST(GridSimulation, IsContinuousInTheDelay) {
  Leap leap;
  const Simulation prompt = leap.delayed(0.0), hardly = leap.delayed(1e-8);
  ASSERT_EQ(prompt.status, SimulationStatus::done) << prompt.message;
  ASSERT_EQ(prompt.time.size(), leap.options.sample_times.size());
  EXPECT_LT(departure(prompt, hardly), 1e-4);
  // Neither does it jump where arrivals pass points of the grid or middles of its cells.
  for (const double at : {0.5e-3, 1e-3, 1.5e-3})
    EXPECT_LT(departure(leap.delayed(at - 1e-8), leap.delayed(at + 1e-8)), 1e-4) << at;
}

TEST(GridSimulation, GivesTheStaircasesMeanOverACell) {
  Leap leap;
  leap.plant.actuation.delay = 0.3e-3;
  const Simulation grid = leap.delayed(0.3e-3);
  SimulationOptions fine = leap.options;
  fine.sample_times = evenly(2e-5, 1e-5, kEnd - 1e-5);
  const Simulation dense = simulate(leap.plant, leap.controller, leap.start, fine);
  const double largest = dense.current.cwiseAbs().maxCoeff();
  for (const int k : {5, 40, 90, 130}) {
    Vector sum = Vector::Zero(dense.current.rows());
    int count = 0;
    for (Eigen::Index i = 0; i < dense.time.size(); ++i) {
      if (std::abs(dense.time[i] - k * kCell) > 0.5 * kCell) continue;
      sum += dense.current.col(i);
      ++count;
    }
    EXPECT_LT((sum / count - grid.current.col(k)).cwiseAbs().maxCoeff(), 0.01 * largest) << k;
  }
}

TEST(GridSimulation, LeavesWhatTheLoopDoesNotHoldAsItIs) {
  Leap leap;
  const Simulation grid = leap.delayed(0.4e-3);
  const Simulation plain = simulate(leap.plant, leap.controller, leap.start, leap.options);
  EXPECT_LT((grid.q - plain.q).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_LT((grid.motor_velocity - plain.motor_velocity).cwiseAbs().maxCoeff(), 1e-3);
  leap.controller.rate_hz = 500.0;  // two parts a hold
  const Simulation slow = leap.delayed(0.0);
  EXPECT_EQ(slow.status, SimulationStatus::done) << slow.message;
  EXPECT_TRUE(slow.current.allFinite());
  EXPECT_EQ(slow.current.cols(), leap.options.sample_times.size());
}

}  // namespace
}  // namespace jaculus
