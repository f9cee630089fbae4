#include "jaculus/diagnosis/fit.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>

namespace jaculus {
namespace {

constexpr double kFirstStep = 0.01;  // in u, of differences until the sensitivity is known
constexpr double kLeastStep = 1e-3, kMostStep = 0.05;
constexpr double kQuantile = 1.959964;             // of the normal, 95 % two-sided
constexpr double kCurvatureTolerance = 1.0 / 3.0;  // of the cost's rise over the interval's half
constexpr double kAround[] = {0.75, 0.85, 0.92, 0.96,
                              1.04, 1.08, 1.17, 1.33};  // of a departure from nominal, tried for a lower valley
constexpr double kWorthwhile = 0.5;                     // of the cost, by which one must be lower
constexpr double kFailed = 1e100;                       // cost where the simulation fails

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

/// log Phi(x) of the standard normal, also far in its lower tail.
double log_normal_cdf(double x) {
  if (x > -8.0) return std::log(0.5 * std::erfc(-x / std::numbers::sqrt2));
  return -0.5 * x * x - std::log(-x) - 0.5 * std::log(2.0 * std::numbers::pi);
}

/// log of the probability that a normal of this mean and deviation has within a range, also where that is far in a tail.
double log_normal_mass(const Bounds& range, double mean, double deviation) {
  double low = (range.lower - mean) / deviation, high = (range.upper - mean) / deviation;
  if (low > 0.0) std::swap(low = -low, high = -high);  // by the lower tail, where logarithms are exact
  const double above = log_normal_cdf(low), all = log_normal_cdf(high);
  return std::isinf(low) ? all : all + std::log1p(-std::exp(above - all));
}

/// The residual as a function of u, with differences.
class Residual {
 public:
  Residual(const DiagnosisProblem& problem, const EvidenceSpace& space, std::vector<int> free, Vector fixed)
      : problem_(problem), space_(space), free_(std::move(free)), fixed_(std::move(fixed)) {
    steps_ = Vector::Constant(static_cast<Eigen::Index>(free_.size()), kFirstStep);
  }

  [[nodiscard]] const FreeParameter& parameter(Eigen::Index i) const {
    return problem_.hypotheses.parameters[static_cast<std::size_t>(free_[at(i)])];
  }
  [[nodiscard]] Bounds range(Eigen::Index i) const {
    const FreeParameter& p = parameter(i);
    return {(p.bounds.lower - p.nominal) / p.scale, (p.bounds.upper - p.nominal) / p.scale};
  }
  [[nodiscard]] Vector full(const Vector& u) const { return problem_.hypotheses.unscaled(free_, u, fixed_); }
  [[nodiscard]] Vector reduced(const Vector& p) const { return problem_.hypotheses.scaled(free_, p); }
  bool value(const Vector& u, Vector& r) {
    ++predictions_;
    const PredictionSet set = predict_all(problem_, full(u));
    if (!set.valid) {
      message_ = set.message;
      return false;
    }
    r = space_.residual(rows_of(problem_, set));
    return true;
  }
  bool jacobian(const Vector& u, const Vector& r, Matrix& J) {
    J.resize(r.size(), u.size());
    for (Eigen::Index i = 0; i < u.size(); ++i) {
      double step = steps_[i];
      if (u[i] + step > range(i).upper) step = -step;
      Vector moved = u, there;
      moved[i] += step;
      if (!value(moved, there)) {
        moved[i] = u[i] - step;
        step = -step;
        if (!range(i).contains(moved[i]) || !value(moved, there)) return false;
      }
      J.col(i) = (there - r) / step;
      steps_[i] = difference_step(J.col(i).norm());
    }
    return true;
  }
  [[nodiscard]] long predictions() const { return predictions_; }
  [[nodiscard]] const std::string& message() const { return message_; }
  [[nodiscard]] int rows() const { return space_.rows; }
  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(free_.size()); }

 private:
  const DiagnosisProblem& problem_;
  const EvidenceSpace& space_;
  std::vector<int> free_;
  Vector fixed_, steps_;
  long predictions_ = 0;
  std::string message_;
};

/// Ceres' view: residual and prior rows below it.
class Cost : public ceres::CostFunction {
 public:
  explicit Cost(Residual& residual) : residual_(residual) {
    set_num_residuals(residual.rows() + static_cast<int>(residual.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(residual.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Vector u = Eigen::Map<const Vector>(parameters[0], residual_.size());
    Vector r;
    if (!residual_.value(u, r)) return false;
    Eigen::Map<Vector>(residuals, r.size()) = r;
    Eigen::Map<Vector>(residuals + r.size(), u.size()) = u;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Matrix J;
    if (!residual_.jacobian(u, r, J)) return false;
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> all(
        jacobians[0], r.size() + u.size(), u.size());
    all.topRows(r.size()) = J;
    all.bottomRows(u.size()).setIdentity();
    return true;
  }

 private:
  Residual& residual_;
};

/// Minimises from u; false where no point could be evaluated.
bool minimise(Residual& residual, int iterations, Vector& u) {
  FLAGS_minloglevel = google::GLOG_FATAL;  // a simulation that fails is a status here, no message of a library
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  Cost cost(residual);
  ceres::Problem problem(ownership);
  problem.AddResidualBlock(&cost, nullptr, u.data());
  for (Eigen::Index i = 0; i < u.size(); ++i) {
    const Bounds range = residual.range(i);
    if (std::isfinite(range.lower)) problem.SetParameterLowerBound(u.data(), static_cast<int>(i), range.lower);
    if (std::isfinite(range.upper)) problem.SetParameterUpperBound(u.data(), static_cast<int>(i), range.upper);
  }
  ceres::Solver::Options options;
  options.max_num_iterations = iterations;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = 1e-5;
  options.parameter_tolerance = 1e-6;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary.IsSolutionUsable();
}

/// Curvature and evidence at the optimum; r, J are there.
void complete(const Residual& residual, const Vector& u, Fit& fit) {
  const Eigen::Index d = u.size();
  fit.chi2 = fit.residual.squaredNorm();
  fit.cost = 0.5 * fit.chi2 + 0.5 * u.squaredNorm();
  fit.log_evidence = -fit.cost;
  if (d == 0) return;
  const Matrix H = fit.jacobian.transpose() * fit.jacobian + Matrix::Identity(d, d);
  const Vector g = fit.jacobian.transpose() * fit.residual + u;
  const Eigen::LLT<Matrix> llt(H);
  fit.covariance = llt.solve(Matrix::Identity(d, d));
  const Vector towards = fit.covariance * g;
  fit.log_evidence += 0.5 * g.dot(towards) - llt.matrixLLT().diagonal().array().log().sum();
  for (Eigen::Index i = 0; i < d; ++i) {
    const Bounds range = residual.range(i);
    fit.log_evidence += log_normal_mass(range, u[i] - towards[i], std::sqrt(fit.covariance(i, i)));
    fit.log_evidence -= log_normal_mass(range, 0.0, 1.0);
  }
}

/// Cost at u_i = value with the others refitted; kFailed where it can't be had.
double profile(const DiagnosisProblem& problem, const EvidenceSpace& space, const Fit& fit, int parameter,
               double p_value) {
  std::vector<int> others;
  for (const int i : fit.free)
    if (i != parameter) others.push_back(i);
  Vector p = fit.p;
  p[parameter] = p_value;
  const Fit there = others.empty() ? evaluate_model(problem, space, p) : fit_model(problem, space, others, {p}, {4});
  const FreeParameter& own = problem.hypotheses.parameters[static_cast<std::size_t>(parameter)];
  const double u = (p_value - own.nominal) / own.scale;
  return there.valid ? there.cost + 0.5 * u * u : kFailed;
}

/// End of the interval on one side.
double interval_end(const DiagnosisProblem& problem, const EvidenceSpace& space, const Fit& fit, int parameter,
                    double deviation, double side) {
  const FreeParameter& own = problem.hypotheses.parameters[static_cast<std::size_t>(parameter)];
  const double from = fit.p[parameter], rise = 0.5 * kQuantile * kQuantile;
  const double end = std::clamp(from + side * kQuantile * deviation, own.bounds.lower, own.bounds.upper);
  if (end == from) return end;
  const double share = (end - from) / (side * kQuantile * deviation);
  const double risen = profile(problem, space, fit, parameter, end) - fit.cost;
  const double expected = rise * share * share;
  if (std::abs(risen - expected) < kCurvatureTolerance * rise) return end;
  double inside = from, outside = end;
  for (int i = 0; i < 6 && profile(problem, space, fit, parameter, outside) - fit.cost < rise; ++i) {
    inside = outside;
    outside = std::clamp(from + 2.0 * (outside - from), own.bounds.lower, own.bounds.upper);
    if (outside == inside) return outside;
  }
  for (int i = 0; i < 7; ++i) {
    const double middle = 0.5 * (inside + outside);
    (profile(problem, space, fit, parameter, middle) - fit.cost < rise ? inside : outside) = middle;
  }
  return 0.5 * (inside + outside);
}

}  // namespace

double difference_step(double sensitivity) { return std::clamp(0.5 / (1.0 + sensitivity), kLeastStep, kMostStep); }

Fit evaluate_model(const DiagnosisProblem& problem, const EvidenceSpace& space, const Vector& p) {
  Fit fit;
  fit.p = p;
  Residual residual(problem, space, {}, p);
  fit.jacobian.resize(space.rows, 0);
  fit.valid = residual.value(Vector(), fit.residual);
  fit.message = residual.message();
  fit.predictions = 1;
  if (fit.valid) complete(residual, Vector(), fit);
  return fit;
}

Fit fit_model(const DiagnosisProblem& problem, const EvidenceSpace& space, const std::vector<int>& free,
              const std::vector<Vector>& starts, const FitOptions& options) {
  if (free.empty()) return evaluate_model(problem, space, starts.front());
  Fit best;
  long predictions = 0;
  for (const Vector& start : starts) {
    Residual residual(problem, space, free, start);
    Vector u = residual.reduced(start);
    Fit fit;
    fit.free = free;
    fit.valid = minimise(residual, options.iterations, u) && residual.value(u, fit.residual) &&
                residual.jacobian(u, fit.residual, fit.jacobian);
    predictions += residual.predictions();
    if (!fit.valid) {
      if (!best.valid) best.message = residual.message();
      continue;
    }
    fit.p = residual.full(u);
    complete(residual, u, fit);
    if (!best.valid || fit.cost < best.cost) best = fit;
    if (best.log_evidence >= options.enough) break;
  }
  best.predictions = predictions;
  return best;
}

Fit fit_around(const DiagnosisProblem& problem, const EvidenceSpace& space, Fit fit, const FitOptions& options) {
  if (!fit.valid || fit.free.empty()) return fit;
  const int first = fit.free.front();
  const FreeParameter& own = problem.hypotheses.parameters[static_cast<std::size_t>(first)];
  Vector best;
  double least = fit.cost - kWorthwhile;
  for (const double factor : kAround) {
    Vector p = fit.p;
    p[first] = std::clamp(own.nominal + factor * (fit.p[first] - own.nominal), own.bounds.lower, own.bounds.upper);
    if (p[first] == fit.p[first]) continue;
    const Fit there = evaluate_model(problem, space, p);
    ++fit.predictions;
    if (!there.valid) continue;
    const double cost = there.cost + 0.5 * problem.hypotheses.scaled(fit.free, p).squaredNorm();
    if (cost >= least) continue;
    least = cost;
    best = p;
  }
  if (best.size() == 0) return fit;
  Fit next = fit_model(problem, space, fit.free, {best}, options);
  next.predictions += fit.predictions;
  fit.predictions = next.predictions;
  return next.valid && next.cost < fit.cost ? next : fit;
}

Bounds interval95(const DiagnosisProblem& problem, const EvidenceSpace& space, const Fit& fit, int parameter) {
  const auto place = std::find(fit.free.begin(), fit.free.end(), parameter) - fit.free.begin();
  const FreeParameter& own = problem.hypotheses.parameters[static_cast<std::size_t>(parameter)];
  const double deviation = own.scale * std::sqrt(fit.covariance(place, place));
  return {interval_end(problem, space, fit, parameter, deviation, -1.0),
          interval_end(problem, space, fit, parameter, deviation, 1.0)};
}

}  // namespace jaculus
