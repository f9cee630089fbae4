// Hessian of the Lagrangian: every entry once, shared by the intervals and terms that touch it.

#include <map>

#include "jaculus/transcription/nonlinear_program.h"

namespace jaculus::transcription {

namespace {

/// Gives every (row, column) of the lower triangle one place.
class Places {
 public:
  explicit Places(Sparsity& sparsity) : sparsity_(sparsity) {}
  int at(int i, int j) {
    const std::pair<int, int> key = std::minmax(i, j);
    const auto [it, fresh] = places_.try_emplace(key, sparsity_.size());
    if (fresh) {
      sparsity_.rows.push_back(key.second);
      sparsity_.columns.push_back(key.first);
    }
    return it->second;
  }

 private:
  Sparsity& sparsity_;
  std::map<std::pair<int, int>, int> places_;
};

std::vector<int> node_places(const NodeTerm& term, Places& places) {
  std::vector<int> at;
  if (term.linear) return at;
  for (std::size_t i = 0; i < term.columns.size(); ++i)
    for (std::size_t j = 0; j <= i; ++j) at.push_back(places.at(term.columns[i], term.columns[j]));
  return at;
}

/// Adds the lower triangle of H; columns that occur twice in one term are not allowed, so no entry
/// is halved.
void scatter(const std::vector<int>& places, const Matrix& H, double factor, VectorRef values) {
  std::size_t at = 0;
  for (int i = 0; i < H.rows(); ++i) {
    for (int j = 0; j <= i; ++j, ++at) {
      if (places[at] >= 0) values[places[at]] += factor * H(i, j);
    }
  }
}

void scatter_lane(const std::vector<int>& places, const MatrixOf<Lanes>& H, int at,
                  VectorRef values) {
  std::size_t place = 0;
  for (int j = 0; j < H.cols(); ++j) {
    for (int i = j; i < H.rows(); ++i, ++place) {
      if (places[place] >= 0) values[places[place]] += lane(H(i, j), at);
    }
  }
}

}  // namespace

void NonlinearProgram::find_hessian_pattern() {
  Places places(hessian_);
  for (const Interval& interval : intervals_) {
    const std::vector<char> mask = dynamic_columns(interval);
    std::vector<int> at;
    for (int j = 0; j < interval.size(); ++j) {
      for (int i = j; i < interval.size(); ++i) {
        const std::size_t a = i, b = j;
        at.push_back(mask[a] && mask[b] ? places.at(interval.columns[a], interval.columns[b]) : -1);
      }
    }
    interval_hessian_at_.push_back(std::move(at));
  }
  for (NodeEntry& entry : node_rows_) entry.hessian_at = node_places(entry.term, places);
  for (NodeEntry& entry : node_costs_) entry.hessian_at = node_places(entry.term, places);
}

bool NonlinearProgram::hessian(const ConstVectorRef& x, double sigma, const ConstVectorRef& lambda,
                               VectorRef values) {
  if (!update(x, 2)) return false;
  values.setZero();

  for (std::size_t b = 0; b < batches_.size(); ++b) {
    const MatrixOf<Lanes>& H = batches_[b].hessian(lambda, sigma);
    for (int k = 0; k < count_of(batches_[b].members()); ++k)
      scatter_lane(interval_hessian_at_[batch_begin_[b] + k], H, k, values);
  }

  for (NodeEntry& entry : node_rows_) {
    if (entry.term.linear) continue;
    const ConstVectorRef multipliers = lambda.segment(entry.row, entry.value.size());
    if (!evaluate(entry, x, true, &multipliers)) return false;
    scatter(entry.hessian_at, entry.H, 1.0, values);
  }

  for (NodeEntry& entry : node_costs_) {
    if (entry.term.linear) continue;
    const Eigen::Matrix<double, 1, 1> weight(sigma * entry.weight);
    const ConstVectorRef multipliers(weight);
    if (!evaluate(entry, x, true, &multipliers)) return false;
    scatter(entry.hessian_at, entry.H, 1.0, values);
  }

  return true;
}

}  // namespace jaculus::transcription
