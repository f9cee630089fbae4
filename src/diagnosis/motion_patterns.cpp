#include "diagnosis/motion_patterns.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "diagnosis/pattern_scan.h"
#include "diagnosis/remainder/pattern_file.h"
#include "diagnosis/remainder/push_place.h"
#include "diagnosis/validation/fold_interval.h"
#include "diagnosis/validation/folds.h"
#include "diagnosis/validation/shapley.h"

namespace jaculus::diagnosis {
namespace {

/// The channel of which most is left, root mean square [noise floors].
double most_left(const Whitening& whitening, const Vector& white) {
  const Vector rows = whitening.in_rows(white);
  double most = 0.0;
  Eigen::Index first = 0;
  for (const DatasetWhitening& dataset : whitening.datasets) {
    std::map<int, Vec2> channels;  // squares, rows
    for (const RowSpan& span : dataset.spans) {
      channels.try_emplace(span.channel, Vec2::Zero()).first->second +=
          Vec2(rows.segment(first, span.count).squaredNorm(), span.count);
      first += span.count;
    }
    for (const auto& [channel, sums] : channels)
      most = std::max(most, std::sqrt(sums[0] / std::max(1.0, sums[1])));
  }
  return most;
}

std::vector<int> selected_patterns(const PatternProblem& own, const LinearPatterns& linear) {
  const Settings& settings = own.built.problem->settings;
  const double asked = settings.worth + std::log(std::max(1, linear.tried));
  std::vector<int> members;
  double reached = log_evidence(own, linear, members);
  while (count_of(members) < settings.most_followed) {
    std::vector<double> with(own.patterns.size(), -kInfinity);
    tbb::parallel_for(0, count_of(own.patterns), [&](int k) {
      if (linear.columns[k].cols() == 0 || index_of(members, k) >= 0) return;
      std::vector<int> joined = members;
      joined.push_back(k);
      with[k] = log_evidence(own, linear, joined);
    });
    const auto best = std::max_element(with.begin(), with.end());
    if (best == with.end() || *best - reached < asked) break;
    reached = *best;
    members.push_back(static_cast<int>(best - with.begin()));
  }
  return members;
}

/// Coefficients by least squares of some rows, at the prior's price in units of what is left.
Vector coefficients(const Matrix& Y, const Vector& r, const std::vector<int>& rows,
                    double mean_square) {
  const Matrix X = Y(rows, Eigen::all);
  Matrix A = X.transpose() * X;
  A.diagonal().array() += mean_square;
  return A.ldlt().solve(X.transpose() * r(rows));
}

/// White rows that a fold holds out, and the others.
struct FoldRows {
  std::vector<int> out, in;
};
FoldRows rows_of_fold(const Whitening& whitening, const SegmentMask& mask) {
  FoldRows rows;
  int first = 0;
  for (std::size_t d = 0; d < whitening.datasets.size(); ++d) {
    for (const SegmentBlock& block : whitening.datasets[d].blocks)
      for (int i = 0; i < block.count; ++i)
        (mask[d][block.segment] ? rows.in : rows.out).push_back(first + block.first + i);
    first += whitening.datasets[d].rows;
  }
  return rows;
}

struct PatternShares {
  Vector value;
  std::vector<Bounds> ci95;
};

/// Shares of the members on held-out folds; no values where nothing can be held out.
PatternShares shares_of(const PatternProblem& own, const LinearPatterns& linear,
                        const std::vector<int>& members) {
  const Problem& problem = *own.built.problem;
  const Folds folds = folds_of(problem.observations, problem.settings);
  const Vector& r = linear.residual;
  const double mean_square = r.squaredNorm() / static_cast<double>(r.size());
  const int n = count_of(members);
  std::vector<std::vector<double>> explained;  // folds x sets
  double total = 0.0;
  for (const SegmentMask& mask : folds.masks) {
    const FoldRows rows = rows_of_fold(own.comparison.whitening, mask);
    if (rows.out.empty() || rows.in.empty()) continue;
    const Vector out = r(rows.out);
    total += out.squaredNorm() - static_cast<double>(rows.out.size());
    explained.emplace_back();
    for (unsigned set = 0; set < 1u << n; ++set) {
      std::vector<int> some;
      for (int m = 0; m < n; ++m)
        if ((set >> m & 1u) != 0) some.push_back(members[m]);
      const Matrix Y = columns_of(linear, some);
      Vector left = out;
      if (!some.empty()) left -= Y(rows.out, Eigen::all) * coefficients(Y, r, rows.in, mean_square);
      explained.back().push_back(out.squaredNorm() - left.squaredNorm());
    }
  }
  if (explained.size() < 2 || !(total > 0.0)) return {};

  const auto folds_judged = static_cast<double>(explained.size());
  std::vector<double> sum(std::size_t{1} << n, 0.0);
  std::vector<Vector> by_fold;
  for (std::vector<double>& fold : explained) {
    for (std::size_t set = 0; set < fold.size(); ++set) {
      sum[set] += fold[set] / total;
      fold[set] *= folds_judged / total;
    }
    by_fold.push_back(shapley_values(fold, n));
  }
  PatternShares shares{shapley_values(sum, n), {}};
  for (int m = 0; m < n; ++m) {
    std::vector<double> each;
    for (const Vector& fold : by_fold) each.push_back(fold[m]);
    shares.ci95.push_back(fold_interval(each, shares.value[m]));
  }
  return shares;
}

/// A member as a place says it, with the file that a diagnosis may judge. Of a spring the
/// coefficient is the force's slope by the position, as of what is found box by box.
Dependence dependence_of(const PlacePattern& pattern, const Vector& found) {
  Dependence own;
  own.regressor = pattern.regressor;
  if (pattern.shape && pattern.shape->name == "period") {
    own.period = pattern.shape->value;
    own.unit = pattern.shape->unit;
  }
  own.form = pattern.form;
  double size = 0.0;
  for (Eigen::Index k = 0; k < found.size(); ++k) size = std::max(size, std::abs(found[k]));
  std::vector<double> scales;
  for (std::size_t k = 0; k < pattern.parameters.size(); ++k) {
    const double scale = pattern.parameters[k].scale;
    const double sign = pattern.regressor == Regressor::position ? -1.0 : 1.0;
    own.coefficients.push_back(sign * found[static_cast<Eigen::Index>(k)] * scale);
    scales.push_back(std::max(size, 1e-9) * scale);
  }
  own.hypothesis = pattern_file(pattern, scales, true);
  return own;
}

/// A place with what it follows, to what is known of the same place.
void add_to_places(RemainderPlace fresh, std::vector<RemainderPlace>& places) {
  const auto same = std::find_if(places.begin(), places.end(), [&](const RemainderPlace& own) {
    return own.joint == fresh.joint && own.place == fresh.place;
  });
  if (same == places.end()) {
    places.push_back(std::move(fresh));
    return;
  }
  if (same->unit.empty()) same->unit = fresh.unit;
  for (Dependence& own : fresh.follows) same->follows.push_back(std::move(own));
}

RemainderPlace place_with(const PlacePattern& pattern, Dependence dependence) {
  RemainderPlace place;
  place.joint = pattern.at;
  place.place = pattern.place;
  place.by_simulation = true;
  place.follows = {std::move(dependence)};
  return place;
}

/// Each one's part of all, patterns first: by what it explains, equal where that is not known.
Vector parts_of(const ToldForces& found) {
  std::vector<double> each;
  const auto add = [&](const FoundEffect& own) {
    each.push_back(own.share ? std::max(0.0, own.share->shapley) : kNaN);
  };
  for (const FoundEffect& pattern : found.patterns) add(pattern);
  for (const ToldPush& push : found.pushes) add(push.found);
  Vector parts = Eigen::Map<const Vector>(each.data(), std::ssize(each));
  if (!parts.allFinite() || !(parts.sum() > 0.0)) parts.setOnes();
  return parts / parts.sum();
}

/// What a diagnosis states.
KnownModel stated_model(const Diagnosis& found) {
  const FittedModel& model = names_effects(found.verdict) ? found.model : found.none;
  return {found.problem.get(), model.candidates, model.p};
}

}  // namespace

Vector stated_parameters(const Diagnosis& found, const Hypotheses& hypotheses) {
  return carried_over(stated_model(found), hypotheses);
}

TakenShare share_taken(const HeldOut& by_effects, const HeldOut& with_forces,
                       const Settings& settings) {
  const bool judged = by_effects.valid && with_forces.valid;
  if (!judged || !(by_effects.after > settings.gap_of_fold)) return {};
  std::vector<double> by_fold;
  for (std::size_t f = 0; f < by_effects.by_fold.size(); ++f) {
    const double before = by_effects.by_fold[f].after, after = with_forces.by_fold[f].after;
    if (before > settings.gap_of_fold) by_fold.push_back(1.0 - energy_left(before, after));
  }
  const double value = 1.0 - energy_left(by_effects.after, with_forces.after);
  return {value, fold_interval(by_fold, value)};
}

std::vector<RemainderPlace> places_of(const std::vector<PlacePattern>& candidates,
                                      const ToldForces& found, const TakenShare& taken) {
  const Vector parts = parts_of(found);
  const auto give = [&](Eigen::Index n, Dependence& own) {
    own.share = parts[n] * taken.value;
    own.ci95 = {parts[n] * taken.ci95.lower, parts[n] * taken.ci95.upper};
  };
  std::vector<RemainderPlace> places;
  for (int n = 0; n < count_of(found.patterns); ++n) {
    const FoundEffect& effect = found.patterns[n];
    const auto known =
        std::find_if(candidates.begin(), candidates.end(),
                     [&](const PlacePattern& own) { return own.name == effect.name; });
    if (known == candidates.end()) continue;
    const std::size_t shapes = known->shape ? 1 : 0;
    if (effect.parameters.size() < known->parameters.size() + shapes) continue;
    PlacePattern pattern = *known;
    Vector sizes(count_of(pattern.parameters));
    for (int k = 0; k < sizes.size(); ++k)
      sizes[k] = effect.parameters[k].value / pattern.parameters[k].scale;
    if (pattern.shape) pattern.shape->value = effect.parameters.back().value;
    Dependence own = dependence_of(pattern, sizes);
    own.selected = effect.probability;
    give(n, own);
    add_to_places(place_with(pattern, std::move(own)), places);
  }

  for (int n = 0; n < count_of(found.pushes); ++n) {
    RemainderPlace push = push_place(found.pushes[n].event, found.robot);
    give(count_of(found.patterns) + n, push.follows.front());
    add_to_places(std::move(push), places);
  }
  return places;
}

std::vector<RemainderPlace> patterns_of_motion(const Diagnosis& found) {
  if (found.problem == nullptr || in_windows(*found.problem)) return {};
  const std::optional<PatternProblem> own = pattern_problem(
      stated_model(found), found.noise ? found.noise->alignments : std::vector<Alignment>());
  if (!own || own->comparison.whitening.random.size() == 0) return {};
  LinearPatterns linear = without_patterns(*own);
  const Settings& settings = found.problem->settings;
  const double mean_square =
      linear.residual.squaredNorm() / static_cast<double>(linear.residual.size());
  if (most_left(own->comparison.whitening, linear.residual) < settings.plain_gap) return {};
  add_columns(*own, linear);
  const std::vector<int> members = selected_patterns(*own, linear);
  if (members.empty()) return {};
  const PatternShares shares = shares_of(*own, linear, members);
  if (shares.value.size() == 0) return {};

  std::vector<int> rows(static_cast<std::size_t>(linear.residual.size()));
  for (int i = 0; i < count_of(rows); ++i) rows[i] = i;
  const Vector b = coefficients(columns_of(linear, members), linear.residual, rows, mean_square);
  std::vector<RemainderPlace> places;
  Eigen::Index next = 0;
  for (int m = 0; m < count_of(members); ++m) {
    const Eigen::Index width = linear.columns[members[m]].cols();
    const PlacePattern& pattern = own->patterns[members[m]];
    Dependence dependence = dependence_of(pattern, b.segment(next, width));
    next += width;
    dependence.share = shares.value[m];
    dependence.ci95 = shares.ci95[m];
    dependence.selected = 1.0;
    if (dependence.ci95.lower > 0.0 && dependence.share >= settings.least_followed)
      add_to_places(place_with(pattern, std::move(dependence)), places);
  }
  return places;
}

}  // namespace jaculus::diagnosis
