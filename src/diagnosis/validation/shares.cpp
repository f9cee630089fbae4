#include "diagnosis/validation/shares.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "diagnosis/validation/fold_interval.h"
#include "diagnosis/validation/shapley.h"

namespace jaculus::diagnosis {
namespace {

constexpr int kMostOrdered = 3;  // subsets double with each member

/// v, of all folds together and by fold; NaN where it can't be told.
struct Explained {
  double all = kNaN;
  std::vector<double> by_fold;
};

double explained(double before, double after) { return 1.0 - energy_left(before, after); }

Explained explained_by(const HeldOut& gap, const Settings& settings) {
  Explained out;
  out.by_fold.assign(gap.by_fold.size(), kNaN);
  if (!gap.valid || gap.before < settings.plain_gap) return out;

  out.all = explained(gap.before, gap.after);
  for (std::size_t f = 0; f < gap.by_fold.size(); ++f) {
    const FoldGap& fold = gap.by_fold[f];
    if (fold.before > settings.gap_of_fold) out.by_fold[f] = explained(fold.before, fold.after);
  }
  return out;
}

/// v of all subsets that are needed, by bits of the members' places.
using Subsets = std::map<unsigned, Explained>;

/// Shapley value of member i by one number of each subset.
template <class Value>
double shapley(const Subsets& v, int n, int i, Value&& value) {
  std::vector<double> worth;
  for (unsigned set = 0; set < 1u << n; ++set) worth.push_back(value(v.at(set)));
  return shapley_values(worth, n)[i];
}

EffectShare share_of(const Subsets& v, int n, int i) {
  const unsigned all = (1u << n) - 1u, own = 1u << i;
  EffectShare share;
  share.tolerances = v.at(0).all;
  share.alone = v.at(own).all - share.tolerances;
  share.last = v.at(all).all - v.at(all & ~own).all;
  if (n > kMostOrdered) return share;

  share.shapley = shapley(v, n, i, [](const Explained& e) { return e.all; });
  std::vector<double> by_fold;
  for (std::size_t f = 0; f < v.at(all).by_fold.size(); ++f)
    by_fold.push_back(shapley(v, n, i, [f](const Explained& e) { return e.by_fold[f]; }));
  share.ci95 = fold_interval(by_fold, share.shapley);
  return share;
}

}  // namespace

std::vector<std::optional<EffectShare>> shares_of(HeldOutGaps& gaps, const ModelFit& model) {
  const int n = count_of(model.candidates);
  std::vector<std::optional<EffectShare>> shares(model.candidates.size());
  const HeldOut whole = gaps.of(model);
  if (!whole.valid || whole.before < gaps.settings().plain_gap) return shares;

  Subsets v;
  for (unsigned set = 0; set < 1u << n; ++set) {
    const int size = std::popcount(set);
    if (n > kMostOrdered && size > 1 && size < n - 1) continue;
    std::vector<int> members;
    for (int i = 0; i < n; ++i)
      if ((set >> i & 1u) != 0) members.push_back(model.candidates[i]);
    const ModelFit& fitted = gaps.subset(model, members);
    v[set] = {kNaN, std::vector<double>(whole.by_fold.size(), kNaN)};
    if (fitted.fit.valid) v[set] = explained_by(gaps.of(fitted), gaps.settings());
  }

  for (int i = 0; i < n; ++i) {
    const EffectShare share = share_of(v, n, i);
    if (std::isfinite(share.alone) && std::isfinite(share.last)) shares[i] = share;
  }
  return shares;
}

}  // namespace jaculus::diagnosis
