#include "diagnosis/forward/tolerance_part.h"

#include <Eigen/QR>

namespace jaculus::diagnosis {
namespace {

using simulation::Plant;

/// Of a parameter's prior scale: what effects do to these quantities is linear or nearly so.
constexpr double kMove = 1e-3;
/// Of the largest pivot, below which parameters move no quantity of their own.
constexpr double kLeastPivot = 1e-6;

Vector quantities(const Plant& plant, const std::vector<ToleranceDirection>& directions) {
  std::vector<double> n;
  for (const ToleranceDirection& own : directions)
    for (const auto& read : own.reads) n.push_back(read(plant));
  return Eigen::Map<const Vector>(n.data(), count_of(n));
}

}  // namespace

Matrix tolerance_part(const Plant& nominal, const effects::Effect& effect, const Vector& theta,
                      const std::vector<ToleranceDirection>& directions) {
  Plant there = nominal;
  effect.apply(theta, there);
  const Vector at = quantities(there, directions);

  Vector steps(theta.size());
  Matrix G(at.size(), theta.size());
  for (int k = 0; k < theta.size(); ++k) {
    const effects::EffectParameter& p = effect.parameters[k];
    steps[k] = kMove * p.scale * (p.bounds.contains(theta[k] + kMove * p.scale) ? 1.0 : -1.0);
    Vector moved = theta;
    moved[k] += steps[k];
    Plant plant = nominal;
    effect.apply(moved, plant);
    G.col(k) = quantities(plant, directions) - at;
  }

  Matrix T = Matrix::Zero(at.size(), count_of(directions));
  for (int j = 0; j < count_of(directions); ++j) {
    if (directions[j].reads.empty()) continue;
    Plant plant = there;
    simulation::Controller controller;
    directions[j].move(1.0, plant, controller);
    T.col(j) = quantities(plant, directions) - at;
  }

  Eigen::CompleteOrthogonalDecomposition<Matrix> solver;
  solver.setThreshold(kLeastPivot);
  solver.compute(G);
  return steps.asDiagonal() * solver.solve(T);
}

}  // namespace jaculus::diagnosis
