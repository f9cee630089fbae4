#include "diagnosis/selection/linear_sets.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

#include "diagnosis/selection/foremost_sets.h"
#include "diagnosis/selection/line_search.h"
#include "diagnosis/selection/set_products.h"

namespace jaculus::diagnosis {
namespace {

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
    if (!on_its_side(problem, c, set.mean[k])) return false;
    k += count_of(problem.hypotheses.candidates[c].parameters);
  }
  return true;
}

/// All parameters at u of the members, then of the nuisances, within bounds.
Vector parameters_at(const Problem& problem, const Fit& fit, const std::vector<int>& about,
                     const SetProducts& table, const std::vector<int>& members, const Vector& u) {
  std::vector<int> free = problem.hypotheses.parameters_of(members);
  for (const Eigen::Index column : table.nuisances)
    free.push_back(fit.free[static_cast<std::size_t>(column - 1)]);
  return problem.hypotheses.unscaled(free, u, problem.hypotheses.without_effects(fit.p, about));
}

LinearSet evaluated(const Problem& problem, const Whitening& whitening, const Fit& fit,
                    const std::vector<int>& about, const SetProducts& table,
                    const std::vector<int>& members) {
  LinearSet set{members, -kInfinity, {}, {}, {}};
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
  const ScaleEstimate followed = followed_by(problem, whitening.random, products, fit.scales,
                                             problem.settings.set_scale_steps);
  set.mean = followed.mean.head(parameters);
  set.p = parameters_at(problem, fit, about, table, members, followed.mean);
  set.scales = followed.scales;
  if (on_their_sides(problem, set)) set.log_evidence = followed.evidence();
  return set;
}

}  // namespace

std::vector<LinearSet> linear_sets(const Problem& problem, const Whitening& whitening,
                                   const Fit& fit, const std::vector<int>& about,
                                   const std::vector<Probe>& probes,
                                   std::vector<std::vector<int>> sets) {
  const SetProducts table = set_products(problem, whitening, fit, about, probes);
  sets = foremost_sets(problem, whitening.random, fit.scales, table, std::move(sets));
  std::vector<LinearSet> out(sets.size());
  tbb::parallel_for(0, count_of(sets), [&](int i) {
    out[i] = evaluated(problem, whitening, fit, about, table, sets[i]);
  });

  std::erase_if(out, [](const LinearSet& set) { return set.log_evidence == -kInfinity; });
  std::stable_sort(out.begin(), out.end(), [](const LinearSet& a, const LinearSet& b) {
    return a.log_evidence > b.log_evidence;
  });
  return out;
}

}  // namespace jaculus::diagnosis
