#include "solver/frontal.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace jaculus::solver {

FrontalFactorization::FrontalFactorization(SymmetricPattern pattern, const EliminationOrder& order)
    : pattern_(std::move(pattern)) {
  groups_.resize(static_cast<std::size_t>(order.groups));
  for (const SlackRow& row : order.slack_rows) {
    SlackEntries& entries = slack_rows_.emplace_back();
    entries.of = row;
    entries.group = order.group[row.row];
    groups_[entries.group].slack_rows.push_back(static_cast<int>(slack_rows_.size()) - 1);
  }
  place_entries(order);
  place_entrances(order);
}

/// An entry is added with the first group that eliminates one of its unknowns.
void FrontalFactorization::place_entries(const EliminationOrder& order) {
  std::vector<int> row_of(static_cast<std::size_t>(pattern_.size), -1);
  for (int k = 0; k < static_cast<int>(slack_rows_.size()); ++k)
    row_of[slack_rows_[k].of.row] = row_of[slack_rows_[k].of.slack] = k;

  for (int k = 0; k < static_cast<int>(pattern_.rows.size()); ++k) {
    int i = pattern_.rows[k], j = pattern_.columns[k];
    if (row_of[i] < 0 && row_of[j] < 0) {
      groups_[std::min(order.group[i], order.group[j])].entries.push_back({k, i, j});
      continue;
    }
    if (row_of[i] < 0) std::swap(i, j);
    SlackEntries& row = slack_rows_[row_of[i]];
    if (i == j) {
      (i == row.of.slack ? row.sigma : row.e).push_back(k);
    } else if (j == row.of.slack || i == row.of.slack) {
      assert(row_of[i] == row_of[j]);
      row.b.push_back(k);
    } else {
      row.a.push_back({k, i, j});
    }
  }
}

/// Who enters the front with which group, and how wide it becomes.
void FrontalFactorization::place_entrances(const EliminationOrder& order) {
  std::vector<char> in_pair(static_cast<std::size_t>(pattern_.size), 0);
  for (const SlackEntries& row : slack_rows_) in_pair[row.of.slack] = in_pair[row.of.row] = 1;
  for (int u = 0; u < pattern_.size; ++u)
    if (!in_pair[u]) groups_[order.group[u]].own.push_back(u);

  std::vector<char> present(static_cast<std::size_t>(pattern_.size), 0);
  int front = 0;
  for (int g = 0; g < order.groups; ++g) {
    Group& group = groups_[g];
    const auto touch = [&](int u) {
      if (present[u]) return;
      present[u] = 1;
      ++front;
      if (order.group[u] != g) group.enter.push_back(u);
    };
    for (const int u : group.own) touch(u);
    for (const Entry& e : group.entries) {
      touch(e.row);
      touch(e.column);
    }
    for (const int k : group.slack_rows)
      for (const Entry& e : slack_rows_[k].a) touch(e.column);
    widest_ = std::max(widest_, front);
    front -= static_cast<int>(group.own.size());
  }
}

void FrontalFactorization::read_slack_row(SlackEntries& row, std::span<const double> values) const {
  const auto sum = [&](const std::vector<int>& places) {
    double total = 0.0;
    for (const int k : places) total += values[k];
    return total;
  };
  row.s = sum(row.sigma);
  row.off = sum(row.b);
  row.ee = sum(row.e);
  row.weights.resize(row.a.size());
  for (std::size_t k = 0; k < row.a.size(); ++k) row.weights[k] = values[row.a[k].value];

  // A pair adds sigma a a^T; beyond this it would hide what the other rows add, half the digits.
  constexpr double kSwamps = 1e8;
  row.paired = std::abs(row.s) <= kSwamps * row.off * row.off;
}

/// Adds what the pair leaves behind, or its row.
void FrontalFactorization::add_slack_row(SlackEntries& row) {
  const double det = row.s * row.ee - row.off * row.off;
  if (!row.paired) {
    inertia_.negative += row.s < 0.0 ? 1 : 0;
    front_.add(row.of.row, row.of.row, det / row.s);
    for (std::size_t k = 0; k < row.a.size(); ++k)
      front_.add(row.of.row, row.a[k].column, row.weights[k]);
    return;
  }

  if (det == 0.0) ++inertia_.zero;
  inertia_.negative += det < 0.0 ? 1 : (row.s < 0.0 ? 2 : 0);
  double* line = lines_.data() + static_cast<std::ptrdiff_t>(waiting_) * front_.count();
  for (std::size_t k = 0; k < row.a.size(); ++k)
    line[front_.place(row.a[k].column)] += row.weights[k];
  scales_[waiting_++] = -row.s / det;
  if (waiting_ == Front::kLines) add_lines();
}

/// Adds the lines that wait; what is missing to all is zero.
void FrontalFactorization::add_lines() {
  if (waiting_ > 0) front_.add_squares(lines_, scales_);
  lines_.assign(static_cast<std::size_t>(Front::kLines) * front_.count(), 0.0);
  scales_ = {};
  waiting_ = 0;
}

void FrontalFactorization::add_group(Group& group, std::span<const double> values) {
  std::vector<int> due = group.own;
  for (const int k : group.slack_rows) {
    read_slack_row(slack_rows_[k], values);
    if (!slack_rows_[k].paired) due.push_back(slack_rows_[k].of.row);
  }
  for (const int u : due) is_due_[u] = 1;
  front_.admit(group.enter, due, is_due_);
  for (const Entry& e : group.entries) front_.add(e.row, e.column, values[e.value]);
  add_lines();
  for (const int k : group.slack_rows) add_slack_row(slack_rows_[k]);
  add_lines();
}

Inertia FrontalFactorization::factorize(std::span<const double> values, double threshold) {
  inertia_ = {};
  front_.clear(pattern_.size);
  is_due_.assign(static_cast<std::size_t>(pattern_.size), 0);
  for (Group& group : groups_) {
    add_group(group, values);
    const Front::Outcome outcome = front_.eliminate(threshold, &group == &groups_.back());
    inertia_.negative += outcome.negative;
    inertia_.zero += outcome.zero;
  }
  return inertia_;
}

/// Takes what is known of the pair from the right-hand sides of the unknowns x that it meets.
void FrontalFactorization::reduce_slack(const SlackEntries& row, std::span<double> rhs) const {
  double& r_s = rhs[row.of.slack];
  double& r_y = rhs[row.of.row];
  if (!row.paired) {
    r_y -= row.off * (r_s / row.s);
    return;
  }
  const double y = (row.s * r_y - row.off * r_s) / (row.s * row.ee - row.off * row.off);
  for (std::size_t k = 0; k < row.a.size(); ++k) rhs[row.a[k].column] -= row.weights[k] * y;
}

void FrontalFactorization::restore_slack(const SlackEntries& row, std::span<double> rhs) const {
  double& r_s = rhs[row.of.slack];
  double& r_y = rhs[row.of.row];
  if (!row.paired) {
    r_s = (r_s - row.off * r_y) / row.s;
    return;
  }
  for (std::size_t k = 0; k < row.a.size(); ++k) r_y -= row.weights[k] * rhs[row.a[k].column];
  const double det = row.s * row.ee - row.off * row.off, before = r_s;
  r_s = (row.ee * before - row.off * r_y) / det;
  r_y = (row.s * r_y - row.off * before) / det;
}

void FrontalFactorization::solve(std::span<double> rhs) const {
  for (const SlackEntries& row : slack_rows_) reduce_slack(row, rhs);
  front_.reduce(rhs);
  front_.restore(rhs);
  for (const SlackEntries& row : slack_rows_) restore_slack(row, rhs);
}

}  // namespace jaculus::solver
