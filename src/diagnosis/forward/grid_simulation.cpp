#include "diagnosis/forward/grid_simulation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace jaculus::diagnosis {
namespace {

using simulation::Controller;
using simulation::Plant;
using simulation::Simulation;
using simulation::SimulationOptions;
using simulation::SimulationStatus;
using simulation::StartState;

/// A part of a hold.
struct Hold {
  double from = 0.0, to = 0.0;  ///< [s]
  [[nodiscard]] double middle() const { return 0.5 * (from + to); }
};

std::vector<Hold> holds_of(const Plant& plant, const Controller& controller, double end,
                           double cell) {
  std::vector<Hold> holds;
  const double first = plant.actuation.delay + plant.actuation.late_start;
  for (long j = first > 0.0 ? -1 : 0;; ++j) {
    const double from = j < 0 ? 0.0 : first + static_cast<double>(j) / controller.rate_hz;
    const double to = std::min(end, first + static_cast<double>(j + 1) / controller.rate_hz);
    if (from >= end) return holds;
    const double parts = std::ceil((to - from) / cell - 1e-9);
    for (double i = 0.0; i < parts; ++i)
      holds.push_back({from + i / parts * (to - from), from + (i + 1.0) / parts * (to - from)});
  }
}

/// Grid and middles of holds, rising; a middle on a point of the grid is that point.
Vector merged(const Vector& grid, const std::vector<Hold>& holds) {
  std::vector<double> times(grid.begin(), grid.end());
  for (const Hold& hold : holds) times.push_back(hold.middle());
  std::sort(times.begin(), times.end());
  const auto same = [](double a, double b) { return b - a < 1e-12; };
  times.erase(std::unique(times.begin(), times.end(), same), times.end());
  return Eigen::Map<const Vector>(times.data(), count_of(times));
}

std::vector<Eigen::Index> places(const Vector& times, const std::vector<double>& wanted) {
  std::vector<Eigen::Index> found;
  for (const double t : wanted)
    found.push_back(std::lower_bound(times.begin(), times.end(), t - 1e-12) - times.begin());
  return found;
}

/// Columns: means of the holds' values over the cells of the grid.
Matrix cell_means(const Matrix& at_holds, const std::vector<Hold>& holds, const Vector& grid,
                  double cell) {
  Matrix means = Matrix::Zero(at_holds.rows(), grid.size());
  std::size_t first = 0;
  for (Eigen::Index k = 0; k < grid.size(); ++k) {
    const double from = std::max(0.0, grid[k] - 0.5 * cell),
                 to = std::min(holds.back().to, grid[k] + 0.5 * cell);
    while (first + 1 < holds.size() && holds[first].to <= from) ++first;
    double covered = 0.0;
    for (std::size_t i = first; i < holds.size() && holds[i].from < to; ++i) {
      const double share = std::min(to, holds[i].to) - std::max(from, holds[i].from);
      means.col(k) += share * at_holds.col(i);
      covered += share;
    }
    means.col(k) /= covered;
  }
  return means;
}

}  // namespace

Simulation simulate_on_grid(const Plant& plant, const Controller& controller,
                            const StartState& start, const SimulationOptions& options) {
  const Vector& grid = options.sample_times;
  const bool sampled = controller.rate_hz > 0.0 && std::isfinite(controller.rate_hz);
  if (!sampled || grid.size() < 2) return simulate(plant, controller, start, options);

  const double cell = grid[1] - grid[0];
  const std::vector<Hold> holds = holds_of(plant, controller, grid[grid.size() - 1], cell);
  SimulationOptions both = options;
  both.sample_times = merged(grid, holds);
  Simulation s = simulate(plant, controller, start, both);
  if (s.status != SimulationStatus::done || s.time.size() != both.sample_times.size()) return s;

  std::vector<double> middles;
  for (const Hold& hold : holds) middles.push_back(hold.middle());
  const std::vector<Eigen::Index> at_grid = places(s.time, {grid.begin(), grid.end()}),
                                  at_holds = places(s.time, middles);
  for (Matrix* m : {&s.torque, &s.current, &s.voltage})
    *m = cell_means((*m)(Eigen::all, at_holds), holds, grid, cell);
  s.bus_voltage = cell_means(s.bus_voltage(at_holds).transpose(), holds, grid, cell).transpose();
  for (Matrix* m : {&s.q, &s.v, &s.motor_position, &s.motor_velocity, &s.force})
    *m = (*m)(Eigen::all, at_grid).eval();
  s.time = grid;
  return s;
}

}  // namespace jaculus::diagnosis
