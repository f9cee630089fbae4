#include "diagnosis/selection/known_slopes.h"

#include <Eigen/Cholesky>

namespace jaculus::diagnosis {
namespace {

/// The Gauss-Newton step of the parameters that are not held at an end of their range.
Vector step_within(const Problem& problem, const std::vector<int>& free, const Vector& u,
                   const Matrix& curvature, const Vector& gradient) {
  std::vector<Eigen::Index> moving;
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    const FreeParameter& own = problem.hypotheses.parameters[free[i]];
    const double value = own.nominal + own.scale * u[i];
    const bool held = (value <= own.bounds.lower && gradient[i] > 0.0) ||
                      (value >= own.bounds.upper && gradient[i] < 0.0);
    if (!held) moving.push_back(i);
  }
  Vector step = Vector::Zero(u.size());
  if (!moving.empty())
    step(moving) = -Matrix(curvature(moving, moving)).llt().solve(Vector(gradient(moving)));
  return step;
}

}  // namespace

NearFit fit_by_known_slopes(const Problem& problem, const Whitening& space,
                            const RandomWeights& weights, const std::vector<int>& free,
                            const Matrix& slopes, Vector p, int steps) {
  const Matrix root = weights.stacked(slopes);
  Matrix curvature = root.transpose() * root;
  curvature.diagonal().array() += 1.0;

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

}  // namespace jaculus::diagnosis
