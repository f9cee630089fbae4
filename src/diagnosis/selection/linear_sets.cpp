#include "diagnosis/selection/linear_sets.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "diagnosis/selection/line_search.h"

namespace jaculus::diagnosis {
namespace {

using SetColumns = std::vector<Eigen::Index>;

/// Products of the residual, the nuisances and every candidate's columns.
struct SetProducts {
  Products products;
  std::vector<SetColumns> own;  ///< of a candidate; empty where it has none
  SetColumns nuisances;
};

SetProducts set_products(const Problem& problem, const Whitening& whitening, const Fit& none,
                         const std::vector<Probe>& probes) {
  SetProducts table;
  const Matrix base = linear_model(problem, none);
  Eigen::Index count = base.cols();
  for (const Probe& probe : probes) count += probe.valid ? probe.better().cols() : 0;

  Matrix X(base.rows(), count);
  X.leftCols(base.cols()) = base;
  for (Eigen::Index i = 1; i < base.cols(); ++i) table.nuisances.push_back(i);
  Eigen::Index next = base.cols();
  for (const Probe& probe : probes) {
    table.own.emplace_back();
    if (!probe.valid) continue;
    const Matrix& columns = probe.better();
    X.middleCols(next, columns.cols()) = columns;
    for (Eigen::Index k = 0; k < columns.cols(); ++k) table.own.back().push_back(next++);
  }

  table.products = products_of(whitening.random, X);
  return table;
}

/// Those of some columns of X.
Products picked(const Products& all, const SetColumns& columns) {
  Products out{all.gram(columns, columns), {}, all.tolerances(Eigen::all, columns)};
  for (const Matrix& block : all.blocks) out.blocks.emplace_back(block(Eigen::all, columns));
  return out;
}

/// Whether the first parameter of every member lies within its bounds or beyond the far end.
bool on_their_sides(const Problem& problem, const Vector& p, const LinearSet& set) {
  Eigen::Index k = 0;
  for (const int c : set.members) {
    const Candidate& candidate = problem.hypotheses.candidates[c];
    const int first = candidate.parameters.front();
    const FreeParameter& own = problem.hypotheses.parameters[first];
    const double u = set.mean[k];
    if (own.one_sided() && (p[first] <= own.bounds.lower ? u <= 0.0 : u >= 0.0)) return false;
    k += count_of(candidate.parameters);
  }
  return true;
}

LinearSet evaluated(const Problem& problem, const Whitening& whitening, const Fit& none,
                    const SetProducts& table, const std::vector<int>& members) {
  LinearSet set{members, -kInfinity, {}};
  SetColumns columns{0};
  for (const int c : members) {
    if (table.own[c].empty()) return set;
    columns.insert(columns.end(), table.own[c].begin(), table.own[c].end());
  }
  const auto parameters = static_cast<Eigen::Index>(columns.size()) - 1;
  columns.insert(columns.end(), table.nuisances.begin(), table.nuisances.end());

  const Products products = picked(table.products, columns);
  const RandomEffects& random = whitening.random;
  const ScaleEstimate scales =
      estimated_scales(random, products, none.scales, problem.settings.set_scale_steps,
                       problem.settings.scale_spread);
  const LinearEvidence linear = linear_evidence(random, products, scales.scales);
  set.mean = linear.mean.head(parameters);
  if (on_their_sides(problem, none.p, set))
    set.log_evidence = linear.log_evidence + scales.log_cost;
  return set;
}

}  // namespace

std::vector<LinearSet> linear_sets(const Problem& problem, const Whitening& whitening,
                                   const Fit& none, const std::vector<Probe>& probes,
                                   const std::vector<std::vector<int>>& sets) {
  const SetProducts table = set_products(problem, whitening, none, probes);
  std::vector<LinearSet> out(sets.size());
  tbb::parallel_for(0, count_of(sets),
                    [&](int i) { out[i] = evaluated(problem, whitening, none, table, sets[i]); });

  std::erase_if(out, [](const LinearSet& set) { return set.log_evidence == -kInfinity; });
  std::stable_sort(out.begin(), out.end(), [](const LinearSet& a, const LinearSet& b) {
    return a.log_evidence > b.log_evidence;
  });
  return out;
}

}  // namespace jaculus::diagnosis
