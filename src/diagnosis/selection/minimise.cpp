#include "diagnosis/selection/minimise.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "diagnosis/noise/random_weights.h"

namespace jaculus::diagnosis {
namespace {

/// Rows that a misfit weighs alike: spans of first and count.
using Part = std::vector<std::pair<int, int>>;

/// W = M J of a residual's slopes on the way, and W^T W of every part of the rows. Where slopes
/// follow secants, J + d s^T with s zero but for those that follow, so do both: W + w s^T with
/// w = M d, and with v = W^T w of a part
///   W^T W + v s^T + s v^T + w^T w s s^T,
/// passes over one column in place of all. Misfits that follow change the parts' shares in H alone.
class WeighedSlopes {
 public:
  WeighedSlopes(const RandomWeights& weights, std::vector<Part> parts)
      : weights_(weights), parts_(std::move(parts)), grams_(parts_.size()) {}

  void follow(const Residual& residual, const Matrix& J) {
    const Eigen::Index before = residual.first_followed();
    const std::vector<Residual::Secant>& secants = residual.secants();
    if (W_.size() == 0 || renewed_ != residual.times_renewed()) {
      W_ = weights_.stacked(J);
      for (std::size_t k = 0; k < parts_.size(); ++k) grams_[k] = gram_of(parts_[k]);
    } else {
      for (; followed_ < secants.size(); ++followed_) add(secants[followed_], before);
      if (before > 0) renew(J.leftCols(before));
    }
    renewed_ = residual.times_renewed();
    followed_ = secants.size();
  }

  /// W^T W and W^T x, a share of each part's rows.
  [[nodiscard]] Matrix gram(const Vector& shares) const {
    Matrix sum = Matrix::Zero(W_.cols(), W_.cols());
    for (std::size_t k = 0; k < parts_.size(); ++k)
      sum += shares[static_cast<Eigen::Index>(k)] * grams_[k];
    return sum;
  }
  [[nodiscard]] Vector along(const Vector& shares, const Vector& x) const {
    Vector sum = Vector::Zero(W_.cols());
    for (std::size_t k = 0; k < parts_.size(); ++k)
      for (const auto& [first, count] : parts_[k])
        sum.noalias() += shares[static_cast<Eigen::Index>(k)] *
                         (W_.middleRows(first, count).transpose() * x.segment(first, count));
    return sum;
  }

 private:
  [[nodiscard]] Matrix gram_of(const Part& part) const {
    Matrix gram = Matrix::Zero(W_.cols(), W_.cols());
    for (const auto& [first, count] : part)
      gram.selfadjointView<Eigen::Lower>().rankUpdate(W_.middleRows(first, count).transpose());
    gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
    return gram;
  }

  /// The first columns by new slopes.
  void renew(const Matrix& J) {
    const Eigen::Index before = J.cols(), n = W_.cols() - before;
    W_.leftCols(before) = weights_.stacked(J);
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      grams_[k].leftCols(before).setZero();
      for (const auto& [first, count] : parts_[k])
        grams_[k].leftCols(before).noalias() +=
            W_.middleRows(first, count).transpose() * W_.middleRows(first, count).leftCols(before);
      grams_[k].topRightCorner(before, n) = grams_[k].bottomLeftCorner(n, before).transpose();
    }
  }

  /// Of the columns that follow; those before are made anew.
  void add(const Residual::Secant& secant, Eigen::Index before) {
    const Vector w = weights_.stacked(secant.missed);
    const Eigen::Index n = W_.cols() - before, moved = secant.along.size();
    Vector s = Vector::Zero(n);
    s.head(moved) = secant.along;
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      Vector v = Vector::Zero(n);
      double square = 0.0;
      for (const auto& [first, count] : parts_[k]) {
        const auto own = w.segment(first, count);
        v.noalias() += W_.rightCols(n).middleRows(first, count).transpose() * own;
        square += own.squaredNorm();
      }
      grams_[k].bottomRightCorner(n, n) +=
          v * s.transpose() + s * v.transpose() + square * (s * s.transpose());
    }
    W_.middleCols(before, moved).noalias() += w * secant.along.transpose();
  }

  const RandomWeights& weights_;
  std::vector<Part> parts_;
  std::vector<Matrix> grams_;  ///< a part each
  Matrix W_;
  int renewed_ = 0;
  std::size_t followed_ = 0;
};

/// Scales without those of misfits.
Vector without_misfits(const RandomEffects& random, Vector scales) {
  for (const Misfit& misfit : random.misfits) scales[misfit.group] = 0.0;
  return scales;
}

/// Rows of the misfits that follow, then the other rows of M J.
std::vector<Part> parts_of(const RandomEffects& random, bool follow, const RandomWeights& weights,
                           Eigen::Index rows) {
  const auto all = static_cast<int>(rows + weights.more_rows());
  if (!follow) return {{{0, all}}};
  std::vector<Part> parts;
  for (const Misfit& misfit : random.misfits) parts.push_back(misfit.spans);
  parts.emplace_back();
  for (const RandomBlock& block : random.blocks)
    parts.back().emplace_back(block.first, block.count);
  parts.back().insert(parts.back().end(), random.plain.begin(), random.plain.end());
  if (weights.more_rows() > 0) parts.back().emplace_back(rows, all - static_cast<int>(rows));
  return parts;
}

/// Ceres' view.
class Cost : public ceres::CostFunction {
 public:
  Cost(Residual& residual, const RandomEffects& random, const Vector& scales, Misfits misfits)
      : residual_(residual),
        random_(random),
        scales_(scales),
        follow_(misfits == Misfits::follow && !random.misfits.empty()),
        weights_(random, follow_ ? without_misfits(random, scales) : scales) {
    set_num_residuals(static_cast<int>(residual.size()) + 1);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(residual.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Index n = residual_.size();
    const Vector u = Eigen::Map<const Vector>(parameters[0], n);
    Vector r;
    if (!residual_.value(u, r)) return false;
    const Vector scales = follow_ ? misfits_of(random_, r, scales_) : scales_;
    const Vector root = weights_.stacked(r);
    const double log_det = follow_ ? misfits_log_det(random_, scales) : 0.0;
    const double squares = weighed_square(root, scales) + u.squaredNorm() + log_det;
    Eigen::Map<Vector> rows(residuals, n + 1);
    rows.setZero();
    rows[n] = std::sqrt(squares);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;

    Matrix J;
    if (!residual_.slopes(u, J)) return false;
    if (!slopes_) slopes_.emplace(weights_, parts_of(random_, follow_, weights_, r.size()));
    slopes_->follow(residual_, J);
    const Vector shares = shares_at(scales);
    Matrix H = slopes_->gram(shares);
    H.diagonal().array() += 1.0;
    Vector gradient = slopes_->along(shares, root) + u;
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
  /// |x|^2 of rows of M r, each part's by the root of its variance.
  [[nodiscard]] double weighed_square(Vector x, const Vector& scales) const {
    if (!follow_) return x.squaredNorm();
    for (const Misfit& own : random_.misfits)
      for (const auto& [first, count] : own.spans)
        x.segment(first, count) *= 1.0 / std::sqrt(own.variance(scales[own.group]));
    return x.squaredNorm();
  }
  /// Of each part of the rows, what its misfit leaves of their weight.
  [[nodiscard]] Vector shares_at(const Vector& scales) const {
    if (!follow_) return Vector::Ones(1);
    Vector shares = Vector::Ones(count_of(random_.misfits) + 1);
    for (int c = 0; c < count_of(random_.misfits); ++c) {
      const Misfit& own = random_.misfits[c];
      shares[c] = 1.0 / own.variance(scales[own.group]);
    }
    return shares;
  }

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
  const RandomEffects& random_;
  const Vector& scales_;
  bool follow_;
  RandomWeights weights_;                        ///< without misfits where these follow
  mutable std::optional<WeighedSlopes> slopes_;  // Ceres evaluates through a constant
};

}  // namespace

double cost_of(const RandomEffects& random, const Vector& scales, Misfits misfits, const Vector& r,
               const Vector& u) {
  const bool follow = misfits == Misfits::follow;
  const Vector own = follow ? misfits_of(random, r, scales) : scales;
  const RandomWeights weights(random, own);
  const double log_det = follow ? misfits_log_det(random, own) : 0.0;
  return 0.5 * (weights.stacked(r).squaredNorm() + u.squaredNorm() + log_det);
}

std::optional<double> minimise(Residual& residual, const RandomEffects& random,
                               const Vector& scales, Misfits misfits, int iterations, Vector& u) {
  const Settings& settings = residual.settings();
  FLAGS_minloglevel =
      google::GLOG_FATAL;  // a simulation that fails is a status here, no message of a library
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  Cost cost(residual, random, scales, misfits);
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
