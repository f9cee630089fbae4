#include "diagnosis/localise_force.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnosis/localise_windows.h"
#include "jaculus/dynamics/rigid_body.h"

namespace jaculus {
namespace {

constexpr double kStep = 0.02;  // s, between measured states

/// One restart from a measured state to the next.
struct Step {
  double begin = 0.0, length = 0.0;  ///< [s]
  StartState start;
  Vector missing;   ///< measured less restarted rate at the end
  Matrix mass;      ///< at the end
  Matrix whitener;  ///< L^-1 of the covariance of `missing`
  Matrix covariance;
};

/// Rates at the end of a step by a set-up; empty where it can't be simulated.
Vector end_rates(RunSetup setup, const Step& step) {
  setup.start = step.start;
  setup.controller = controller_from(setup.controller, step.begin);
  setup.options.sample_times = Vector::LinSpaced(2, 0.0, step.length);
  setup.options.duration = step.length;
  const Simulation run = simulate(setup.plant, setup.controller, setup.start, setup.options);
  if (run.status != SimulationStatus::done || run.time.size() != 2 || !run.v.allFinite()) return {};
  return run.v.col(1);
}

/// Puts the model's mass matrix at q into the step; false where loops can't close.
bool set_mass(const AbsoluteTree& tree, const Vector& q, Step& step) {
  Motion motion(tree);
  if (!set_configuration(tree, q, motion)) return false;
  step.mass = mass_matrix(tree, motion);
  return true;
}

std::vector<Step> measured_steps(const RunSetup& setup, const std::vector<DepartureChannel>& means, double end) {
  std::vector<Step> steps;
  const Simulation run = simulate(setup.plant, setup.controller, setup.start, setup.options);
  if (run.status != SimulationStatus::done || run.time.size() < 3) return steps;
  const AbsoluteTree tree(setup.plant.model);
  const auto stride = static_cast<Eigen::Index>(std::lround(kStep / (run.time[1] - run.time[0])));
  MeasuredState last;
  for (Eigen::Index k = stride / 2; k < run.time.size() && run.time[k] <= end; k += stride) {
    const MeasuredState now = measured_state(setup.plant.model, means, run, k);
    if (last.ok && now.ok && now.stance == last.stance) {
      Step step;
      step.begin = run.time[k - stride];
      step.length = run.time[k] - step.begin;
      step.start = {last.q, last.v};
      const Vector restarted = end_rates(setup, step);
      step.covariance = last.rate_covariance + now.rate_covariance;
      const Eigen::LLT<Matrix> factor(step.covariance);
      if (restarted.size() > 0 && factor.info() == Eigen::Success && set_mass(tree, now.q, step)) {
        step.missing = now.v - restarted;
        step.whitener = factor.matrixL().solve(Matrix::Identity(now.v.size(), now.v.size()));
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
  const auto count = static_cast<Eigen::Index>(steps.size());
  out.time.resize(count);
  out.mean.resize(model.size(), count);
  out.deviation.resize(model.size(), count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Step& step = steps[static_cast<size_t>(i)];
    out.time[i] = step.begin + 0.5 * step.length;
    out.mean.col(i) = step.mass * step.missing / step.length;
    out.deviation.col(i) = (step.mass * step.covariance * step.mass).diagonal().cwiseMax(0.0).cwiseSqrt() / step.length;
  }
  return out;
}

/// Whitened change of the steps' end rates per prior width of one column; zero where a step can't be simulated with it.
Vector column_of(const DiagnosisProblem& problem, const RunSetup& setup, const std::vector<Step>& steps,
                 const SignatureColumn& column) {
  const Candidate& candidate = problem.hypotheses.candidates[static_cast<size_t>(column.candidate)];
  const auto index = static_cast<size_t>(candidate.parameters[static_cast<size_t>(column.parameter)]);
  const auto n = static_cast<Eigen::Index>(setup.plant.model.size());
  Vector out = Vector::Zero(n * static_cast<Eigen::Index>(steps.size()));
  Vector theta = candidate.effect->nominal();
  theta[column.parameter] += column.step;
  RunSetup changed = setup;
  apply_in(*candidate.effect, theta, column.part, changed.plant);
  for (size_t i = 0; i < steps.size(); ++i) {
    const Vector with = end_rates(changed, steps[i]), without = end_rates(setup, steps[i]);
    if (with.size() == 0 || without.size() == 0) continue;
    out.segment(n * static_cast<Eigen::Index>(i), n) =
        steps[i].whitener * (with - without) * (problem.hypotheses.parameters[index].scale / column.step);
  }
  return out;
}

}  // namespace

ForceAnswer force_residual(const DiagnosisProblem& problem, const ConditionRows& rows,
                           const std::vector<DepartureChannel>& means, const PlantForward& forward, const Vector& p,
                           std::uint64_t seed) {
  ForceAnswer answer;
  const PlanarModel& model = rows.condition->model;
  if (!all_measured(model, means)) return answer;
  // Effects that p already has would be set twice: the force residual is about the nominal model.
  for (const Candidate& candidate : problem.hypotheses.candidates)
    if (Vector(p(candidate.parameters)) != candidate.effect->nominal()) return answer;
  const RunSetup setup = forward.setup(rows.index, 0, p);
  const std::vector<Step> steps = measured_steps(setup, means, rows.condition->window_end);
  if (steps.size() < 3) return answer;
  answer.residual = residual_of(model, steps);
  Signatures s = plan_columns(problem.hypotheses);
  const Eigen::Index n = model.size();
  Vector missing(n * static_cast<Eigen::Index>(steps.size()));
  double effective = 0.0;
  for (size_t i = 0; i < steps.size(); ++i) {
    missing.segment(n * static_cast<Eigen::Index>(i), n) = steps[i].whitener * steps[i].missing;
    effective += static_cast<double>(n);
  }
  Matrix S = Matrix::Zero(missing.size(), s.total);
  for (size_t k = 0; k < s.columns.size(); ++k)
    if (problem.hypotheses.candidates[static_cast<size_t>(s.columns[k].candidate)].effect->applies(model))
      S.col(static_cast<Eigen::Index>(k)) = column_of(problem, setup, steps, s.columns[k]);
  sum_parts(s, S);
  s.system = ShareSystem(s.total);
  s.system.add(S, missing, Matrix(S.rows(), 0), Vector(0), effective);
  ShareOptions sharing;
  sharing.seed = seed;
  answer.components = component_shares(s.system, s.candidates, sharing).components;
  return answer;
}

}  // namespace jaculus
