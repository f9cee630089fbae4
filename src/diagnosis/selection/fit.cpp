#include "diagnosis/selection/fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnosis/noise/log_probability.h"
#include "diagnosis/selection/minimise.h"

namespace jaculus::diagnosis {
namespace {

// Of a departure from nominal, tried for a lower valley: less by 4, 8, 15 and 25 %, and the inverse
// of these, cut to two digits. Chosen, not tuned.
constexpr double kAround[] = {0.75, 0.85, 0.92, 0.96, 1.04, 1.08, 1.17, 1.33};

/// By how much bounds change the evidence of a Gaussian posterior: the posterior's mass within
/// them, less the prior's. Of what is at its most probable there is no mass.
double log_within_bounds(const Residual& residual, const LinearEvidence& linear,
                         const std::vector<Eigen::Index>& most_probable) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < linear.mean.size(); ++i) {
    if (std::find(most_probable.begin(), most_probable.end(), i) != most_probable.end()) continue;
    const double deviation = std::sqrt(linear.covariance(i, i));
    sum += log_mass_ratio(residual.range(i), linear.mean[i], deviation);
  }
  return sum;
}

/// Evidence at the optimum by the fit's deviations, and without forces; r, J, p are there.
/// `products`: of the fit's linear model. `at`: as linear_evidence() has it.
void complete(const RandomEffects& random, const Residual& residual, const Products& products,
              const ScaleEstimate& estimate, const Vector& u, const Vector* at, Fit& fit) {
  fit.scales = estimate.scales;
  const LinearEvidence linear = linear_evidence(random, products, fit.scales, at);
  const LinearEvidence without = linear_evidence(random, products, complete_scales(random), at);
  fit.chi2 = fit.residual.squaredNorm();
  const auto within = [&](const LinearEvidence& own) {
    return log_within_bounds(residual, own, products.shared);
  };
  fit.log_evidence = linear.log_evidence + estimate.log_cost + within(linear);
  fit.log_complete = without.log_evidence + within(without);

  // The residual is X [1; -u] of the linear model's columns X.
  fit.covariance = linear.covariance;
  Vector along(1 + fit.jacobian.cols());
  along << 1.0, -u;
  const Matrix gram = weigh(random, products, fit.scales).gram;
  fit.cost = 0.5 * (along.dot(gram * along) + along.tail(along.size() - 1).squaredNorm());
}

Vector scales_of(const FitOptions& options, const RandomEffects& random) {
  return options.scales.size() == random.size() ? options.scales : first_scales(random);
}

/// At most, of a round. Later ones set out from where the one before arrived.
int iterations_of(const Problem& problem, const FitOptions& options, int round) {
  const int first = options.iterations.value_or(problem.settings.fit_iterations);
  return round == 0 || !in_windows(problem) ? first
                                            : std::min(first, problem.settings.profile_iterations);
}

/// Whether a fit begins without any force.
bool without_forces(const FitOptions& options, const RandomEffects& random) {
  return !options.hold_scales && (!options.with_forces || random.blocks.empty());
}

/// Where a fit of the search, tolerances by their slopes, stays sooner than one that is stated.
double least_fall(const Residual& residual) {
  return residual.first_linear() < residual.size() ? residual.settings().search_settled : 0.0;
}

Misfits misfits_of(const FitOptions& options) {
  return options.hold_scales ? Misfits::held : Misfits::follow;
}

/// Minimises and estimates the deviations in turn, from u on: where least squares ended, the
/// deviations first. Where nothing but misfits is estimated and tolerances are simulated, it goes
/// on by slopes that are told anew until it stays: on the way those of nuisances go by secants, by
/// which a model with effects, whose own slopes are exact, comes closer to its optimum than the one
/// without.
Fit fit_from(const Problem& problem, const Whitening& whitening, const std::vector<int>& free,
             const FitOptions& options, Residual& residual, Vector u) {
  const Settings& settings = problem.settings;
  const RandomEffects& random = whitening.random;
  const bool squares = without_forces(options, random);
  const int steps = options.scale_steps.value_or(options.hold_scales ? 0 : settings.scale_steps);
  Fit fit;
  fit.free = free;
  fit.scales = squares ? Vector(Vector::Zero(random.size())) : scales_of(options, random);

  for (int round = 0;; ++round) {
    const Fit before_round = fit;
    std::optional<Minimised> moved = Minimised{kInfinity, false};
    if (!free.empty() && (round > 0 || !squares || !random.misfits.empty()))
      moved = minimise(residual, random, fit.scales, misfits_of(options),
                       {iterations_of(problem, options, round), least_fall(residual)}, u);
    if (!moved) return before_round;  // what stands; not valid in the first round
    const auto [fell, settled] = *moved;
    // Misfits have followed already.
    const bool stays =
        random.blocks.empty() && round > 0 && settled && fell < settings.scales_settled;
    fit.valid = residual.value(u, fit.residual);
    const Matrix* slopes = nullptr;
    if (fit.valid)
      slopes = stays || !options.renew ? residual.slopes(u) : residual.renewed_slopes(u);
    if (slopes == nullptr) return before_round;

    fit.jacobian = *slopes;
    fit.p = residual.full(u);
    if (options.keep_rows) fit.nuisance_rows = residual.nuisance_rows();
    fit.simulated = residual.simulated(u);
    fit.rows = residual.predicted();
    Products products = products_of(random, linear_model(problem, fit));
    products.shared = shared_columns(problem, random, fit);
    const Vector before = fit.scales;
    const Vector from = round == 0 && squares ? scales_of(options, random) : before;
    const Vector* at = random.blocks.empty() ? &u : nullptr;
    const ScaleEstimate estimate =
        estimated_scales(random, products, from, steps, settings.scale_spread, at);
    complete(random, residual, products, estimate, u, at, fit);

    if (free.empty() || round >= settings.renewals || !options.renew) return fit;
    if (options.hold_scales) {
      if (settled) return fit;
      continue;
    }
    if (random.blocks.empty()) {
      // By slopes one round does, unless the effects' own went by secants.
      const bool exact = options.by_slopes != nullptr && residual.first_followed() > 0;
      if (stays || (exact && settled)) return fit;
      continue;
    }
    if (round >= options.rounds.value_or(settings.scale_rounds)) return fit;
    const double gained =
        estimate.log_evidence - linear_evidence(random, products, before).log_evidence;
    // Given slopes may lead nowhere: what they reached counts once those told there stay as well.
    const bool by_given = round == 0 && options.effect_slopes.cols() > 0;
    if (gained + fell < settings.scales_settled && !by_given) return fit;
  }
}

Residual residual_of(const Problem& problem, const Whitening& whitening,
                     const std::vector<int>& free, const Vector& p, const FitOptions& options) {
  // White ones are those of the rows, where both are there.
  const bool by_rows = !options.known_rows.columns.empty() && options.known.cols() == 0;
  const Matrix known = by_rows ? whitening.slopes(options.known_rows) : options.known;
  Residual residual =
      options.by_slopes == nullptr
          ? Residual(problem, whitening, free, p, known, options.effect_slopes)
          : Residual(problem, whitening, free, p, *options.by_slopes, options.effect_slopes);
  // Where no slope is known at all the first ones are differenced together.
  if (options.effects_follow && options.by_slopes == nullptr && known.cols() == 0)
    residual.follow_effects();
  if (options.keep_rows) residual.keep_rows(options.known_rows);
  return residual;
}

/// Whether one of some points is next to another.
bool reached(const std::vector<Vector>& points, const Vector& u, const Settings& settings) {
  return std::any_of(points.begin(), points.end(), [&](const Vector& known) {
    return (known - u).cwiseAbs().maxCoeff() < settings.relinearised_within;
  });
}

/// The starts of the least cost, as the fit from there begins, least first; those that can't be
/// simulated last.
std::vector<Vector> best_first(const Problem& problem, const Whitening& whitening,
                               const std::vector<int>& free, const std::vector<Vector>& starts,
                               const FitOptions& options) {
  if (starts.size() < 2) return starts;
  const Vector scales = without_forces(options, whitening.random)
                            ? Vector(Vector::Zero(whitening.random.size()))
                            : scales_of(options, whitening.random);
  std::vector<std::pair<double, int>> order;
  for (int i = 0; i < count_of(starts); ++i) {
    Residual residual = residual_of(problem, whitening, free, starts[i], options);
    const Vector u = residual.reduced(starts[i]);
    Vector r;
    double cost = kInfinity;
    if (residual.value(u, r)) cost = cost_of(whitening.random, scales, misfits_of(options), r, u);
    order.emplace_back(cost, i);
  }

  std::sort(order.begin(), order.end());
  if (count_of(order) > problem.settings.starts_tried) order.resize(problem.settings.starts_tried);
  std::vector<Vector> sorted;
  for (const auto& [cost, i] : order) sorted.push_back(starts[i]);
  return sorted;
}

/// Where slopes that are known lead from some starts, the lowest and those nearly as low: a few
/// predictions each, where slopes told anew take one a nuisance. The starts themselves where none
/// can be simulated or no slopes are known.
std::vector<Vector> lowest_by_known(const Problem& problem, const Whitening& whitening,
                                    const std::vector<int>& free, const std::vector<Vector>& starts,
                                    const FitOptions& options, long& predictions) {
  if (starts.size() < 2 || options.known.cols() == 0 || !options.with_forces) return starts;
  const Vector scales = scales_of(options, whitening.random);
  std::vector<std::pair<double, Vector>> ends;
  std::vector<Vector> reduced;
  for (const Vector& start : starts) {
    Residual residual = residual_of(problem, whitening, free, start, options);
    Vector u = residual.reduced(start), r;
    const bool ended =
        minimise(residual, whitening.random, scales, misfits_of(options),
                 {iterations_of(problem, options, 0), problem.settings.search_settled}, u) &&
        residual.value(u, r);
    predictions += residual.predictions();
    if (!ended || reached(reduced, u, problem.settings)) continue;
    reduced.push_back(u);
    ends.emplace_back(cost_of(whitening.random, scales, misfits_of(options), r, u),
                      residual.full(u));
  }
  if (ends.empty()) return starts;
  std::sort(ends.begin(), ends.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Vector> lowest;
  for (const auto& [cost, p] : ends)
    if (cost <= ends.front().first + problem.settings.lower_valley) lowest.push_back(p);
  return lowest;
}

}  // namespace

Matrix linear_model(const Problem& problem, const Fit& fit) {
  Matrix X(fit.residual.size(), 1 + fit.jacobian.cols());
  X.rightCols(fit.jacobian.cols()) = -fit.jacobian;
  X.col(0) = fit.residual;
  if (fit.jacobian.cols() > 0)
    X.col(0) -= fit.jacobian * problem.hypotheses.scaled(fit.free, fit.p);
  return X;
}

std::vector<Eigen::Index> shared_columns(const Problem& problem, const RandomEffects& random,
                                         const Fit& fit) {
  std::vector<Eigen::Index> columns;
  if (!random.blocks.empty()) return columns;
  for (const int i : problem.hypotheses.nuisances())
    if (const int place = index_of(fit.free, i); place >= 0) columns.push_back(place);
  return columns;
}

bool lacks(const Problem& problem, const Fit& fit) {
  return fit.log_evidence - fit.log_complete >= problem.settings.remainder_left;
}

bool leaves_more(const Problem& problem, const Fit& fit) {
  if (lacks(problem, fit)) return true;
  if (in_windows(problem)) return false;
  double beyond = 0.0;
  for (const int i : problem.hypotheses.tolerances) {
    const int place = index_of(fit.free, i);
    if (place < 0) continue;
    const double t = fit.p[i] / problem.hypotheses.parameters[i].scale;
    beyond += t * t - (1.0 - fit.covariance(place, place));
  }
  return 0.5 * beyond >= problem.settings.remainder_left;
}

Fit evaluate_model(const Problem& problem, const Whitening& whitening, const Vector& p,
                   const FitOptions& options) {
  Residual residual(problem, whitening, {}, p);
  Fit fit = fit_from(problem, whitening, {}, options, residual, Vector());
  if (!fit.valid) fit.p = fit.simulated = p;
  fit.message = residual.message();
  fit.predictions = 1;
  return fit;
}

Fit fit_model(const Problem& problem, const Whitening& whitening, const std::vector<int>& free,
              const std::vector<Vector>& starts, const FitOptions& options) {
  if (free.empty()) return evaluate_model(problem, whitening, starts.front(), options);
  Fit best;

  long predictions = starts.size() > 1 ? count_of(starts) : 0;
  const Vector no_forces = Vector::Zero(whitening.random.size());
  std::vector<Vector> ends;  // of least squares
  const std::vector<Vector> first = best_first(problem, whitening, free, starts, options);
  for (const Vector& start :
       lowest_by_known(problem, whitening, free, first, options, predictions)) {
    Residual residual = residual_of(problem, whitening, free, start, options);
    Vector u = residual.reduced(start);
    Fit fit;
    if (!without_forces(options, whitening.random)) {
      fit = fit_from(problem, whitening, free, options, residual, u);
    } else if (minimise(residual, whitening.random, no_forces, Misfits::held,
                        {iterations_of(problem, options, 0), least_fall(residual)}, u) &&
               !reached(ends, u, problem.settings)) {
      // Forces that are granted at once may take what a parameter has to explain.
      ends.push_back(u);
      // Under a plan nothing but weights changes from here: secants do.
      if (options.by_slopes != nullptr && whitening.random.blocks.empty())
        residual.follow_effects();
      fit = fit_from(problem, whitening, free, options, residual, u);
    }
    predictions += residual.predictions();
    if (fit.valid && (!best.valid || fit.log_evidence > best.log_evidence)) best = fit;
    if (!best.valid) best.message = residual.message();
    if (best.valid && best.log_evidence >= options.enough) break;
  }

  best.predictions = predictions;
  return best;
}

Fit fit_near(const Problem& problem, const Whitening& whitening, const std::vector<int>& free,
             const Vector& start, const FitOptions& options) {
  if (free.empty()) return evaluate_model(problem, whitening, start, options);
  Residual residual = residual_of(problem, whitening, free, start, options);
  Fit fit = fit_from(problem, whitening, free, options, residual, residual.reduced(start));
  fit.message = residual.message();
  fit.predictions = residual.predictions();
  return fit;
}

Fit fit_from_lower(const Problem& problem, const Whitening& whitening, Fit fit,
                   const std::vector<Vector>& starts, const FitOptions& options) {
  if (!fit.valid || fit.free.empty()) return fit;
  const auto cost_at = [&](const Vector& p, const Vector& r) {
    return cost_of(whitening.random, fit.scales, misfits_of(options), r,
                   problem.hypotheses.scaled(fit.free, p));
  };
  Vector best;
  double least = cost_at(fit.p, fit.residual) - problem.settings.lower_valley;
  for (const Vector& p : starts) {
    if (p == fit.p) continue;
    Residual residual = residual_of(problem, whitening, fit.free, p, options);
    Vector r;
    ++fit.predictions;
    if (!residual.value(residual.reduced(p), r)) continue;
    const double cost = cost_at(p, r);
    if (cost >= least) continue;
    least = cost;
    best = p;
  }

  if (best.size() == 0) return fit;
  FitOptions from = options;
  from.scales = fit.scales;
  Fit next = fit_model(problem, whitening, fit.free, {best}, from);
  next.predictions += fit.predictions;
  fit.predictions = next.predictions;

  return next.valid && next.log_evidence > fit.log_evidence ? next : fit;
}

Fit fit_around(const Problem& problem, const Whitening& whitening, Fit fit,
               const FitOptions& options) {
  if (!fit.valid || fit.free.empty()) return fit;
  const int first = fit.free.front();
  const FreeParameter& own = problem.hypotheses.parameters[first];
  std::vector<Vector> starts;
  for (const double factor : kAround) {
    starts.push_back(fit.p);
    starts.back()[first] = std::clamp(own.nominal + factor * (fit.p[first] - own.nominal),
                                      own.bounds.lower, own.bounds.upper);
  }
  return fit_from_lower(problem, whitening, std::move(fit), starts, options);
}

}  // namespace jaculus::diagnosis
