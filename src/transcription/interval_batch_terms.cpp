// Path rows and integral costs: functions of one point, taken lane by lane.

#include "jaculus/core/small_product.h"
#include "jaculus/transcription/interval_batch.h"

namespace jaculus::transcription {

void IntervalBatch::path_values(VectorRef rows) {
  for (Interval* member : members_)
    for (const PathRows& path : member->path)
      path.term->evaluate(member->view(path.point),
                          rows.segment(path.row, count_of(path.term->rows)), nullptr, nullptr,
                          nullptr);
}

/// A member's Jacobian of a term by what it reads, into its lane of by_s_ and by_z_ from `row` on.
/// Values are left in values_. The next row.
int IntervalBatch::pack_term(int i, int member, const PathTerm& term, int row) {
  const int rows = count_of(term.rows), s = 2 * n_ + n_u_;
  J_xi_.topRows(rows).setZero();
  term.evaluate(members_[member]->view(i), values_.head(rows), &J_xi_, nullptr, nullptr);

  for (int j = 0; j < s; ++j)
    for (int r = 0; r < rows; ++r) set_lane(by_s_(row + r, j), member, J_xi_(r, j));
  if (term.reads.dynamics())
    for (int j = s; j < J_xi_.cols(); ++j)
      for (int r = 0; r < rows; ++r) set_lane(by_z_(row + r, j - s), member, J_xi_(r, j));
  return row + rows;
}

/// by_s_ += by_z_ Z: most rows read few accelerations or forces.
void IntervalBatch::chain_forces(int i, int rows) {
  const MatrixOf<Lanes>& Z = points_[i].Z;
  for (int k = 0; k < Z.rows(); ++k) {
    for (int r = 0; r < rows; ++r) {
      const Lanes factor = by_z_(r, k);
      bool zero = true;
      for (int l = 0; l < kLanes; ++l) zero = zero && lane(factor, l) == 0.0;
      if (zero) continue;
      for (int j = 0; j < Z.cols(); ++j) by_s_(r, j) += factor * Z(k, j);
    }
  }
}

void IntervalBatch::differentiate_path() {
  // Rows of a member stand in the order of its path, those of a point together for the product.
  for (int i = 0; i < 3; ++i) {
    if (path_rows_[i] == 0) continue;
    by_s_.setZero();
    by_z_.setZero();
    for (int k = 0; k < count_of(members_); ++k) {
      int row = 0;
      for (const PathRows& path : members_[k]->path)
        if (path.point == i) row = pack_term(i, k, *path.term, row);
    }
    chain_forces(i, path_rows_[i]);
    by_variables(i, by_s_.topRows(path_rows_[i]),
                 path_w_.middleRows(path_place_[i], path_rows_[i]));
  }
}

double IntervalBatch::integral(const IntegralCost& cost) {
  double total = 0.0;
  for (Interval* member : members_) {
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) {
      if (weight(i) == 0.0) continue;
      cost.term->evaluate(member->view(i), values_.head(1), nullptr, nullptr, nullptr);
      sum += weight(i) * values_[0];
    }
    total += cost.weight * member->length() * sum;
  }
  return total;
}

void IntervalBatch::add_integral_gradient(const IntegralCost& cost, VectorOf<Lanes>& gradient_w) {
  for (int i = 0; i < 3; ++i) {
    if (weight(i) == 0.0) continue;
    chain_cost(i, cost);
    const double factor = cost.weight * weight(i);
    for (int j = 0; j < w_size_; ++j) gradient_w[j] += factor * h_ * cost_w_(0, j);
    gradient_w[w_size_ - 1] += factor * fraction_ * cost_value_;
  }
}

/// The gradient of a cost's integrand at one point by w, and its value.
void IntervalBatch::chain_cost(int i, const IntegralCost& cost) {
  by_s_.topRows(1).setZero();
  by_z_.topRows(1).setZero();
  for (int k = 0; k < count_of(members_); ++k) {
    pack_term(i, k, *cost.term, 0);
    set_lane(cost_value_, k, values_[0]);
  }
  chain_forces(i, 1);
  by_variables(i, by_s_.topRows(1), cost_w_);
}

}  // namespace jaculus::transcription
