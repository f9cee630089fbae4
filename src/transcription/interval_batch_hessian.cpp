// Second derivatives. With eta the multipliers of the defects, the points have weights
//     phi_m = -h w_m eta,    phi_i = -h w_i eta +- h/8 (gradient by x_m),
// for the ends move the middle; S^T H_m S is the middle's own curvature, and what h multiplies is
// coupled with T.

#include "jaculus/core/small_product.h"
#include "jaculus/transcription/interval_batch.h"

namespace jaculus::transcription {

/// Adds the gradient of lambda . (path rows) at one point, total, to grad_s_, and its part by
/// accelerations and forces to mu_.
void IntervalBatch::add_path_gradient(int i, const ConstVectorRef& lambda) {
  for (int k = 0; k < count_of(members_); ++k) {
    int at = 0;
    for (const PathRows& rows : members_[k]->path) {
      if (rows.point != i) continue;
      for (int r = 0; r < count_of(rows.term->rows); ++r)
        set_lane(lambda_[i][at++], k, lambda[rows.row + r]);
    }
  }
  add_transposed_product(by_s_[i], lambda_[i], grad_s_);
  add_transposed_product(by_z_[i], lambda_[i], mu_);
}

/// Adds the weighted Hessians of path rows and costs at one point, member by member, to H_s_, H_zs_
/// and H_zz_.
void IntervalBatch::add_term_hessians(int i, const ConstVectorRef& lambda, double sigma) {
  const std::vector<int>& places = curved_[i];
  if (places.empty()) return;
  const int s = count_of(grad_s_);

  for (int k = 0; k < count_of(members_); ++k) {
    Interval& member = *members_[k];
    for (const int j : places)
      for (const int r : places) H_xi_(r, j) = 0.0;

    for (const PathRows& rows : member.path) {
      if (rows.point != i || rows.term->linear) continue;
      const int count = count_of(rows.term->rows);
      const ConstVectorRef multipliers = lambda.segment(rows.row, count);
      rows.term->evaluate(member.view(i), values_.head(count), nullptr, &multipliers, &H_xi_);
    }
    for (const IntegralCost& cost : costs_) {
      if (weight(i) == 0.0 || cost.term->linear) continue;
      const Eigen::Matrix<double, 1, 1> factor(sigma * cost.weight * weight(i) * member.length());
      const ConstVectorRef multipliers(factor);
      cost.term->evaluate(member.view(i), values_.head(1), nullptr, &multipliers, &H_xi_);
    }

    for (const int j : places) {
      for (const int r : places) {
        const double value = H_xi_(r, j);
        if (value == 0.0 || (r < s && j >= s)) continue;  // of both mixed halves, one
        forces_curved_ = forces_curved_ || r >= s;
        Lanes& to = r < s ? H_s_(r, j) : j < s ? H_zs_(r - s, j) : H_zz_(r - s, j - s);
        set_lane(to, k, lane(to, k) + value);
      }
    }
  }
}

/// Gradient (grad_s_) and Hessian (H_s_) by (q, v, u) of phi_ . f + path rows + costs at one point.
void IntervalBatch::point_hessian(int i, const ConstVectorRef& lambda, double sigma) {
  Point& p = points_[i];
  grad_s_.setZero();
  mu_.setZero();
  H_s_.setZero();
  H_zs_.setZero();
  H_zz_.setZero();
  forces_curved_ = false;

  // what is by accelerations and forces goes by Z, which the gradients of terms have behind them
  mu_.head(n_) = phi_.tail(n_);
  grad_s_.segment(n_, n_) = phi_.head(n_);
  add_transposed_product(p.Z, mu_, grad_s_);
  if (path_rows_[i] > 0) add_path_gradient(i, lambda);
  for (const IntegralCost& cost : costs_) {
    if (weight(i) == 0.0) continue;
    chain_cost(i, cost);
    const Lanes factor = sigma * cost.weight * weight(i) * h_;
    for (int j = 0; j < count_of(grad_s_); ++j) grad_s_[j] += factor * cost_s_(0, j);
    for (int j = 0; j < count_of(mu_); ++j) mu_[j] += factor * cost_z_(0, j);
  }

  equations_.add_hessian(mu_, p, H_s_);
  add_term_hessians(i, lambda, sigma);
  if (forces_curved_) add_term_curvature(i);
}

/// H_s_ += second derivatives of the terms that read accelerations and forces through Z =
/// d(a, f)/d(q, v, u).
void IntervalBatch::add_term_curvature(int i) {
  const MatrixOf<Lanes>& Z = points_[i].Z;
  half_ = H_zs_ + H_zs_;
  add_product(H_zz_, Z, half_);
  product_.setZero();
  add_transposed_product(Z, half_, product_);
  for (int j = 0; j < count_of(grad_s_); ++j)
    for (int k = 0; k < count_of(grad_s_); ++k)
      H_s_(k, j) += 0.5 * (product_(k, j) + product_(j, k));
}

/// H_ += S^T H_s S, the lower triangle.
void IntervalBatch::add_middle_hessian() {
  times_middle(H_s_, HS_);
  add_transposed_product_lower(S_v_, HS_.middleRows(n_, n_), H_);

  const Lanes eighth = h_ * 0.125;
  for (int j = 0; j < w_size_; ++j) {
    Lanes by_T = 0.0;
    for (int i = 0; i < n_; ++i) {
      const Lanes by_q = HS_(i, j), half = 0.5 * by_q, moved = eighth * by_q;
      H_(i, j) += half;
      H_(2 * n_ + i, j) += half;
      H_(n_ + i, j) += moved;
      H_(3 * n_ + i, j) -= moved;
      by_T += fraction_ * 0.125 * (points_[0].v[i] - points_[2].v[i]) * by_q;
    }
    H_(w_size_ - 1, j) += by_T;
    for (const int end : {0, 2})
      for (int i = 0; i < n_u_; ++i) H_(u_at(end) + i, j) += 0.5 * HS_(2 * n_ + i, j);
  }
}

void IntervalBatch::add_end_hessian(int i) {
  const int x = 2 * n_;
  H_.block(x_at(i), x_at(i), x, x) += H_s_.topLeftCorner(x, x);
  H_.block(u_at(i), x_at(i), n_u_, x) += H_s_.bottomLeftCorner(n_u_, x);
  H_.block(u_at(i), u_at(i), n_u_, n_u_) += H_s_.bottomRightCorner(n_u_, n_u_);
}

/// H_ += scale * (grad_w_ e_T^T + e_T grad_w_^T).
void IntervalBatch::add_time_coupling(const Lanes& scale) {
  const int T = w_size_ - 1;
  for (int j = 0; j < w_size_; ++j) H_(T, j) += scale * grad_w_[j];
  H_(T, T) += scale * grad_w_[T];
}

/// grad_w_ += scale * (d f/dw)^T y at an end.
void IntervalBatch::add_end_gradient(int i, const VectorOf<Lanes>& y, const Lanes& scale) {
  const MatrixOf<Lanes>& Z = points_[i].Z;
  for (int j = 0; j < n_; ++j) grad_w_[x_at(i) + n_ + j] += scale * y[j];
  for (int j = 0; j < 2 * n_ + n_u_; ++j) {
    Lanes sum = 0.0;
    for (int k = 0; k < n_; ++k) sum += Z(k, j) * y[n_ + k];
    grad_w_[j < 2 * n_ ? x_at(i) + j : u_at(i) + j - 2 * n_] += scale * sum;
  }
}

/// What h multiplies in the defects and the integrals.
void IntervalBatch::add_defect_times(double sigma) {
  for (int i = 0; i < 3; ++i) {
    if (weight(i) == 0.0) continue;
    grad_w_.setZero();
    if (i == 1) {
      add_transposed_product(S_v_, eta_.head(n_), grad_w_);
      add_transposed_product(A_w_, eta_.tail(n_), grad_w_);
    } else {
      add_end_gradient(i, eta_, 1.0);
    }
    add_time_coupling(-fraction_ * weight(i));

    for (const IntegralCost& cost : costs_) {
      chain_cost(i, cost);
      grad_w_ = cost_w_.row(0).transpose();
      add_time_coupling(sigma * cost.weight * weight(i) * fraction_);
    }
  }
}

const MatrixOf<Lanes>& IntervalBatch::hessian(const ConstVectorRef& lambda, double sigma) {
  for (int k = 0; k < kLanes; ++k) {
    const int row = members_[std::min(k, count_of(members_) - 1)]->defect_row;
    for (int i = 0; i < 2 * n_; ++i) set_lane(eta_[i], k, lambda[row + i]);
  }
  H_.setZero();
  pull_.setZero();  // gradient by x_m, which f_0 and f_2 move

  const Lanes eighth = h_ * 0.125;
  if (has_middle()) {
    for (int j = 0; j < 2 * n_; ++j) phi_[j] = -h_ * weight(1) * eta_[j];
    point_hessian(1, lambda, sigma);
    add_middle_hessian();
    pull_ = grad_s_.head(2 * n_);
    grad_w_.setZero();
    add_end_gradient(0, pull_, 1.0);
    add_end_gradient(2, pull_, -1.0);
    add_time_coupling(fraction_ * 0.125);
  }

  for (const int end : {0, 2}) {
    const Lanes moves = end == 0 ? eighth : -eighth;
    for (int j = 0; j < 2 * n_; ++j) phi_[j] = moves * pull_[j] - h_ * weight(end) * eta_[j];
    point_hessian(end, lambda, sigma);
    add_end_hessian(end);
  }
  add_defect_times(sigma);
  return H_;
}

}  // namespace jaculus::transcription
