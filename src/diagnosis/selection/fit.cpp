#include "diagnosis/selection/fit.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>

#include "diagnosis/forward/sensitivities.h"
#include "diagnosis/noise/random_weights.h"

namespace jaculus::diagnosis {
namespace {

// Of a departure from nominal, tried for a lower valley: less by 4, 8, 15 and 25 %, and the inverse
// of these, cut to two digits. Chosen, not tuned.
constexpr double kAround[] = {0.75, 0.85, 0.92, 0.96, 1.04, 1.08, 1.17, 1.33};

/// log Phi(x) of the standard normal, also far in its lower tail.
double log_normal_cdf(double x) {
  if (x > -8.0) return std::log(0.5 * std::erfc(-x / std::numbers::sqrt2));
  return -0.5 * x * x - std::log(-x) - 0.5 * std::log(2.0 * std::numbers::pi);
}

/// log of the probability that a normal of this mean and deviation has within a range, also where
/// that is far in a tail.
double log_normal_mass(const Bounds& range, double mean, double deviation) {
  double low = (range.lower - mean) / deviation, high = (range.upper - mean) / deviation;
  if (low > 0.0)
    std::swap(low = -low, high = -high);  // by the lower tail, where logarithms are exact
  const double above = log_normal_cdf(low), all = log_normal_cdf(high);
  return std::isinf(low) ? all : all + std::log1p(-std::exp(above - all));
}

/// The residual as a function of u, with differences; counts the simulations.
class Residual {
 public:
  Residual(const Problem& problem, const Whitening& whitening, std::vector<int> free, Vector fixed)
      : problem_(problem),
        whitening_(whitening),
        free_(std::move(free)),
        fixed_(std::move(fixed)),
        steps_(Vector::Constant(count_of(free_), problem.settings.first_step)) {}

  [[nodiscard]] Bounds range(Eigen::Index i) const {
    const FreeParameter& p = problem_.hypotheses.parameters[free_[i]];
    return {(p.bounds.lower - p.nominal) / p.scale, (p.bounds.upper - p.nominal) / p.scale};
  }
  [[nodiscard]] Vector full(const Vector& u) const {
    return problem_.hypotheses.unscaled(free_, u, fixed_);
  }
  [[nodiscard]] Vector reduced(const Vector& p) const {
    return problem_.hypotheses.scaled(free_, p);
  }

  /// False where the simulation fails. What was asked for last is kept: a minimiser and the rounds
  /// about it ask for the same point again.
  bool value(const Vector& u, Vector& r) {
    if (u.size() == at_.size() && u == at_ && residual_.size() > 0) {
      r = residual_;
      return true;
    }
    ++predictions_;
    const PredictionSet set = predict_all(problem_, full(u));
    if (!set.valid) {
      message_ = set.message;
      return false;
    }
    rows_ = rows_of(problem_, whitening_.alignments, set);
    r = whitening_.residual(rows_);
    at_ = u;
    residual_ = r;
    jacobian_.resize(0, 0);
    return true;
  }

  /// dr/du at the point of the last `value`.
  bool jacobian(const Vector& u, Matrix& J) {
    if (jacobian_.cols() == u.size() && u.size() > 0) {
      J = jacobian_;
      return true;
    }
    const Vector p = full(u);
    J.resize(whitening_.rows, u.size());
    for (Eigen::Index i = 0; i < u.size(); ++i) {
      const double scale = problem_.hypotheses.parameters[free_[i]].scale;
      ++predictions_;
      const auto moved =
          difference(problem_, whitening_.alignments, p, rows_, free_[i], steps_[i] * scale);
      if (!moved) return false;
      J.col(i) = whitening_.apply(moved->rows) * (-scale / moved->step);
      steps_[i] = difference_step(J.col(i).norm(), problem_.settings);
    }
    jacobian_ = J;
    return true;
  }

  [[nodiscard]] long predictions() const { return predictions_; }
  [[nodiscard]] const std::string& message() const { return message_; }
  [[nodiscard]] const std::vector<Vector>& predicted() const { return rows_; }
  [[nodiscard]] int rows() const { return whitening_.rows; }
  [[nodiscard]] Eigen::Index size() const { return count_of(free_); }

 private:
  const Problem& problem_;
  const Whitening& whitening_;
  std::vector<int> free_;
  Vector fixed_, steps_;
  std::vector<Vector> rows_;
  Vector at_, residual_;  ///< of the last `value`
  Matrix jacobian_;       ///< there; empty: not asked for
  long predictions_ = 0;
  std::string message_;
};

/// Ceres' view: the residual's root by V^-1 (noise/random_weights.h) and prior rows below it.
class Cost : public ceres::CostFunction {
 public:
  Cost(Residual& residual, const RandomWeights& weights) : residual_(residual), weights_(weights) {
    set_num_residuals(residual.rows() + static_cast<int>(weights.more_rows()) + count_of(residual));
    mutable_parameter_block_sizes()->push_back(count_of(residual));
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Vector u = Eigen::Map<const Vector>(parameters[0], residual_.size());
    Vector r;
    if (!residual_.value(u, r)) return false;
    const Vector root = weights_.stacked(r);
    Eigen::Map<Vector>(residuals, root.size()) = root;
    Eigen::Map<Vector>(residuals + root.size(), u.size()) = u;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Matrix J;
    if (!residual_.jacobian(u, J)) return false;
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> all(
        jacobians[0], root.size() + u.size(), u.size());
    all.topRows(root.size()) = weights_.stacked(J);
    all.bottomRows(u.size()).setIdentity();
    return true;
  }

 private:
  Residual& residual_;
  const RandomWeights& weights_;
};

/// Minimises from u; false where no point could be evaluated.
bool minimise(Residual& residual, const RandomWeights& weights, int iterations,
              const Settings& settings, Vector& u) {
  FLAGS_minloglevel =
      google::GLOG_FATAL;  // a simulation that fails is a status here, no message of a library
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  Cost cost(residual, weights);
  ceres::Problem problem(ownership);
  problem.AddResidualBlock(&cost, nullptr, u.data());
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    const Bounds range = residual.range(i);
    if (std::isfinite(range.lower))
      problem.SetParameterLowerBound(u.data(), static_cast<int>(i), range.lower);
    if (std::isfinite(range.upper))
      problem.SetParameterUpperBound(u.data(), static_cast<int>(i), range.upper);
  }

  ceres::Solver::Options options;
  options.max_num_iterations = iterations;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = settings.fit_cost_tolerance;
  options.parameter_tolerance = settings.fit_parameter_tolerance;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  return summary.IsSolutionUsable();
}

/// By how much bounds change the evidence of a Gaussian posterior: the posterior's mass within
/// them, less the prior's.
double log_within_bounds(const Residual& residual, const LinearEvidence& linear) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < linear.mean.size(); ++i) {
    const Bounds range = residual.range(i);
    sum += log_normal_mass(range, linear.mean[i], std::sqrt(linear.covariance(i, i)));
    sum -= log_normal_mass(range, 0.0, 1.0);
  }
  return sum;
}

/// Evidence at the optimum by the fit's deviations, and without forces; r, J, p are there.
/// `beside`: the random effects beside the columns by which costs are told.
void complete(const Problem& problem, const RandomEffects& random, const RandomEffects& beside,
              const Residual& residual, const ScaleEstimate& estimate, Fit& fit) {
  fit.scales = estimate.scales;
  const Matrix model = linear_model(problem, fit);
  const Products products = products_of(random, model);
  const LinearEvidence linear = linear_evidence(random, products, fit.scales);
  const LinearEvidence without = linear_evidence(random, products, Vector::Zero(random.size()));
  fit.chi2 = fit.residual.squaredNorm();
  fit.log_evidence = linear.log_evidence + estimate.log_cost + log_within_bounds(residual, linear);
  fit.log_complete = without.log_evidence + log_within_bounds(residual, without);

  fit.covariance = linear_evidence(beside, products_of(beside, model), fit.scales).covariance;
  const Vector marginal = linear.covariance.diagonal(), own = fit.covariance.diagonal();
  fit.shared = (marginal - own).cwiseMax(0.0).cwiseSqrt();
  const Vector u = problem.hypotheses.scaled(fit.free, fit.p);
  const Products alone = products_of(beside, fit.residual);
  fit.cost = 0.5 * (weigh(beside, alone, fit.scales).gram(0, 0) + u.squaredNorm());
}

Vector scales_of(const FitOptions& options, const RandomEffects& random) {
  return options.scales.size() == random.size() ? options.scales : first_scales(random);
}

/// Minimises and estimates the deviations in turn, from u on. First without any force, as plain
/// least squares: forces that are granted at once may take what a parameter has to explain.
Fit fit_from(const Problem& problem, const Whitening& whitening, const std::vector<int>& free,
             const FitOptions& options, Residual& residual, Vector u) {
  const Settings& settings = problem.settings;
  const RandomEffects& random = whitening.random;
  const int first_iterations = options.iterations.value_or(settings.fit_iterations);
  Fit fit;
  fit.free = free;
  fit.scales = options.hold_scales || options.with_forces ? scales_of(options, random)
                                                          : Vector(Vector::Zero(random.size()));

  RandomEffects beside = fit.scales.isZero() && !options.hold_scales
                             ? without_tolerances(random)
                             : beside_columns(random, options.beside);
  for (int round = 0;; ++round) {
    // Later rounds set out from where the one before arrived.
    const int iterations = round == 0 || !in_windows(problem)
                               ? first_iterations
                               : std::min(first_iterations, settings.profile_iterations);
    fit.valid = (free.empty() ||
                 minimise(residual, RandomWeights(beside, fit.scales), iterations, settings, u)) &&
                residual.value(u, fit.residual) && residual.jacobian(u, fit.jacobian);
    if (!fit.valid) return fit;

    fit.p = residual.full(u);
    fit.rows = residual.predicted();
    const Products products = products_of(random, linear_model(problem, fit));
    const double before = linear_evidence(random, products, fit.scales).log_evidence;
    const bool first = round == 0 && !options.hold_scales && !options.with_forces;
    const ScaleEstimate estimate =
        estimated_scales(random, products, first ? scales_of(options, random) : fit.scales,
                         options.hold_scales ? 0 : settings.scale_steps, settings.scale_spread);
    if (options.beside.size() == 0) beside = beside_columns(random, fit.jacobian);
    complete(problem, random, beside, residual, estimate, fit);

    const double gained = linear_evidence(random, products, fit.scales).log_evidence - before;
    const bool settled = free.empty() || gained < settings.scales_settled;
    if (settled || options.hold_scales || round == options.rounds.value_or(settings.scale_rounds))
      return fit;
  }
}

/// Starts in the order of their misfit there, by the deviations to begin with; those that can't be
/// simulated last.
std::vector<Vector> best_first(const Problem& problem, const Whitening& whitening,
                               const std::vector<int>& free, const std::vector<Vector>& starts,
                               const FitOptions& options) {
  if (starts.size() < 2 || !in_windows(problem)) return starts;
  const Vector scales = scales_of(options, whitening.random);
  std::vector<std::pair<double, int>> order;
  for (int i = 0; i < count_of(starts); ++i) {
    Residual residual(problem, whitening, free, starts[i]);
    const Vector u = residual.reduced(starts[i]);
    Vector r;
    double cost = kInfinity;
    if (residual.value(u, r)) {
      const Products products = products_of(whitening.random, r);
      cost = 0.5 * (weigh(whitening.random, products, scales).gram(0, 0) + u.squaredNorm());
    }
    order.emplace_back(cost, i);
  }

  std::sort(order.begin(), order.end());
  std::vector<Vector> sorted;
  for (const auto& [cost, i] : order) sorted.push_back(starts[i]);
  return sorted;
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

Fit evaluate_model(const Problem& problem, const Whitening& whitening, const Vector& p,
                   const FitOptions& options) {
  Residual residual(problem, whitening, {}, p);
  Fit fit = fit_from(problem, whitening, {}, options, residual, Vector());
  if (!fit.valid) fit.p = p;
  fit.message = residual.message();
  fit.predictions = 1;
  return fit;
}

Fit fit_model(const Problem& problem, const Whitening& whitening, const std::vector<int>& free,
              const std::vector<Vector>& starts, const FitOptions& options) {
  if (free.empty()) return evaluate_model(problem, whitening, starts.front(), options);
  Fit best;

  long predictions = starts.size() > 1 ? count_of(starts) : 0;
  for (const Vector& start : best_first(problem, whitening, free, starts, options)) {
    Residual residual(problem, whitening, free, start);
    const Fit fit = fit_from(problem, whitening, free, options, residual, residual.reduced(start));
    predictions += residual.predictions();
    if (fit.valid && (!best.valid || fit.log_evidence > best.log_evidence)) best = fit;
    if (!best.valid) best.message = residual.message();
    if (best.valid && best.log_evidence >= options.enough) break;
  }

  best.predictions = predictions;
  return best;
}

Fit fit_around(const Problem& problem, const Whitening& whitening, Fit fit,
               const FitOptions& options) {
  if (!fit.valid || fit.free.empty()) return fit;
  const int first = fit.free.front();
  const FreeParameter& own = problem.hypotheses.parameters[first];
  const RandomEffects beside = beside_columns(whitening.random, fit.jacobian);
  const RandomWeights weights(beside, fit.scales);
  Vector best;
  double least = fit.cost - problem.settings.lower_valley;
  for (const double factor : kAround) {
    Vector p = fit.p;
    p[first] = std::clamp(own.nominal + factor * (fit.p[first] - own.nominal), own.bounds.lower,
                          own.bounds.upper);
    if (p[first] == fit.p[first]) continue;
    Residual residual(problem, whitening, {}, p);
    Vector r;
    ++fit.predictions;
    if (!residual.value({}, r)) continue;
    const double cost = 0.5 * (weights.stacked(r).squaredNorm() +
                               problem.hypotheses.scaled(fit.free, p).squaredNorm());
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

}  // namespace jaculus::diagnosis
