#include "diagnosis/selection/set_products.h"

namespace jaculus::diagnosis {

SetProducts set_products(const Problem& problem, const Whitening& whitening, const Fit& fit,
                         const std::vector<int>& about, const std::vector<Probe>& probes) {
  SetProducts table;
  table.own.resize(probes.size());
  const Matrix base = linear_model(problem, fit);
  Eigen::Index count = base.cols();
  for (const Probe& probe : probes) count += probe.valid ? probe.better().cols() : 0;

  Matrix X(base.rows(), count);
  X.leftCols(base.cols()) = base;
  std::vector<bool> taken(base.cols(), false);
  for (const int c : about) {
    for (const int i : problem.hypotheses.candidates[c].parameters) {
      const Eigen::Index column = 1 + index_of(fit.free, i);
      table.own[c].push_back(column);
      taken[column] = true;
    }
  }
  for (Eigen::Index i = 1; i < base.cols(); ++i)
    if (!taken[i]) table.nuisances.push_back(i);

  Eigen::Index next = base.cols();
  for (int c = 0; c < count_of(probes); ++c) {
    if (!probes[c].valid || !table.own[c].empty()) continue;
    const Matrix& columns = probes[c].better();
    X.middleCols(next, columns.cols()) = columns;
    for (Eigen::Index k = 0; k < columns.cols(); ++k) table.own[c].push_back(next++);
  }

  table.products = products_of(whitening.random, X.leftCols(next));
  return table;
}

bool on_its_side(const Problem& problem, int candidate, double u) {
  const int first = problem.hypotheses.candidates[candidate].parameters.front();
  const FreeParameter& own = problem.hypotheses.parameters[first];
  if (!own.one_sided()) return true;
  return own.bounds.lower >= own.nominal ? u > 0.0 : u < 0.0;
}

}  // namespace jaculus::diagnosis
