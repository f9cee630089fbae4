// Values and first derivatives.

#include "jaculus/transcription/interval_batch.h"

#include "jaculus/core/small_product.h"

namespace jaculus::transcription {

namespace {

MatrixOf<Lanes> zeros(int rows, int columns) {
  return MatrixOf<Lanes>::Constant(rows, columns, 0.0);
}

template <class From, class To>
void copy_lane(const From& from, int at, To& to) {
  for (int i = 0; i < count_of(to); ++i) to.data()[i] = lane(from.data()[i], at);
}

}  // namespace

IntervalBatch::IntervalBatch(const components::Equations& equations, const Layout& layout,
                             std::vector<Interval*> members, std::vector<IntegralCost> costs)
    : equations_(equations),
      members_(std::move(members)),
      costs_(std::move(costs)),
      held_(layout.held),
      n_(layout.n),
      n_u_(layout.n_u),
      w_size_(members_.front()->size()) {
  assert(!members_.empty() && count_of(members_) <= kLanes);
  const int w = w_size_, s = 2 * n_ + n_u_, z = n_ + 2 * count_of(members_.front()->feet());
  place_path();
  find_curved();
  for (int k = 0; k < kLanes; ++k)
    set_lane(fraction_, k, members_[std::min(k, count_of(members_) - 1)]->fraction());

  for (int i = 0; i < 3; ++i) {
    points_.emplace_back(equations, members_.front()->feet());
    u_[i] = zeros(n_u_, 1);
  }
  w_ = grad_w_ = zeros(w, 1);
  x_middle_ = eta_ = pull_ = phi_ = zeros(2 * n_, 1);
  S_v_ = A_w_ = zeros(n_, w);
  defect_w_ = zeros(2 * n_, w);
  path_w_ = zeros(path_place_[2] + path_rows_[2], w);
  for (int i = 0; i < 3; ++i) {
    by_s_[i] = zeros(path_rows_[i], s);
    by_z_[i] = zeros(path_rows_[i], z);
    lambda_[i] = zeros(path_rows_[i], 1);
  }

  J_xi_ = Matrix::Zero(kMaxTermRows, s + z);
  H_xi_ = Matrix::Zero(s + z, s + z);
  values_ = Vector::Zero(kMaxTermRows);
  cost_s_ = zeros(1, s);
  cost_z_ = zeros(1, z);
  cost_w_ = zeros(1, w);
  grad_s_ = zeros(s, 1);
  mu_ = zeros(z, 1);
  H_ = zeros(w, w);
  H_s_ = product_ = zeros(s, s);
  H_zz_ = zeros(z, z);
  H_zs_ = half_ = zeros(z, s);
  HS_ = zeros(s, w);
}

double IntervalBatch::weight(int i) const {
  if (!has_middle()) return i == 1 ? 0.0 : 0.5;
  return i == 1 ? 4.0 / 6.0 : 1.0 / 6.0;
}

/// Of a point, to the members' own, what path terms see.
void IntervalBatch::unpack(int i, bool derivatives) {
  const Point& from = points_[i];
  for (int k = 0; k < count_of(members_); ++k) {
    components::EquationsPoint& to = members_[k]->point(i);
    if (derivatives) {
      if (poses_read_) copy_lane(from.motion.X, k, to.motion.X);
      continue;
    }

    copy_lane(from.q, k, to.q);
    copy_lane(from.v, k, to.v);
    copy_lane(from.a, k, to.a);
    copy_lane(from.force, k, to.force);
    copy_lane(u_[i], k, members_[k]->input(i));
    if (!poses_read_) continue;

    copy_lane(from.motion.pose.Y, k, to.motion.pose.Y);
    copy_lane(from.motion.pose.cosine, k, to.motion.pose.cosine);
    copy_lane(from.motion.pose.sine, k, to.motion.pose.sine);
    copy_lane(from.motion.d, k, to.motion.d);
    copy_lane(from.motion.V, k, to.motion.V);
    copy_lane(from.motion.gamma, k, to.motion.gamma);
    copy_lane(from.motion.C, k, to.motion.C);
    copy_lane(from.motion.C_d, k, to.motion.C_d);
    copy_lane(from.motion.C_d_inverse, k, to.motion.C_d_inverse);
    copy_lane(from.motion.D, k, to.motion.D);
    copy_lane(from.motion.G, k, to.motion.G);
  }
}

bool IntervalBatch::evaluate_point(int i, const VectorOf<Lanes>& state) {
  if (!equations_.evaluate(state.head(n_), state.tail(n_), u_[i], points_[i])) return false;
  unpack(i, false);
  return true;
}

bool IntervalBatch::evaluate(const ConstVectorRef& x) {
  for (int k = 0; k < kLanes; ++k) {
    const Interval& member = *members_[std::min(k, count_of(members_) - 1)];
    for (int i = 0; i < w_size_; ++i) set_lane(w_[i], k, x[member.columns[i]]);
  }
  h_ = fraction_ * w_[w_size_ - 1];
  for (int k = 0; k < count_of(members_); ++k) members_[k]->set_length(lane(h_, k));

  for (int i = 0; i < n_u_; ++i) {
    u_[0][i] = w_[u_at(0) + i];
    u_[2][i] = w_[u_at(2) + i];
    u_[1][i] = 0.5 * (u_[0][i] + u_[2][i]);
  }
  for (int end : {0, 2}) {
    phi_ = w_.segment(x_at(end), 2 * n_);
    if (!evaluate_point(end, phi_)) return false;
  }
  if (!has_middle()) return true;

  const Lanes eighth = h_ * 0.125;
  for (int i = 0; i < n_; ++i) {
    x_middle_[i] = 0.5 * (w_[i] + w_[2 * n_ + i]) + eighth * (points_[0].v[i] - points_[2].v[i]);
    x_middle_[n_ + i] =
        0.5 * (w_[n_ + i] + w_[3 * n_ + i]) + eighth * (points_[0].a[i] - points_[2].a[i]);
  }
  return evaluate_point(1, x_middle_);
}

void IntervalBatch::differentiate() {
  for (int i = 0; i < 3; ++i) {
    if (i == 1 && !has_middle()) continue;
    equations_.differentiate(points_[i]);
    unpack(i, true);
  }
  if (has_middle()) differentiate_middle();
  differentiate_defects();
  differentiate_path();
}

/// S's rows of v_m, and d a_m/dw = Z_m S.
void IntervalBatch::differentiate_middle() {
  const Lanes eighth = h_ * 0.125;
  S_v_.setZero();
  for (const int end : {0, 2}) {
    const Lanes factor = end == 0 ? eighth : -eighth;
    const MatrixOf<Lanes>& Z = points_[end].Z;
    for (int j = 0; j < 2 * n_; ++j)
      for (int i = 0; i < n_; ++i) S_v_(i, x_at(end) + j) = factor * Z(i, j);
    for (int j = 0; j < n_u_; ++j)
      for (int i = 0; i < n_; ++i) S_v_(i, u_at(end) + j) += factor * Z(i, 2 * n_ + j);
    for (int i = 0; i < n_; ++i) S_v_(i, x_at(end) + n_ + i) += 0.5;
  }
  for (int i = 0; i < n_; ++i)
    S_v_(i, w_size_ - 1) = fraction_ * 0.125 * (points_[0].a[i] - points_[2].a[i]);
  times_middle(points_[1].Z.topRows(n_), A_w_);
}

/// by_w = by_s S; by_s: rows x (q, v, u) of the middle.
void IntervalBatch::times_middle(const ConstRefOf<Lanes>& by_s, RefOf<Lanes> by_w) const {
  set_product(by_s.middleCols(n_, n_), S_v_, by_w);
  const Lanes eighth = h_ * 0.125;
  const int rows = count_of(by_s) / (2 * n_ + n_u_);

  for (int j = 0; j < n_; ++j) {
    const Lanes by_T = fraction_ * 0.125 * (points_[0].v[j] - points_[2].v[j]);
    for (int r = 0; r < rows; ++r) {
      const Lanes by_q = by_s(r, j);
      by_w(r, j) += 0.5 * by_q;
      by_w(r, 2 * n_ + j) += 0.5 * by_q;
      by_w(r, n_ + j) += eighth * by_q;
      by_w(r, 3 * n_ + j) -= eighth * by_q;
      by_w(r, w_size_ - 1) += by_T * by_q;
    }
  }
  for (const int end : {0, 2})
    for (int j = 0; j < n_u_; ++j)
      for (int r = 0; r < rows; ++r) by_w(r, u_at(end) + j) += 0.5 * by_s(r, 2 * n_ + j);
}

/// by_w of any point.
void IntervalBatch::by_variables(int i, const ConstRefOf<Lanes>& by_s, RefOf<Lanes> by_w) const {
  if (i == 1) return times_middle(by_s, by_w);
  // At the ends (q, v, u) are variables themselves.
  by_w.setZero();
  by_w.middleCols(x_at(i), 2 * n_) = by_s.leftCols(2 * n_);
  by_w.middleCols(u_at(i), n_u_) = by_s.rightCols(n_u_);
}

void IntervalBatch::differentiate_defects() {
  defect_w_.setZero();
  const int T = w_size_ - 1;
  if (has_middle()) {
    const Lanes factor = -h_ * weight(1);
    for (int j = 0; j < w_size_; ++j) {
      for (int i = 0; i < n_; ++i) {
        defect_w_(i, j) = factor * S_v_(i, j);
        defect_w_(n_ + i, j) = factor * A_w_(i, j);
      }
    }
  }

  for (const int end : {0, 2}) {
    const Lanes factor = -h_ * weight(end), one = end == 0 ? -1.0 : 1.0;
    const MatrixOf<Lanes>& Z = points_[end].Z;
    for (int i = 0; i < n_; ++i) defect_w_(i, x_at(end) + n_ + i) += factor;
    for (int i = 0; i < 2 * n_; ++i) defect_w_(i, x_at(end) + i) += one;
    for (int j = 0; j < 2 * n_; ++j)
      for (int i = 0; i < n_; ++i) defect_w_(n_ + i, x_at(end) + j) += factor * Z(i, j);
    for (int j = 0; j < n_u_; ++j)
      for (int i = 0; i < n_; ++i) defect_w_(n_ + i, u_at(end) + j) += factor * Z(i, 2 * n_ + j);
  }

  for (int p = 0; p < 3; ++p) {
    if (weight(p) == 0.0) continue;
    const Lanes factor = -fraction_ * weight(p);
    for (int i = 0; i < n_; ++i) {
      defect_w_(i, T) += factor * points_[p].v[i];
      defect_w_(n_ + i, T) += factor * points_[p].a[i];
    }
  }
}

void IntervalBatch::defects(VectorRef rows) {
  for (int i = 0; i < 2 * n_; ++i) {
    Lanes defect = w_[2 * n_ + i] - w_[i];
    for (int p = 0; p < 3; ++p) {
      if (weight(p) == 0.0) continue;
      defect -= h_ * weight(p) * (i < n_ ? points_[p].v[i] : points_[p].a[i - n_]);
    }
    for (int k = 0; k < count_of(members_); ++k)
      rows[members_[k]->defect_row + i] = lane(defect, k);
  }
}

}  // namespace jaculus::transcription
