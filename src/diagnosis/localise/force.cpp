#include "diagnosis/localise/force.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnosis/localise/windows.h"
#include "jaculus/dynamics/rigid_body.h"

namespace jaculus::diagnosis {
namespace {

using dynamics::AbsoluteTree;
using dynamics::Motion;
using model::Coordinate;
using model::PlanarModel;
using simulation::Simulation;
using simulation::SimulationStatus;
using simulation::StartState;

/// One restart from a measured state to the next.
struct Step {
  double begin = 0.0, length = 0.0;  ///< [s]
  StartState start;
  Vector missing;  ///< measured less restarted rate at the end
  Matrix mass;     ///< at the end
  Matrix covariance;
};

/// Rates at the end of a step by a set-up; empty where it can't be simulated.
Vector end_rates(SimulationSetup setup, const Step& step) {
  setup.start = step.start;
  setup.controller = controller_from(setup.controller, step.begin);
  setup.options.sample_times = Vector::LinSpaced(2, 0.0, step.length);
  setup.options.duration = step.length;
  const Simulation simulated = simulate(setup.plant, setup.controller, setup.start, setup.options);
  if (simulated.status != SimulationStatus::done || simulated.time.size() != 2 ||
      !simulated.v.allFinite())
    return {};
  return simulated.v.col(1);
}

/// Puts the model's mass matrix at q into the step; false where loops can't close.
bool set_mass(const AbsoluteTree& tree, const Vector& q, Step& step) {
  Motion motion(tree);
  if (!set_configuration(tree, q, motion)) return false;
  step.mass = mass_matrix(tree, motion);
  return true;
}

std::vector<Step> measured_steps(const SimulationSetup& setup,
                                 const std::vector<DepartureChannel>& means, double end,
                                 const Settings& settings) {
  std::vector<Step> steps;
  const Simulation simulated = simulate(setup.plant, setup.controller, setup.start, setup.options);
  if (simulated.status != SimulationStatus::done || simulated.time.size() < 3) return steps;

  const AbsoluteTree tree(setup.plant.model);
  const auto stride = std::max<Eigen::Index>(
      1, std::lround(settings.force_step / (simulated.time[1] - simulated.time[0])));
  MeasuredState last;
  for (Eigen::Index k = stride / 2; k < simulated.time.size() && simulated.time[k] <= end;
       k += stride) {
    const MeasuredState now = measured_state(setup.plant.model, means, simulated, k, settings);
    if (last.ok && now.ok && now.stance == last.stance) {
      Step step;
      step.begin = simulated.time[k - stride];
      step.length = simulated.time[k] - step.begin;
      step.start = {last.q, last.v};
      const Vector restarted = end_rates(setup, step);
      step.covariance = last.rate_covariance + now.rate_covariance;
      const Eigen::LLT<Matrix> factor(step.covariance);
      if (restarted.size() > 0 && factor.info() == Eigen::Success && set_mass(tree, now.q, step)) {
        step.missing = now.v - restarted;
        steps.push_back(std::move(step));
      }
    }
    last = now;
  }

  return steps;
}

ForceResidual residual_of(const PlanarModel& model, const std::vector<Step>& steps) {
  ForceResidual out;
  for (const Coordinate& coordinate : model.coordinates) {
    out.coordinates.push_back(coordinate.name);
    out.units.emplace_back(coordinate.angular ? "N m" : "N");
  }

  const auto count = count_of(steps);
  out.time.resize(count);
  out.mean.resize(model.size(), count);
  out.deviation.resize(model.size(), count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Step& step = steps[i];
    out.time[i] = step.begin + 0.5 * step.length;
    out.mean.col(i) = step.mass * step.missing / step.length;
    out.deviation.col(i) =
        (step.mass * step.covariance * step.mass).diagonal().cwiseMax(0.0).cwiseSqrt() /
        step.length;
  }

  return out;
}

}  // namespace

ForceResidual force_residual(const Problem& problem, const ResidualRows& rows,
                             const std::vector<DepartureChannel>& means,
                             const PlantForward& forward, const Vector& p) {
  const PlanarModel& model = rows.observed.model;
  if (!all_measured(model, means)) return {};
  for (const Candidate& candidate : problem.hypotheses.candidates)
    if (Vector(p(candidate.parameters)) != candidate.effect->nominal()) return {};

  const SimulationSetup setup = forward.setup(rows.dataset, 0, p);
  const std::vector<Step> steps =
      measured_steps(setup, means, rows.observed.window_end, problem.settings);
  return steps.size() < 3 ? ForceResidual{} : residual_of(model, steps);
}

}  // namespace jaculus::diagnosis
