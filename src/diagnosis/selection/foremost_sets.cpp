#include "diagnosis/selection/foremost_sets.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "diagnosis/selection/posterior.h"

namespace jaculus::diagnosis {
namespace {

/// Products of [r0 Y] of all candidates with the nuisances at their best for them.
struct AtBest {
  Matrix gram;                  ///< S
  std::vector<Matrix> misfits;  ///< M_c
  Matrix rest;                  ///< of rows of no misfit, weighed by forces, and |n|^2
  double log_det = 0.0;         ///< of V by forces
};

/// Deviations with those of forces times a factor.
Vector with_forces(const RandomEffects& random, Vector scales, double factor) {
  for (int g = 0; g < random.size(); ++g)
    if (random.groups[g].force >= 0) scales[g] *= factor;
  return scales;
}

AtBest at_best(const RandomEffects& random, const Vector& scales, const SetProducts& table) {
  const SetColumns& nuisances = table.nuisances;
  SetColumns others;
  for (Eigen::Index i = 0; i < table.products.gram.cols(); ++i)
    if (std::find(nuisances.begin(), nuisances.end(), i) == nuisances.end()) others.push_back(i);

  const Weighed all = weigh(random, table.products, scales);
  const Matrix& gram = all.gram;
  Matrix A = gram(nuisances, nuisances);
  A.diagonal().array() += 1.0;
  const Matrix K = A.llt().solve(Matrix(gram(nuisances, others)));
  Matrix put_in = Matrix::Zero(gram.cols(), gram.cols());
  for (const Eigen::Index i : others) put_in(i, i) = 1.0;
  put_in(nuisances, others) = -K;

  const auto best = [&](const Matrix& products) {
    return Matrix(put_in.transpose() * products * put_in);
  };
  AtBest out;
  Weighed by_forces =
      random.misfits.empty() ? all : weigh(random, table.products, without_misfits(random, scales));
  out.log_det = by_forces.log_det;
  Matrix& rest = by_forces.gram;
  for (const Matrix& own : table.products.misfits) {
    out.misfits.push_back(best(own));
    rest -= own;
  }
  Matrix prior = Matrix::Zero(gram.cols(), gram.cols());
  prior(others, others) = K.transpose() * K;
  out.gram = best(gram) + prior;
  out.rest = best(rest) + prior;
  return out;
}

/// -2 log density of an energy at its most likely misfit, up to a constant.
double squares_of(const RandomGroup& group, const Misfit& misfit, double energy) {
  if (misfit.rows <= 0.0) return energy;
  const double s = misfit.likely(energy, group);
  return energy / misfit.variance(s) + misfit.log_det(s);
}

/// What a set is worth, but for its prior; -infinity where a member has no columns, or would have
/// to work the wrong way.
double worth(const Problem& problem, const RandomEffects& random, const SetProducts& table,
             const AtBest& all, const std::vector<int>& members) {
  SetColumns columns{0}, firsts;
  for (const int c : members) {
    if (table.own[c].empty()) return -kInfinity;
    firsts.push_back(static_cast<Eigen::Index>(columns.size()));
    columns.insert(columns.end(), table.own[c].begin(), table.own[c].end());
  }
  const auto n = static_cast<Eigen::Index>(columns.size()) - 1;
  const Matrix S = all.gram(columns, columns);
  Matrix A = S.bottomRightCorner(n, n);
  A.diagonal().array() += 1.0;
  const Eigen::LLT<Matrix> factor(A);
  if (factor.info() != Eigen::Success) return -kInfinity;
  Vector w(1 + n);
  w << 1.0, -factor.solve(S.col(0).tail(n));
  for (std::size_t k = 0; k < members.size(); ++k)
    if (!on_its_side(problem, members[k], -w[firsts[k]])) return -kInfinity;

  double squares = all.log_det + w.tail(n).squaredNorm() + w.dot(all.rest(columns, columns) * w) +
                   2.0 * factor.matrixLLT().diagonal().array().log().sum();
  for (std::size_t c = 0; c < random.misfits.size(); ++c) {
    const double energy = w.dot(all.misfits[c](columns, columns) * w);
    squares += squares_of(random.groups[random.misfits[c].group], random.misfits[c], energy);
  }
  return std::isfinite(squares) ? -0.5 * squares : -kInfinity;
}

}  // namespace

std::vector<std::vector<int>> foremost_sets(const Problem& problem, const RandomEffects& random,
                                            const Vector& scales, const SetProducts& table,
                                            std::vector<std::vector<int>> sets) {
  const int kept = problem.settings.sets_followed;
  if (count_of(sets) <= kept) return sets;

  const Settings& settings = problem.settings;
  std::vector<double> left = {1.0};
  if (!random.blocks.empty())
    left.insert(left.end(), {settings.forces_left, settings.least_forces_left});
  std::vector<AtBest> all;
  for (const double share : left)
    all.push_back(at_best(random, with_forces(random, scales, share), table));
  std::vector<double> worths(sets.size(), -kInfinity);
  tbb::parallel_for(0, count_of(sets), [&](int i) {
    for (const AtBest& own : all)
      worths[i] = std::max(worths[i], worth(problem, random, table, own, sets[i]));
    worths[i] += log_prior(sets[i].size(), table.own.size(), problem.settings);
  });
  std::vector<int> order(sets.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return worths[a] > worths[b]; });

  std::map<std::size_t, int> counts;  // by size
  std::erase_if(order, [&](int i) { return ++counts[sets[i].size()] > kept; });
  std::sort(order.begin(), order.end());
  std::vector<std::vector<int>> foremost;
  for (const int i : order) foremost.push_back(std::move(sets[i]));
  return foremost;
}

}  // namespace jaculus::diagnosis
