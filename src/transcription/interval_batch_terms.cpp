// Path rows and integral costs: functions of one point, taken lane by lane.

#include <algorithm>

#include "jaculus/core/small_product.h"
#include "jaculus/transcription/interval_batch.h"

namespace jaculus::transcription {

namespace {

/// Calls visit(j) for all places j of xi that a term reads, out of n coordinates and so on.
template <class Visit>
void for_read(const Reads& reads, int n, int n_u, int m, Visit&& visit) {
  const bool read[] = {reads.position, reads.velocity, reads.input, reads.acceleration,
                       reads.force};
  const int sizes[] = {n, n, n_u, n, m};
  int at = 0;
  for (int block = 0; block < 5; at += sizes[block++]) {
    if (!read[block]) continue;
    for (int j = at; j < at + sizes[block]; ++j) visit(j);
  }
}

}  // namespace

void IntervalBatch::place_path() {
  for (const Interval* member : members_) {
    std::array<int, 3> rows{};
    for (const PathRows& path : member->path) {
      rows[path.point] += count_of(path.term->rows);
      poses_read_ = poses_read_ || path.term->reads.position;
    }
    for (int i = 0; i < 3; ++i) path_rows_[i] = std::max(path_rows_[i], rows[i]);
  }
  for (const IntegralCost& cost : costs_) poses_read_ = poses_read_ || cost.term->reads.position;
  for (int i = 1; i < 3; ++i) path_place_[i] = path_place_[i - 1] + path_rows_[i - 1];
}

void IntervalBatch::find_curved() {
  const int m = 2 * count_of(members_.front()->feet());
  for (int i = 0; i < 3; ++i) {
    std::vector<char> curved(static_cast<std::size_t>(3 * n_ + n_u_ + m), 0);
    const auto mark = [&](const PathTerm& term) {
      if (!term.linear) for_read(term.reads, n_, n_u_, m, [&](int j) { curved[j] = 1; });
    };
    for (const Interval* member : members_)
      for (const PathRows& path : member->path)
        if (path.point == i) mark(*path.term);
    for (const IntegralCost& cost : costs_)
      if (weight(i) != 0.0) mark(*cost.term);

    for (int j = 0; j < count_of(curved); ++j)
      if (curved[j]) curved_[i].push_back(j);
  }
}

void IntervalBatch::path_values(VectorRef rows) {
  for (Interval* member : members_)
    for (const PathRows& path : member->path)
      path.term->evaluate(member->view(path.point),
                          rows.segment(path.row, count_of(path.term->rows)), nullptr, nullptr,
                          nullptr);
}

/// A member's Jacobian of a term by what it reads, into its lane of by_s and by_z from `row` on;
/// other places are zero for ever. Values are left in values_. The next row.
int IntervalBatch::pack_term(int i, int member, const PathTerm& term, int row,
                             MatrixOf<Lanes>& by_s, MatrixOf<Lanes>& by_z) {
  const int rows = count_of(term.rows), s = 2 * n_ + n_u_, m = count_of(points_[i].force);
  for_read(term.reads, n_, n_u_, m, [&](int j) { J_xi_.col(j).head(rows).setZero(); });
  term.evaluate(members_[member]->view(i), values_.head(rows), &J_xi_, nullptr, nullptr);

  for_read(term.reads, n_, n_u_, m, [&](int j) {
    for (int r = 0; r < rows; ++r)
      set_lane(j < s ? by_s(row + r, j) : by_z(row + r, j - s), member, J_xi_(r, j));
  });
  return row + rows;
}

/// by_s += by_z Z: most rows read few accelerations or forces.
void IntervalBatch::chain_forces(int i, const MatrixOf<Lanes>& by_z, MatrixOf<Lanes>& by_s) const {
  const MatrixOf<Lanes>& Z = points_[i].Z;
  for (int k = 0; k < Z.rows(); ++k) {
    for (int r = 0; r < by_z.rows(); ++r) {
      const Lanes factor = by_z(r, k);
      if (std::all_of(factor.value, factor.value + kLanes, [](double x) { return x == 0.0; }))
        continue;
      for (int j = 0; j < Z.cols(); ++j) by_s(r, j) += factor * Z(k, j);
    }
  }
}

void IntervalBatch::differentiate_path() {
  for (int i = 0; i < 3; ++i) {
    if (path_rows_[i] == 0) continue;
    by_s_[i].setZero();
    for (int k = 0; k < count_of(members_); ++k) {
      int row = 0;
      for (const PathRows& path : members_[k]->path)
        if (path.point == i) row = pack_term(i, k, *path.term, row, by_s_[i], by_z_[i]);
    }
    chain_forces(i, by_z_[i], by_s_[i]);
    by_variables(i, by_s_[i], path_w_.middleRows(path_place_[i], path_rows_[i]));
  }
}

double IntervalBatch::integral() {
  double total = 0.0;
  for (Interval* member : members_) {
    for (const IntegralCost& cost : costs_) {
      double sum = 0.0;
      for (int i = 0; i < 3; ++i) {
        if (weight(i) == 0.0) continue;
        cost.term->evaluate(member->view(i), values_.head(1), nullptr, nullptr, nullptr);
        sum += weight(i) * values_[0];
      }
      total += cost.weight * member->length() * sum;
    }
  }
  return total;
}

void IntervalBatch::add_integral_gradient(VectorOf<Lanes>& gradient_w) {
  for (const IntegralCost& cost : costs_) {
    for (int i = 0; i < 3; ++i) {
      if (weight(i) == 0.0) continue;
      chain_cost(i, cost);
      const double factor = cost.weight * weight(i);
      for (int j = 0; j < w_size_; ++j) gradient_w[j] += factor * h_ * cost_w_(0, j);
      gradient_w[w_size_ - 1] += factor * fraction_ * cost_value_;
    }
  }
}

/// The gradient of a cost's integrand at one point by w, and its value.
void IntervalBatch::chain_cost(int i, const IntegralCost& cost) {
  cost_s_.setZero();
  cost_z_.setZero();
  for (int k = 0; k < count_of(members_); ++k) {
    pack_term(i, k, *cost.term, 0, cost_s_, cost_z_);
    set_lane(cost_value_, k, values_[0]);
  }
  chain_forces(i, cost_z_, cost_s_);
  by_variables(i, cost_s_, cost_w_);
}

}  // namespace jaculus::transcription
