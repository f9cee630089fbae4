#include "diagnosis/selection/known_slopes.h"

#include "diagnosis/selection/box_step.h"

namespace jaculus::diagnosis {
namespace {

/// The Gauss-Newton step within the parameters' bounds.
Vector step_within(const Problem& problem, const std::vector<int>& free, const Vector& u,
                   const Matrix& curvature, const Vector& gradient) {
  Vector lower(u.size()), upper(u.size());
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    const Bounds room = room_within(problem.hypotheses.parameters[free[i]].scaled_bounds(), u[i]);
    lower[i] = room.lower;
    upper[i] = room.upper;
  }
  return box_step(curvature, gradient, lower, upper);
}

/// H = W^T W + I of weighed slopes W = M J.
Matrix curvature_of(const Matrix& root) {
  Matrix curvature = root.transpose() * root;
  curvature.diagonal().array() += 1.0;
  return curvature;
}

}  // namespace

NearFit fit_by_known_slopes(const Problem& problem, const Whitening& space,
                            const RandomWeights& weights, const std::vector<int>& free,
                            const Matrix& slopes, Vector p, int steps) {
  const Matrix root = weights.stacked(slopes);
  const Matrix curvature = curvature_of(root);

  NearFit best;
  for (int step = 0;; ++step) {
    const PredictionSet there = predict_all(problem, p);
    if (!there.valid) return best;
    std::vector<Vector> rows = rows_of(problem, space.alignments, there);
    const Vector u = problem.hypotheses.scaled(free, p);
    const Matrix r = weights.stacked(space.residual(rows));
    const double cost = 0.5 * (r.squaredNorm() + u.squaredNorm());
    if (best.valid && cost >= best.cost) return best;

    best = {true, p, std::move(rows), cost};
    if (step == steps || free.empty()) return best;
    const Vector gradient = root.transpose() * r + u;
    p = problem.hypotheses.unscaled(free, u + step_within(problem, free, u, curvature, gradient),
                                    p);
  }
}

Vector optimum_without(const Problem& problem, const Whitening& whitening, const Fit& fit,
                       const std::vector<int>& members) {
  const Hypotheses& hypotheses = problem.hypotheses;
  const std::vector<int> dropped = hypotheses.parameters_of(members);
  std::vector<int> effects, others, free;
  for (int k = 0; k < count_of(fit.free); ++k) {
    const bool drops = index_of(dropped, fit.free[k]) >= 0;
    (drops ? effects : others).push_back(k);
    if (!drops) free.push_back(fit.free[k]);
  }

  const RandomWeights weights(whitening.random, fit.scales);
  const Matrix root = weights.stacked(fit.jacobian);
  const Matrix H = curvature_of(root);
  const Vector u = hypotheses.scaled(fit.free, fit.p);
  const Vector gradient = root.transpose() * weights.stacked(fit.residual) + u;
  const Vector d = step_within(problem, free, u(others), H(others, others),
                               gradient(others) - H(others, effects) * u(effects));
  return hypotheses.unscaled(free, u(others) + d, hypotheses.without_effects(fit.p, members));
}

}  // namespace jaculus::diagnosis
