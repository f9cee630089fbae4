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

/// Those of some columns of X.
Products picked(const Products& all, const SetColumns& columns) {
  Products out{all.gram(columns, columns), {}, {}};
  for (const Matrix& own : all.misfits) out.misfits.emplace_back(own(columns, columns));
  for (const Matrix& block : all.blocks) out.blocks.emplace_back(block(Eigen::all, columns));
  return out;
}

/// Whether the first parameter of every member stays on its side of nominal.
bool on_their_sides(const Problem& problem, const LinearSet& set) {
  Eigen::Index k = 0;
  for (const int c : set.members) {
    const Candidate& candidate = problem.hypotheses.candidates[c];
    const FreeParameter& own = problem.hypotheses.parameters[candidate.parameters.front()];
    const double u = set.mean[k];
    if (own.one_sided() && (own.bounds.lower >= own.nominal ? u <= 0.0 : u >= 0.0)) return false;
    k += count_of(candidate.parameters);
  }
  return true;
}

LinearSet evaluated(const Problem& problem, const Whitening& whitening, const Fit& fit,
                    const SetProducts& table, const std::vector<int>& members) {
  LinearSet set{members, -kInfinity, {}, {}};
  SetColumns columns{0};
  for (const int c : members) {
    if (table.own[c].empty()) return set;
    columns.insert(columns.end(), table.own[c].begin(), table.own[c].end());
  }
  const auto parameters = static_cast<Eigen::Index>(columns.size()) - 1;
  columns.insert(columns.end(), table.nuisances.begin(), table.nuisances.end());

  Products products = picked(table.products, columns);
  if (whitening.random.blocks.empty())
    for (std::size_t k = 0; k < table.nuisances.size(); ++k)
      products.shared.push_back(parameters + static_cast<Eigen::Index>(k));
  const Followed followed = followed_by(problem, whitening.random, products, fit.scales,
                                        problem.settings.set_scale_steps);
  set.mean = followed.linear.mean.head(parameters);
  set.scales = followed.scales;
  if (on_their_sides(problem, set)) set.log_evidence = followed.linear.log_evidence;
  return set;
}

}  // namespace

std::vector<LinearSet> linear_sets(const Problem& problem, const Whitening& whitening,
                                   const Fit& fit, const std::vector<int>& about,
                                   const std::vector<Probe>& probes,
                                   const std::vector<std::vector<int>>& sets) {
  const SetProducts table = set_products(problem, whitening, fit, about, probes);
  std::vector<LinearSet> out(sets.size());
  tbb::parallel_for(0, count_of(sets),
                    [&](int i) { out[i] = evaluated(problem, whitening, fit, table, sets[i]); });

  std::erase_if(out, [](const LinearSet& set) { return set.log_evidence == -kInfinity; });
  std::stable_sort(out.begin(), out.end(), [](const LinearSet& a, const LinearSet& b) {
    return a.log_evidence > b.log_evidence;
  });
  return out;
}

}  // namespace jaculus::diagnosis
