#include "jaculus/transcription/interval.h"

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

  for (Vector& u : u_) {
    points_.emplace_back(equations, phase.feet);
    u = Vector::Zero(n_u_);
  }
  w_ = Vector::Zero(size());
  x_middle_ = Vector::Zero(2 * n_);
}

bool Interval::evaluate(const ConstVectorRef& x) {
  for (int i = 0; i < size(); ++i) w_[i] = x[columns[i]];
  h_ = fraction_ * w_[size() - 1];
  u_[0] = w_.segment(4 * n_, n_u_);
  u_[2] = w_.segment(held_ ? 4 * n_ : 4 * n_ + n_u_, n_u_);
  u_[1] = 0.5 * (u_[0] + u_[2]);

  const auto at = [&](int i, const ConstVectorRef& state) {
    return equations_.evaluate(state.head(n_), state.tail(n_), u_[i], points_[i]);
  };
  if (!at(0, w_.head(2 * n_)) || !at(2, w_.segment(2 * n_, 2 * n_))) return false;
  if (!has_middle()) return true;

  x_middle_ = 0.5 * (w_.head(2 * n_) + w_.segment(2 * n_, 2 * n_));
  x_middle_.head(n_) += h_ / 8.0 * (points_[0].v - points_[2].v);
  x_middle_.tail(n_) += h_ / 8.0 * (points_[0].a - points_[2].a);
  return at(1, x_middle_);
}

}  // namespace jaculus::transcription
