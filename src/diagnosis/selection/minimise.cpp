#include "diagnosis/selection/minimise.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace jaculus::diagnosis {
namespace {

/// W = M J of a residual's slopes on the way, and W^T W. Where slopes follow secants, J + d s^T
/// with s zero but for those that follow, so do both: W + w s^T with w = M d, and with v = W^T w
///   W^T W + v s^T + s v^T + w^T w s s^T,
/// passes over one column in place of all.
class WeighedSlopes {
 public:
  explicit WeighedSlopes(const RandomWeights& weights) : weights_(weights) {}

  void follow(const Residual& residual, const Matrix& J) {
    const Eigen::Index before = residual.before_nuisances(), n = J.cols() - before;
    const std::vector<Residual::Secant>& secants = residual.secants();
    if (W_.size() == 0 || renewed_ != residual.times_renewed()) {
      W_ = weights_.stacked(J);
      gram_ = Matrix::Zero(J.cols(), J.cols());
      gram_.selfadjointView<Eigen::Lower>().rankUpdate(W_.transpose());
      gram_.triangularView<Eigen::StrictlyUpper>() = gram_.transpose();
    } else {
      for (; followed_ < secants.size(); ++followed_) add(secants[followed_], before);
      if (before > 0) {
        W_.leftCols(before) = weights_.stacked(J.leftCols(before));
        gram_.leftCols(before) = W_.transpose() * W_.leftCols(before);
        gram_.topRightCorner(before, n) = gram_.bottomLeftCorner(n, before).transpose();
      }
    }
    renewed_ = residual.times_renewed();
    followed_ = secants.size();
  }

  [[nodiscard]] const Matrix& weighed() const { return W_; }
  [[nodiscard]] const Matrix& gram() const { return gram_; }

 private:
  /// Of the columns from the first nuisance's on; those before are made anew.
  void add(const Residual::Secant& secant, Eigen::Index before) {
    const Vector w = weights_.stacked(secant.missed);
    const Eigen::Index n = W_.cols() - before, moved = secant.along.size();
    const Vector v = W_.rightCols(n).transpose() * w;
    Vector s = Vector::Zero(n);
    s.head(moved) = secant.along;
    W_.middleCols(before, moved).noalias() += w * secant.along.transpose();
    auto nuisances = gram_.bottomRightCorner(n, n);
    nuisances += v * s.transpose() + s * v.transpose() + w.squaredNorm() * (s * s.transpose());
  }

  const RandomWeights& weights_;
  Matrix W_, gram_;
  int renewed_ = 0;
  std::size_t followed_ = 0;
};

/// Ceres' view.
class Cost : public ceres::CostFunction {
 public:
  Cost(Residual& residual, const RandomWeights& weights)
      : residual_(residual), weights_(weights), slopes_(weights) {
    set_num_residuals(static_cast<int>(residual.size()) + 1);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(residual.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Index n = residual_.size();
    const Vector u = Eigen::Map<const Vector>(parameters[0], n);
    Vector r;
    if (!residual_.value(u, r)) return false;
    const Vector root = weights_.stacked(r);
    const double squares = root.squaredNorm() + u.squaredNorm();
    Eigen::Map<Vector> rows(residuals, n + 1);
    rows.setZero();
    rows[n] = std::sqrt(squares);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;

    Matrix J;
    if (!residual_.slopes(u, J)) return false;
    slopes_.follow(residual_, J);
    Matrix H = slopes_.gram();
    H.diagonal().array() += 1.0;
    Vector gradient = slopes_.weighed().transpose() * root + u;
    hold_at_bounds(u, gradient, H);
    const Eigen::LLT<Matrix> factor(H);
    rows.head(n) = factor.matrixL().solve(gradient);
    rows[n] = std::sqrt(std::max(0.0, squares - rows.head(n).squaredNorm()));
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> all(
        jacobians[0], n + 1, n);
    all.topRows(n) = factor.matrixU();
    all.bottomRows(1).setZero();
    return true;
  }

 private:
  /// A parameter at a bound beyond which the cost falls stays there, and the step of the others is
  /// that of the problem without it (Bertsekas 1982, projected Newton). Where a step was merely
  /// cut, it would be made for a place that no parameter may reach.
  void hold_at_bounds(const Vector& u, Vector& gradient, Matrix& H) const {
    for (Eigen::Index i = 0; i < u.size(); ++i) {
      const Bounds range = residual_.range(i);
      const bool held =
          (u[i] <= range.lower && gradient[i] > 0.0) || (u[i] >= range.upper && gradient[i] < 0.0);
      if (!held) continue;
      gradient[i] = 0.0;
      H.row(i).setZero();
      H.col(i).setZero();
      H(i, i) = 1.0;
    }
  }

  Residual& residual_;
  const RandomWeights& weights_;
  mutable WeighedSlopes slopes_;  // Ceres evaluates through a constant
};

}  // namespace

std::optional<double> minimise(Residual& residual, const RandomWeights& weights, int iterations,
                               Vector& u) {
  const Settings& settings = residual.settings();
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
  // With bounds Ceres would search along every step, up to twenty simulations where none is lower.
  // A step that fails is shortened by the trust region instead.
  options.max_num_line_search_step_size_iterations = 0;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  if (!summary.IsSolutionUsable()) return {};
  return summary.initial_cost - summary.final_cost;
}

}  // namespace jaculus::diagnosis
