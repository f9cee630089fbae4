#include "diagnosis/verdict/lacking_forces.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/noise/force_bands.h"

namespace jaculus::diagnosis {
namespace {

/// Rows of the groups at some deviations. Bands of one force add up by their squares.
std::vector<LackingForce> rows_of(const Problem& problem, const RandomEffects& random,
                                  const Vector& scales, const Vector& told) {
  std::vector<LackingForce> forces;
  for (int g = 0; g < random.size(); ++g) {
    const RandomGroup& group = random.groups[g];
    if (told[g] < problem.settings.force_told) continue;
    LackingForce own{group.name, scales[g], "noise floors", told[g]};
    if (group.force >= 0) {
      const int box = problem.hypotheses.forces[group.force].boxes.front();
      own.rms = force_of_band(problem.hypotheses, group, scales[g]);
      own.unit = problem.hypotheses.parameters[box].unit;
    }
    const auto same = std::find_if(forces.begin(), forces.end(),
                                   [&](const LackingForce& f) { return f.name == own.name; });
    if (same == forces.end()) {
      forces.push_back(own);
      continue;
    }
    same->rms = std::hypot(same->rms, own.rms);
    same->boxes += own.boxes;
  }
  return forces;
}

/// The forces of all datasets, each with its own over boxes, a group a coordinate.
RandomEffects forces_under_plan(const Problem& problem, const Whitening& whitening,
                                const Fit& fit) {
  const RandomColumns columns =
      random_columns(problem, whitening.alignments, fit.simulated, fit.rows);
  RandomEffects random;
  for (int g = 0; g < count_of(problem.hypotheses.forces); ++g)
    random.groups.push_back(
        {problem.hypotheses.forces[g].name, g, 1.0, -1, problem.settings.largest_force});

  int first = 0;
  for (std::size_t d = 0; d < whitening.datasets.size(); ++d) {
    const DatasetWhitening& own = whitening.datasets[d];
    RandomBlock block{
        first, own.rows, Matrix(own.rows, columns.forces[d].cols()), columns.group, {}};
    for (Eigen::Index k = 0; k < block.columns.cols(); ++k)
      block.columns.col(k) = own.apply(columns.forces[d].col(k));
    block.gram = block.columns.transpose() * block.columns;
    random.blocks.push_back(std::move(block));
    first += own.rows;
  }
  return random;
}

}  // namespace

std::vector<LackingForce> lacking_forces(const Problem& problem, const Whitening& whitening,
                                         const Fit& fit) {
  const RandomEffects& random = whitening.random;
  if (random.size() == 0) return {};
  const Vector told = told_by(random, products_of(random, linear_model(problem, fit)), fit.scales);
  std::vector<LackingForce> found = rows_of(problem, random, fit.scales, told);
  if (!random.blocks.empty() || found.empty()) return found;

  const RandomEffects forces = forces_under_plan(problem, whitening, fit);
  const Products products = products_of(forces, fit.residual);
  const ScaleEstimate estimate =
      estimated_scales(forces, products, first_scales(forces), problem.settings.scale_steps,
                       problem.settings.scale_spread);
  std::vector<LackingForce> along =
      rows_of(problem, forces, estimate.scales, told_by(forces, products, estimate.scales));
  found.insert(found.begin(), along.begin(), along.end());
  return found;
}

}  // namespace jaculus::diagnosis
