#include "diagnosis/motion_patterns.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "diagnosis/build_problem.h"
#include "diagnosis/forward/sensitivities.h"
#include "diagnosis/remainder/place_patterns.h"
#include "diagnosis/selection/residual.h"
#include "diagnosis/validation/fold_interval.h"
#include "diagnosis/validation/folds.h"
#include "diagnosis/validation/shapley.h"
#include "jaculus/effects/user_effect.h"

namespace jaculus::diagnosis {
namespace {

/// Patterns with the problem in which they are candidates.
struct PatternProblem {
  std::vector<PlacePattern> patterns;
  BuiltProblem built;
  Comparison comparison;
  Vector p;                  ///< as stated
  std::vector<Vector> rows;  ///< predicted there, a dataset each
};

UsualMotion usual_motion(const Problem& problem, const PlantForward& forward, const Vector& p) {
  const model::PlanarModel& robot = problem.observations.datasets.front().model;
  UsualMotion usual{Vector::Zero(robot.size()), Vector::Zero(robot.size()),
                    Vector::Zero(robot.size())};
  const SimulationSetup setup = forward.setup(0, 0, p);
  const simulation::Simulation run =
      simulate(setup.plant, setup.controller, setup.start, setup.options);
  usual.start = setup.start.q;
  if (run.time.size() == 0 || !run.v.allFinite()) return usual;
  usual.speed = (run.v.rowwise().squaredNorm() / static_cast<double>(run.v.cols())).cwiseSqrt();
  usual.range = run.q.rowwise().maxCoeff() - run.q.rowwise().minCoeff();
  return usual;
}

std::vector<double> scales_of(const PlacePattern& pattern) {
  std::vector<double> scales;
  for (const PatternParameter& own : pattern.parameters) scales.push_back(own.scale);
  return scales;
}

/// The named effects and the patterns, as candidates.
std::vector<effects::Effect> effects_and_patterns(const Diagnosis& found,
                                                  const std::vector<PlacePattern>& patterns) {
  std::vector<effects::Effect> all;
  if (names_effects(found.verdict))
    for (const int c : found.model.candidates)
      if (const effects::Effect* named = found.problem->hypotheses.candidates[c].effect)
        all.push_back(*named);
  for (const PlacePattern& pattern : patterns)
    all.push_back(
        effects::parse_user_effect(pattern_file(pattern, scales_of(pattern), false), pattern.name)
            .effect);
  return all;
}

/// Nothing where the stated model can't be simulated.
std::optional<PatternProblem> pattern_problem(const std::vector<trajectory::Dataset>& datasets,
                                              const DiagnoseOptions& options,
                                              const Diagnosis& found) {
  const Settings& settings = options.settings;
  const BuiltProblem plain = build_problem(datasets, options);
  if (!plain.forward) return {};
  const Vector as_stated = stated_parameters(found, plain.problem->hypotheses);
  PatternProblem out;
  out.patterns = place_patterns(plain.problem->observations.datasets.front().model,
                                usual_motion(*plain.problem, *plain.forward, as_stated),
                                settings.pattern_prior, settings.lever, settings.rest_speed);

  const ProblemBuilder builder = builder_of(effects_and_patterns(found, out.patterns), settings);
  Prepared prepared = prepare(builder(plain.problem->observations), builder);
  if (!prepared.reasons.empty() || !prepared.noise.valid()) return {};
  out.built = std::move(prepared.built);
  const Problem& problem = *out.built.problem;
  out.p = stated_parameters(found, problem.hypotheses);
  NoiseModel noise = estimate_noise(problem, out.p, prepared.noise.alignments);
  if (!noise.valid()) return {};
  out.comparison = comparison_about(problem, with_random_effects(problem, std::move(noise)));
  out.rows = rows_of(problem, out.comparison.noise, out.comparison.noise.at_p);
  return out;
}

/// White columns of a pattern, one a parameter; none where it changes nothing or is lost.
Matrix pattern_columns(const PatternProblem& own, const Shrinkage& tolerances, int candidate) {
  const Problem& problem = *own.built.problem;
  const Whitening& whitening = own.comparison.whitening;
  const std::vector<int>& parameters = problem.hypotheses.candidates[candidate].parameters;
  Matrix columns(whitening.rows, count_of(parameters));
  for (int k = 0; k < count_of(parameters); ++k) {
    const double scale = problem.hypotheses.parameters[parameters[k]].scale;
    const auto moved = difference(problem, whitening.alignments, own.p, own.rows, parameters[k],
                                  problem.settings.pattern_step * scale);
    if (!moved) return {};
    Vector white = whitening.apply(moved->rows) * (scale / moved->step);
    tolerances.apply(white);
    columns.col(k) = white;
  }
  return columns.squaredNorm() > 1.0 ? columns : Matrix();
}

/// The linear problem of the patterns.
struct LinearPatterns {
  Vector residual;
  std::vector<Matrix> columns;  ///< a pattern each; empty where it can't act
  int tried = 0;
};

LinearPatterns linear_patterns(const PatternProblem& own) {
  const Problem& problem = *own.built.problem;
  const Whitening& whitening = own.comparison.whitening;
  const Shrinkage tolerances = shrinkage(linear_nuisances(problem, whitening, own.p).slopes);
  LinearPatterns out;
  out.residual = whitening.residual(own.rows);
  tolerances.apply(out.residual);
  out.columns.resize(own.patterns.size());
  tbb::parallel_for(0, count_of(own.patterns), [&](int k) {
    const int c = problem.hypotheses.candidate(own.patterns[k].name);
    if (c >= 0) out.columns[k] = pattern_columns(own, tolerances, c);
  });
  for (const Matrix& columns : out.columns) out.tried += columns.cols() > 0 ? 1 : 0;
  return out;
}

Matrix columns_of(const LinearPatterns& linear, const std::vector<int>& members) {
  Matrix all(linear.residual.size(), 0);
  for (const int k : members) {
    const Eigen::Index before = all.cols();
    all.conservativeResize(all.rows(), before + linear.columns[k].cols());
    all.rightCols(linear.columns[k].cols()) = linear.columns[k];
  }
  return all;
}

double log_evidence(const PatternProblem& own, const LinearPatterns& linear,
                    const std::vector<int>& members) {
  const RandomEffects& random = own.comparison.whitening.random;
  const Settings& settings = own.built.problem->settings;
  const Matrix Y = columns_of(linear, members);
  Matrix X(linear.residual.size(), 1 + Y.cols());
  X << linear.residual, Y;
  const Products products = products_of(random, X);
  const ScaleEstimate estimate = estimated_scales(random, products, first_scales(random),
                                                  settings.scale_steps, settings.scale_spread);
  return linear_evidence(random, products, estimate.scales).log_evidence + estimate.log_cost;
}

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

/// A member as a place says it, with the file that a diagnosis may judge.
Dependence dependence_of(const PlacePattern& pattern, const Vector& found) {
  Dependence own;
  own.regressor = pattern.regressor;
  own.period = pattern.period;
  own.unit = pattern.period_unit;
  double size = 0.0;
  for (Eigen::Index k = 0; k < found.size(); ++k) size = std::max(size, std::abs(found[k]));
  std::vector<double> scales;
  for (std::size_t k = 0; k < pattern.parameters.size(); ++k) {
    const double scale = pattern.parameters[k].scale;
    own.coefficients.push_back(found[static_cast<Eigen::Index>(k)] * scale);
    scales.push_back(std::max(size, 1e-9) * scale);
  }
  own.hypothesis = pattern_file(pattern, scales, true);
  return own;
}

void add_to_places(const PlacePattern& pattern, Dependence dependence,
                   std::vector<RemainderPlace>& places) {
  const auto same = std::find_if(places.begin(), places.end(), [&](const RemainderPlace& place) {
    return place.joint == pattern.at && place.place == pattern.place;
  });
  RemainderPlace fresh;
  fresh.joint = pattern.at;
  fresh.place = pattern.place;
  fresh.by_simulation = true;
  RemainderPlace& own = same == places.end() ? places.emplace_back(std::move(fresh)) : *same;
  own.follows.push_back(std::move(dependence));
}

}  // namespace

Vector stated_parameters(const Diagnosis& found, const Hypotheses& hypotheses) {
  const Vector& stated = names_effects(found.verdict) ? found.model.p : found.none.p;
  const std::vector<FreeParameter>& known = found.problem->hypotheses.parameters;
  Vector p = hypotheses.nominal();
  for (int i = 0; i < count_of(hypotheses.parameters); ++i) {
    const FreeParameter& own = hypotheses.parameters[i];
    for (int k = 0; k < count_of(known); ++k)
      if (own.owner != "force" && known[k].owner == own.owner && known[k].name == own.name)
        p[i] = stated[k];
  }
  return p;
}

std::vector<RemainderPlace> patterns_of_motion(const std::vector<trajectory::Dataset>& datasets,
                                               const DiagnoseOptions& options,
                                               const Diagnosis& found) {
  if (found.problem == nullptr || in_windows(*found.problem)) return {};
  const std::optional<PatternProblem> own = pattern_problem(datasets, options, found);
  if (!own || own->comparison.whitening.random.size() == 0) return {};
  const LinearPatterns linear = linear_patterns(*own);
  const Settings& settings = options.settings;
  const double mean_square =
      linear.residual.squaredNorm() / static_cast<double>(linear.residual.size());
  if (most_left(own->comparison.whitening, linear.residual) < settings.plain_gap) return {};
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
    Dependence dependence = dependence_of(own->patterns[members[m]], b.segment(next, width));
    next += width;
    dependence.share = shares.value[m];
    dependence.ci95 = shares.ci95[m];
    dependence.selected = 1.0;
    if (dependence.ci95.lower > 0.0 && dependence.share >= settings.least_followed)
      add_to_places(own->patterns[members[m]], std::move(dependence), places);
  }
  return places;
}

}  // namespace jaculus::diagnosis
