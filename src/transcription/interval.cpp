#include "jaculus/transcription/interval.h"

#include "jaculus/core/small_product.h"

namespace jaculus::transcription {

Interval::Interval(const components::Equations& equations, const Layout& layout,
                   const IntervalBlock& block, Scheme scheme)
    : equations_(equations),
      scheme_(scheme),
      held_(layout.held),
      n_(layout.n),
      n_u_(layout.n_u),
      fraction_(block.fraction) {
  const NodeBlock &first = layout.nodes[block.first], &last = layout.nodes[block.last];
  const PhaseBlock& phase = layout.phases[block.phase];
  const auto append = [&](int from, int count) {
    for (int i = 0; i < count; ++i) columns.push_back(from + i);
  };
  append(first.q, 2 * n_);
  append(last.q, 2 * n_);
  append(block.u_first, n_u_);
  if (!held_) append(block.u_last, n_u_);
  columns.push_back(phase.duration);

  const int w = size(), s = 2 * n_ + n_u_, xi = s + n_ + 2 * count_of(phase.feet);
  for (int i = 0; i < 3; ++i) {
    points_.emplace_back(equations, phase.feet);
    u_[i] = Vector::Zero(n_u_);
    f_[i] = Vector::Zero(2 * n_);
    S_[i] = Matrix::Zero(s, w);
    F_[i] = Matrix::Zero(2 * n_, s);
    F_w_[i] = Matrix::Zero(2 * n_, w);
  }
  defect_w_ = Matrix::Zero(2 * n_, w);
  w_ = grad_w_ = Vector::Zero(w);
  phi_ = Vector::Zero(2 * n_);
  grad_s_ = Vector::Zero(s);
  mu_ = Vector::Zero(points_[0].Z.rows());
  J_xi_ = Matrix::Zero(kMaxTermRows, xi);
  by_s_ = Matrix::Zero(kMaxTermRows, s);
  H_xi_ = Matrix::Zero(xi, xi);
  H_s_ = Matrix::Zero(s, s);
  HS_ = Matrix::Zero(s, w);
  S_middle_t_ = Matrix::Zero(w, s);
  values_ = Vector::Zero(kMaxTermRows);
  pull_ = Vector::Zero(2 * n_);
  half_ = Matrix::Zero(xi - s, s);
  product_ = Matrix::Zero(s, s);
  build_maps();
}

void Interval::build_maps() {
  const int u = 4 * n_, second = held_ ? u : u + n_u_;
  for (int i = 0; i < 2 * n_; ++i) {
    S_[0](i, i) = 1.0;
    S_[2](i, 2 * n_ + i) = 1.0;
  }
  for (int i = 0; i < n_u_; ++i) {
    S_[0](2 * n_ + i, u + i) = 1.0;
    S_[1](2 * n_ + i, u + i) += 0.5;
    S_[1](2 * n_ + i, second + i) += 0.5;
    S_[2](2 * n_ + i, second + i) = 1.0;
  }
}

double Interval::weight(int i) const {
  if (scheme_ == Scheme::trapezoidal) return i == 1 ? 0.0 : 0.5;
  return i == 1 ? 4.0 / 6.0 : 1.0 / 6.0;
}

PointView Interval::view(int i) { return {equations_, points_[i], u_[i], n_, n_u_}; }

void Interval::f_into(int i, Vector& f) const {
  const components::EquationsPoint& p = points_[i];
  f.head(n_) = p.v;
  f.tail(n_) = p.a;
}

void Interval::f_jacobian(int i, Matrix& F) const {
  for (int k = 0; k < n_; ++k) F(k, n_ + k) = 1.0;
  F.bottomRows(n_) = points_[i].Z.topRows(n_);
}

bool Interval::evaluate(const Eigen::Ref<const Vector>& x) {
  for (int i = 0; i < size(); ++i) w_[i] = x[columns[i]];
  h_ = fraction_ * w_[size() - 1];
  const int second = held_ ? 4 * n_ : 4 * n_ + n_u_;
  u_[0] = w_.segment(4 * n_, n_u_);
  u_[2] = w_.segment(second, n_u_);
  u_[1] = 0.5 * (u_[0] + u_[2]);
  if (!equations_.evaluate(w_.segment(0, n_), w_.segment(n_, n_), u_[0], points_[0])) return false;
  if (!equations_.evaluate(w_.segment(2 * n_, n_), w_.segment(3 * n_, n_), u_[2], points_[2]))
    return false;
  f_into(0, f_[0]);
  f_into(2, f_[2]);
  if (!has_middle()) return true;
  phi_ = 0.5 * (w_.segment(0, 2 * n_) + w_.segment(2 * n_, 2 * n_)) + h_ / 8.0 * (f_[0] - f_[2]);
  if (!equations_.evaluate(phi_.head(n_), phi_.tail(n_), u_[1], points_[1])) return false;
  f_into(1, f_[1]);
  return true;
}

void Interval::differentiate() {
  for (int i = 0; i < 3; ++i) {
    if (i == 1 && !has_middle()) continue;
    equations_.differentiate(points_[i]);
    f_jacobian(i, F_[i]);
  }

  const int second = held_ ? 4 * n_ : 4 * n_ + n_u_;
  F_w_[0].leftCols(2 * n_) = F_[0].leftCols(2 * n_);
  F_w_[0].middleCols(4 * n_, n_u_) = F_[0].rightCols(n_u_);
  F_w_[2].middleCols(2 * n_, 2 * n_) = F_[2].leftCols(2 * n_);
  F_w_[2].middleCols(second, n_u_) = F_[2].rightCols(n_u_);

  if (has_middle()) {
    auto Sx = S_[1].topRows(2 * n_);
    Sx = h_ / 8.0 * (F_w_[0] - F_w_[2]);
    for (int i = 0; i < 2 * n_; ++i) {
      Sx(i, i) += 0.5;
      Sx(i, 2 * n_ + i) += 0.5;
    }
    Sx.col(size() - 1) += fraction_ / 8.0 * (f_[0] - f_[2]);
    set_product(F_[1], S_[1], F_w_[1]);
    S_middle_t_ = S_[1].transpose();
  }

  differentiate_defects();
}

void Interval::defects(VectorRef out) const {
  out = w_.segment(2 * n_, 2 * n_) - w_.segment(0, 2 * n_);
  for (int i = 0; i < 3; ++i)
    if (weight(i) != 0.0) out -= h_ * weight(i) * f_[i];
}

void Interval::differentiate_defects() {
  defect_w_.setZero();
  for (int i = 0; i < 2 * n_; ++i) {
    defect_w_(i, i) = -1.0;
    defect_w_(i, 2 * n_ + i) = 1.0;
  }
  for (int i = 0; i < 3; ++i) {
    if (weight(i) == 0.0) continue;
    defect_w_ -= h_ * weight(i) * F_w_[i];
    defect_w_.col(size() - 1) -= fraction_ * weight(i) * f_[i];
  }
}

void Interval::path_values(const PathRows& rows, VectorRef out) {
  rows.term->evaluate(view(rows.point), out, nullptr, nullptr, nullptr);
}

/// Jacobian of a term by (q, v, u) of its point: direct, and through accelerations and forces.
/// Values are left in values_.
void Interval::chain_term(int i, const PathTerm& term, Matrix& by_s) {
  const int rows = count_of(term.rows), s = 2 * n_ + n_u_;
  J_xi_.topRows(rows).setZero();
  term.evaluate(view(i), values_.head(rows), &J_xi_, nullptr, nullptr);
  by_s.topRows(rows) = J_xi_.topRows(rows).leftCols(s);
  if (term.reads.dynamics()) {
    const components::EquationsPoint& p = points_[i];
    add_product(J_xi_.topRows(rows).rightCols(J_xi_.cols() - s), p.Z, by_s.topRows(rows));
  }
}

void Interval::path_jacobian(const PathRows& rows, Matrix& out) {
  const int count = count_of(rows.term->rows);
  chain_term(rows.point, *rows.term, by_s_);
  auto J = out.topRows(count);
  const auto by_s = by_s_.topRows(count);
  if (rows.point == 1) {
    set_product(by_s, S_[1], J);
    return;
  }
  // At the ends (q, v, u) are variables themselves.
  J.setZero();
  J.middleCols(rows.point == 0 ? 0 : 2 * n_, 2 * n_) = by_s.leftCols(2 * n_);
  J.middleCols(rows.point == 0 || held_ ? 4 * n_ : 4 * n_ + n_u_, n_u_) = by_s.rightCols(n_u_);
}

double Interval::integral(const IntegralCost& cost) {
  double sum = 0.0;
  for (int i = 0; i < 3; ++i) {
    if (weight(i) == 0.0) continue;
    cost.term->evaluate(view(i), values_.head(1), nullptr, nullptr, nullptr);
    sum += weight(i) * values_[0];
  }
  return cost.weight * h_ * sum;
}

void Interval::add_integral_gradient(const IntegralCost& cost, double scale, Vector& gradient_w) {
  for (int i = 0; i < 3; ++i) {
    if (weight(i) == 0.0) continue;
    const double factor = scale * cost.weight * weight(i);
    chain_term(i, *cost.term, by_s_);
    gradient_w.noalias() += factor * h_ * S_[i].transpose().lazyProduct(by_s_.row(0).transpose());
    gradient_w[size() - 1] += factor * fraction_ * values_[0];
  }
}

/// Adds a term at one point, weighted: its Hessian to H_xi_, its gradient to grad_s_ and, by
/// accelerations and forces, to mu_.
void Interval::add_point_term(int i, const PathTerm& term, const ConstVectorRef& multipliers) {
  const int rows = count_of(term.rows), s = 2 * n_ + n_u_;
  J_xi_.topRows(rows).setZero();
  term.evaluate(view(i), values_.head(rows), &J_xi_, &multipliers, &H_xi_);
  const auto J = J_xi_.topRows(rows);
  grad_s_ += J.leftCols(s).transpose().lazyProduct(multipliers);
  if (term.reads.dynamics()) mu_ += J.rightCols(mu_.size()).transpose().lazyProduct(multipliers);
}

/// Gradient (grad_s_) and Hessian (H_s_) by (q, v, u) of phi . f + path rows + costs at one point.
void Interval::point_hessian(int i, const Vector& phi, const ConstVectorRef& row_multipliers,
                             double sigma, const std::vector<IntegralCost>& costs) {
  components::EquationsPoint& p = points_[i];
  grad_s_.setZero();
  H_s_.setZero();
  mu_.setZero();
  mu_.head(n_) = phi.tail(n_);
  grad_s_.segment(n_, n_) = phi.head(n_);

  bool curved = false;
  H_xi_.setZero();
  for (const PathRows& rows : path) {
    if (rows.point != i) continue;
    add_point_term(i, *rows.term, row_multipliers.segment(rows.row, count_of(rows.term->rows)));
    curved = true;
  }
  for (const IntegralCost& cost : costs) {
    if (weight(i) == 0.0) continue;
    const Eigen::Matrix<double, 1, 1> factor(sigma * cost.weight * weight(i) * h_);
    add_point_term(i, *cost.term, factor);
    curved = true;
  }

  equations_.add_hessian(mu_, p, H_s_);
  if (curved) add_term_curvature(p.Z);
  grad_s_ += p.Z.transpose().lazyProduct(mu_);
}

/// H_s_ += second derivatives of the terms, of those that read accelerations and forces through Z =
/// d(a, f)/d(q, v, u).
void Interval::add_term_curvature(const Matrix& Z) {
  const auto s = H_s_.rows(), z = H_xi_.rows() - s;
  H_s_ += H_xi_.topLeftCorner(s, s);
  const auto zz = H_xi_.bottomRightCorner(z, z);
  const auto zs = H_xi_.bottomLeftCorner(z, s);
  if (zz.isZero(0.0) && zs.isZero(0.0)) return;
  half_ = zz.lazyProduct(Z) + 2.0 * zs;
  product_ = Z.transpose().lazyProduct(half_);
  H_s_ += 0.5 * (product_ + product_.transpose());
}

/// H += scale * (gradient_w e_T^T + e_T gradient_w^T).
void Interval::add_time_coupling(const Vector& gradient_w, double scale, Matrix& H) {
  H.col(size() - 1) += scale * gradient_w;
  H.row(size() - 1) += scale * gradient_w.transpose();
}

void Interval::add_hessian(const Vector& eta, const ConstVectorRef& row_multipliers, double sigma,
                           const std::vector<IntegralCost>& costs, Matrix& H) {
  const int x = 2 * n_;
  pull_.setZero();  // gradient by x_m, which f_0 and f_2 move

  if (has_middle()) {
    phi_ = -h_ * weight(1) * eta;
    point_hessian(1, phi_, row_multipliers, sigma, costs);
    set_product(H_s_, S_[1], HS_);
    add_product_lower(S_middle_t_, HS_, H);
    pull_ = grad_s_.head(x);
    grad_w_.noalias() = F_w_[0].transpose() * pull_;
    grad_w_.noalias() -= F_w_[2].transpose() * pull_;
    add_time_coupling(grad_w_, fraction_ / 8.0, H);
  }

  for (int i = 0; i < 3; i += 2) {
    phi_ = -h_ * weight(i) * eta + (i == 0 ? h_ / 8.0 : -h_ / 8.0) * pull_;
    point_hessian(i, phi_, row_multipliers, sigma, costs);
    const int at = i == 0 ? 0 : x, u = i == 0 || held_ ? 4 * n_ : 4 * n_ + n_u_;
    H.block(at, at, x, x) += H_s_.topLeftCorner(x, x);
    H.block(at, u, x, n_u_) += H_s_.topRightCorner(x, n_u_);
    H.block(u, at, n_u_, x) += H_s_.bottomLeftCorner(n_u_, x);
    H.block(u, u, n_u_, n_u_) += H_s_.bottomRightCorner(n_u_, n_u_);
  }

  for (int i = 0; i < 3; ++i) {
    if (weight(i) == 0.0) continue;
    grad_w_.noalias() = F_w_[i].transpose() * eta;
    add_time_coupling(grad_w_, -fraction_ * weight(i), H);
    for (const IntegralCost& cost : costs) {
      chain_term(i, *cost.term, by_s_);
      grad_w_ = S_[i].transpose().lazyProduct(by_s_.row(0).transpose());
      add_time_coupling(grad_w_, sigma * cost.weight * weight(i) * fraction_, H);
    }
  }
}

}  // namespace jaculus::transcription
