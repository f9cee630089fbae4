#include "diagnosis/validation/fit_to_others.h"

#include <algorithm>
#include <utility>

namespace jaculus::diagnosis {
namespace {

/// The problem with the predictions `there` for datasets of which no segment takes part: nothing is
/// fitted to them, so that they need no simulation.
Problem with_left_out(const Problem& problem, const SegmentMask& mask, PredictionSet there) {
  std::vector<bool> taken;
  for (const std::vector<bool>& own : mask)
    taken.push_back(std::find(own.begin(), own.end(), true) != own.end());

  Problem rest = problem;
  rest.forward = [&problem, taken, there = std::move(there)](int d, int s, const Vector& p) {
    return taken[d] ? problem.forward(d, s, p) : there.simulations[d][s];
  };
  return rest;
}

/// Slopes and misfits to set out with. Under a logged input slopes are differenced at the start.
FitOptions known_slopes(const Problem& problem, const Whitening& all, const Whitening& others,
                        const Fit& fit) {
  FitOptions options;
  if (in_windows(problem)) return options;
  const std::vector<int> nuisances = problem.hypotheses.nuisances();
  const Eigen::Index effects = std::count_if(fit.free.begin(), fit.free.end(),
                                             [&](int i) { return index_of(nuisances, i) < 0; });
  const Matrix slopes = fit.jacobian(rows_of_part(all, others), Eigen::all);
  options.scales = fit.scales;
  options.effect_slopes = slopes.leftCols(effects);
  options.known = slopes.rightCols(slopes.cols() - effects);
  return options;
}

}  // namespace

std::optional<Vector> fit_to_others(const Problem& problem, const Whitening& all,
                                    const Whitening& others, const SegmentMask& mask,
                                    const Fit& fit) {
  Vector start = fit.p;
  for (const int i : problem.hypotheses.nuisances())
    if (index_of(fit.free, i) >= 0) start[i] = problem.hypotheses.parameters[i].nominal;
  PredictionSet there = predict_all(problem, start);
  if (!there.valid) {
    start = fit.p;
    there = predict_all(problem, start);
  }
  if (!there.valid) return {};

  const Problem rest = with_left_out(problem, mask, std::move(there));
  Fit fitted = fit_model(rest, others, fit.free, {start}, known_slopes(problem, all, others, fit));
  if (!fitted.valid) return {};
  return std::move(fitted.p);
}

}  // namespace jaculus::diagnosis
