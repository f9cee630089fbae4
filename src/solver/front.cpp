#include "solver/front.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "jaculus/core/wide.h"

namespace jaculus::solver {
namespace {

constexpr double kZeroPivot = 1e-20;  // MA57's default

/// Upper triangle, column j: data += line * (scale * line_j), all j < count.
JACULUS_WIDE void add_rank_one(double* data, int stride, int count, const double* __restrict line,
                               double scale) {
  for (int j = 0; j < count; ++j) {
    const double factor = scale * line[j];
    if (factor == 0.0) continue;
    double* __restrict column = data + static_cast<std::size_t>(j) * stride;
    for (int i = 0; i <= j; ++i) column[i] += factor * line[i];
  }
}

/// The same of four lines at once: a column is read and written a quarter as often.
JACULUS_WIDE void add_rank_four(double* data, int stride, int count, const double* __restrict lines,
                                const double* scales) {
  const double* __restrict a = lines;
  const double* __restrict b = lines + count;
  const double* __restrict c = b + count;
  const double* __restrict d = c + count;
  for (int j = 0; j < count; ++j) {
    const double by_a = scales[0] * a[j], by_b = scales[1] * b[j], by_c = scales[2] * c[j],
                 by_d = scales[3] * d[j];
    if (by_a == 0.0 && by_b == 0.0 && by_c == 0.0 && by_d == 0.0) continue;
    double* __restrict column = data + static_cast<std::size_t>(j) * stride;
    for (int i = 0; i <= j; ++i) column[i] += by_a * a[i] + by_b * b[i] + by_c * c[i] + by_d * d[i];
  }
}

/// Upper triangle: data -= [p q] Dinv [p q]^T, all columns < count.
JACULUS_WIDE void subtract_rank_two(double* data, int stride, int count, const double* __restrict p,
                                    const double* __restrict q, double d11, double d21,
                                    double d22) {
  for (int j = 0; j < count; ++j) {
    const double by_p = d11 * p[j] + d21 * q[j], by_q = d21 * p[j] + d22 * q[j];
    if (by_p == 0.0 && by_q == 0.0) continue;
    double* __restrict column = data + static_cast<std::size_t>(j) * stride;
    for (int i = 0; i <= j; ++i) column[i] -= p[i] * by_p + q[i] * by_q;
  }
}

double largest(const double* values, int count, int but) {
  double most = 0.0;
  for (int i = 0; i < count; ++i)
    if (i != but) most = std::max(most, std::abs(values[i]));
  return most;
}

}  // namespace

void Front::clear(int size) {
  count_ = candidates_ = 0;
  unknown_.clear();
  place_.assign(static_cast<std::size_t>(size), -1);
  pivots_.clear();
  ids_.clear();
  columns_.clear();
}

void Front::reserve(int places) {
  if (places <= stride_) return;
  const int before = stride_;
  stride_ = (places + 15) / 8 * 8;
  std::vector<double> wider(static_cast<std::size_t>(stride_) * stride_, 0.0);
  for (int j = 0; j < count_; ++j)
    std::copy_n(data_.data() + static_cast<std::size_t>(j) * before, j + 1,
                wider.data() + static_cast<std::size_t>(j) * stride_);
  data_ = std::move(wider);
  spare_.assign(data_.size(), 0.0);
}

void Front::admit(const std::vector<int>& enter, const std::vector<int>& due,
                  const std::vector<char>& is_due) {
  // Order of places: present ones that stay, those that enter to stay, candidates.
  order_.clear();
  for (const int u : unknown_)
    if (!is_due[u]) order_.push_back(u);
  order_.insert(order_.end(), enter.begin(), enter.end());
  const std::size_t staying = order_.size();
  for (const int u : unknown_)
    if (is_due[u]) order_.push_back(u);
  for (const int u : due)
    if (place_[u] < 0) order_.push_back(u);

  const int places = static_cast<int>(order_.size());
  reserve(places);
  from_.resize(order_.size());
  for (int j = 0; j < places; ++j) from_[j] = place_[order_[j]];

  for (int j = 0; j < places; ++j) {
    double* to = spare_.data() + static_cast<std::size_t>(j) * stride_;
    const int from_j = from_[j];
    for (int i = 0; i <= j; ++i) {
      const int from_i = from_[i];
      to[i] = from_i < 0 || from_j < 0 ? 0.0
                                       : column(std::max(from_i, from_j))[std::min(from_i, from_j)];
    }
  }

  data_.swap(spare_);
  unknown_.swap(order_);
  for (int j = 0; j < places; ++j) place_[unknown_[j]] = j;
  count_ = places;
  candidates_ = places - static_cast<int>(staying);
}

void Front::add(int unknown_a, int unknown_b, double value) {
  const int a = place_[unknown_a], b = place_[unknown_b];
  column(std::max(a, b))[std::min(a, b)] += value;
}

void Front::add_squares(std::span<const double> lines, std::span<const double, kLines> scales) {
  assert(lines.size() == static_cast<std::size_t>(kLines * count_));
  add_rank_four(data_.data(), stride_, count_, lines.data(), scales.data());
}

void Front::swap(int a, int b) {
  if (a == b) return;
  if (a > b) std::swap(a, b);
  std::swap_ranges(column(a), column(a) + a, column(b));
  std::swap(column(a)[a], column(b)[b]);
  for (int k = a + 1; k < b; ++k) std::swap(column(k)[a], column(b)[k]);
  for (int k = b + 1; k < count_; ++k) std::swap(column(k)[a], column(k)[b]);
  std::swap(unknown_[a], unknown_[b]);
  std::swap(place_[unknown_[a]], place_[unknown_[b]]);
}

double Front::largest_beside(int p, int but) {
  double most = largest(column(p), p, but);
  for (int k = p + 1; k < count_; ++k)
    if (k != but) most = std::max(most, std::abs(column(k)[p]));
  return most;
}

/// The candidate that the last place is coupled with most, -1 where with none.
int Front::find_partner(int p) {
  int partner = -1;
  double most = 0.0;
  for (int k = count_ - candidates_; k < p; ++k) {
    if (std::abs(column(p)[k]) <= most) continue;
    most = std::abs(column(p)[k]);
    partner = k;
  }
  return partner;
}

bool Front::take_single(int p, double threshold) {
  const double size = std::abs(column(p)[p]);
  if (size <= kZeroPivot || size < threshold * largest_beside(p, p)) return false;
  swap(p, count_ - 1);
  eliminate_single();
  return true;
}

bool Front::take_pair(int p, int q, double threshold) {
  const double a = column(p)[p], b = column(std::max(p, q))[std::min(p, q)], c = column(q)[q];
  const double det = std::abs(a * c - b * b);
  if (det <= kZeroPivot * std::max(kZeroPivot, std::abs(b))) return false;
  const double by_p = largest_beside(p, q), by_q = largest_beside(q, p);
  if (threshold * (std::abs(c) * by_p + std::abs(b) * by_q) > det ||
      threshold * (std::abs(b) * by_p + std::abs(a) * by_q) > det)
    return false;
  if (q == count_ - 1) std::swap(p, q);
  swap(p, count_ - 1);
  swap(q, count_ - 2);
  eliminate_pair();
  return true;
}

/// Tries every candidate once, from the last to the first, the one at hand after those that came
/// before it in vain. A start from the last one after every pivot would look at what has no pivot
/// yet as often as there are pivots: most of the time of a fine mesh near its optimum.
bool Front::take_each(double threshold) {
  bool any = false;
  for (int p = count_ - 1; p >= count_ - candidates_; p = std::min(p, count_) - 1) {
    if (take_single(p, threshold)) {
      any = true;
      continue;
    }
    const int partner = find_partner(p);
    if (partner < 0) continue;
    any = take_pair(p, partner, threshold) || take_single(partner, threshold) || any;
  }
  return any;
}

Front::Outcome Front::eliminate(double threshold, bool all) {
  outcome_ = {};
  while (candidates_ > 0 && take_each(threshold)) {
  }
  if (all) outcome_.zero = candidates_;
  return outcome_;
}

/// Keeps the last columns, as many as the pivot has unknowns, and takes them from the front.
void Front::record(Pivot pivot) {
  const int width = pivot.second < 0 ? 1 : 2;
  pivot.length = count_ - width;
  pivot.ids = ids_.size();
  pivot.at = columns_.size();
  ids_.insert(ids_.end(), unknown_.begin(), unknown_.begin() + pivot.length);
  for (int k = 0; k < width; ++k) {
    const double* from = column(count_ - 1 - k);
    columns_.insert(columns_.end(), from, from + pivot.length);
    place_[unknown_[count_ - 1 - k]] = -1;
  }
  pivots_.push_back(pivot);
  unknown_.resize(static_cast<std::size_t>(pivot.length));
  count_ -= width;
  candidates_ -= width;
}

void Front::eliminate_single() {
  const double d = column(count_ - 1)[count_ - 1];
  outcome_.negative += d < 0.0 ? 1 : 0;
  record({.first = unknown_[count_ - 1], .d11 = 1.0 / d});
  add_rank_one(data_.data(), stride_, count_, columns_.data() + pivots_.back().at, -1.0 / d);
}

void Front::eliminate_pair() {
  const int p = count_ - 1, q = count_ - 2;
  const double a = column(p)[p], b = column(p)[q], c = column(q)[q], det = a * c - b * b;
  outcome_.negative += det < 0.0 ? 1 : (a < 0.0 ? 2 : 0);
  record({.first = unknown_[p],
          .second = unknown_[q],
          .d11 = c / det,
          .d21 = -b / det,
          .d22 = a / det});
  const Pivot& pivot = pivots_.back();
  const double* columns = columns_.data() + pivot.at;
  subtract_rank_two(data_.data(), stride_, count_, columns, columns + pivot.length, pivot.d11,
                    pivot.d21, pivot.d22);
}

void Front::reduce(std::span<double> rhs) const {
  for (const Pivot& pivot : pivots_) {
    const int* ids = ids_.data() + pivot.ids;
    const double* p = columns_.data() + pivot.at;
    const double r = rhs[pivot.first];

    if (pivot.second < 0) {
      const double z = pivot.d11 * r;
      rhs[pivot.first] = z;
      for (int i = 0; i < pivot.length; ++i) rhs[ids[i]] -= p[i] * z;
    } else {
      const double* q = p + pivot.length;
      const double s = rhs[pivot.second];
      const double z = pivot.d11 * r + pivot.d21 * s, w = pivot.d21 * r + pivot.d22 * s;
      rhs[pivot.first] = z;
      rhs[pivot.second] = w;
      for (int i = 0; i < pivot.length; ++i) rhs[ids[i]] -= p[i] * z + q[i] * w;
    }
  }
}

void Front::restore(std::span<double> rhs) const {
  for (auto at = pivots_.rbegin(); at != pivots_.rend(); ++at) {
    const Pivot& pivot = *at;
    const int* ids = ids_.data() + pivot.ids;
    const double* p = columns_.data() + pivot.at;
    const double* q = p + (pivot.second < 0 ? 0 : pivot.length);

    double by_p = 0.0, by_q = 0.0;
    for (int i = 0; i < pivot.length; ++i) {
      by_p += p[i] * rhs[ids[i]];
      by_q += q[i] * rhs[ids[i]];
    }
    if (pivot.second < 0) {
      rhs[pivot.first] -= pivot.d11 * by_p;
    } else {
      rhs[pivot.first] -= pivot.d11 * by_p + pivot.d21 * by_q;
      rhs[pivot.second] -= pivot.d21 * by_p + pivot.d22 * by_q;
    }
  }
}

}  // namespace jaculus::solver
