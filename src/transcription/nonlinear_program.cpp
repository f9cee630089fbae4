#include "jaculus/transcription/nonlinear_program.h"

#include <fmt/format.h>

#include "transcription/redundancy.h"

namespace jaculus::transcription {

namespace {

/// "all_feet, node 12" or "all_feet, node 12.5" for the middle of an interval.
std::string point_name(const PhaseBlock& phase, int interval, int point, bool held_end) {
  const std::string number =
      point == 1 ? fmt::format("{}.5", interval) : fmt::format("{}", interval + point / 2);
  return fmt::format("{}, node {}{}: ", phase.name, number, held_end ? " (end of interval)" : "");
}

}  // namespace

NonlinearProgram::NonlinearProgram(const Problem& problem, const model::PlanarModel& model)
    : problem_(problem),
      equations_(std::make_unique<components::Equations>(model)),
      layout_(make_layout(problem_, *equations_)) {
  TermContext context = make_terms(problem_, *equations_, layout_);
  notes_ = context.notes;
  for (const std::string& note : remove_redundant_rows(context)) notes_.push_back(note);
  sign_ = problem.maximise ? -1.0 : 1.0;

  path_terms_ = context.path;
  for (const NodeTerm& term : context.node_rows) node_rows_.emplace_back(term);
  for (const auto& [term, weight] : context.node_costs) {
    node_costs_.emplace_back(term);
    node_costs_.back().weight = sign_ * weight;
  }
  for (const auto& [term, weight] : context.integral_costs) integral_terms_.push_back(term);
  for (std::size_t i = 0; i < integral_terms_.size(); ++i)
    integral_costs_.push_back({&integral_terms_[i], sign_ * context.integral_costs[i].second});

  intervals_.reserve(layout_.intervals.size());
  for (const IntervalBlock& block : layout_.intervals)
    intervals_.emplace_back(*equations_, layout_, block, problem_.transcription.scheme);

  place_rows();
  make_batches();
  find_sparsity();
  find_hessian_pattern();

  x_ = Vector::Constant(variables(), kNaN);
  gradient_w_ = VectorOf<Lanes>::Constant(intervals_.front().size(), 0.0);
}

/// Intervals of a phase by fours.
void NonlinearProgram::make_batches() {
  for (const PhaseBlock& phase : layout_.phases) {
    for (int k = phase.first_interval; k <= phase.last_interval; k += kLanes) {
      std::vector<Interval*> members;
      for (int i = k; i <= std::min(k + kLanes - 1, phase.last_interval); ++i)
        members.push_back(&intervals_[i]);
      batch_begin_.push_back(k);
      batches_.emplace_back(*equations_, layout_, std::move(members), integral_costs_);
    }
  }
}

int NonlinearProgram::add_row(const RowSpec& row) {
  rows_.push_back(row);
  return rows() - 1;
}

void NonlinearProgram::place_rows() {
  for (std::size_t k = 0; k < intervals_.size(); ++k) {
    const IntervalBlock& block = layout_.intervals[k];
    const PhaseBlock& phase = layout_.phases[block.phase];
    Interval& interval = intervals_[k];
    interval.defect_row = rows();
    for (int i = 0; i < 2 * layout_.n; ++i) {
      const model::Coordinate& c = equations_->model().coordinates[i % layout_.n];
      const bool rate = i >= layout_.n;
      const std::string unit = std::string(c.angular ? "rad" : "m") + (rate ? "/s" : "");
      const double scale = layout_.scale[layout_.nodes.front().q + i];
      add_row({fmt::format("{}, interval {}: defect of {}{}", phase.name, block.number, c.name,
                           rate ? " velocity" : ""),
               unit,
               {0.0, 0.0},
               0.1 * scale});
    }
    place_path_rows(interval, block);
  }

  for (NodeEntry& entry : node_rows_) {
    entry.row = rows();
    for (const RowSpec& row : entry.term.rows) add_row(row);
  }

  row_lower_.resize(rows());
  row_upper_.resize(rows());
  row_scale_.resize(rows());
  for (int i = 0; i < rows(); ++i) {
    row_lower_[i] = rows_[i].bounds.lower;
    row_upper_[i] = rows_[i].bounds.upper;
    row_scale_[i] = rows_[i].scale;
  }
}

void NonlinearProgram::place_path_rows(Interval& interval, const IntervalBlock& block) {
  const PhaseBlock& phase = layout_.phases[block.phase];
  const bool middle = interval.has_middle();
  const bool last = block.number == phase.last_interval - phase.first_interval;

  for (const PathTerm& term : path_terms_[block.phase]) {
    for (int point = 0; point < 3; ++point) {
      if (point == 1 && !middle) continue;
      // the next interval's start is the same node with another input
      const bool extra_end = point == 2 && !last;
      if (extra_end && !(problem_.transcription.check_interval_end && term.reads.held())) continue;
      if (term.only_last && (!last || point != 2)) continue;
      if (!term.holds_at(block.begin + 0.5 * point * block.fraction)) continue;

      PathRows rows{&term, point, this->rows()};
      for (RowSpec row : term.rows) {
        row.name = point_name(phase, block.number, point, extra_end) + row.name;
        add_row(row);
      }
      interval.path.push_back(rows);
    }
  }
}

std::vector<char> NonlinearProgram::dynamic_columns(const Interval& interval) const {
  std::vector<char> mask(interval.size(), 1);
  for (int c : equations_->tree().cyclic) {
    mask[c] = 0;
    mask[2 * layout_.n + c] = 0;
  }
  return mask;
}

std::vector<char> NonlinearProgram::path_pattern(const Interval& interval,
                                                 const PathRows& rows) const {
  const Reads& reads = rows.term->reads;
  const int n = layout_.n, w = interval.size();
  std::vector<char> mask(w, 0);
  if (rows.point == 1) {
    mask = dynamic_columns(interval);
    if (reads.position)
      for (int c : equations_->tree().cyclic) mask[c] = mask[2 * n + c] = 1;
    return mask;
  }

  const std::vector<char> dynamic = dynamic_columns(interval);
  const int x = rows.point == 0 ? 0 : 2 * n;
  const int u = rows.point == 0 || layout_.held ? 4 * n : 4 * n + layout_.n_u;

  for (int i = 0; i < n; ++i) {
    const std::size_t at = x + i;
    mask[at] = reads.position || (reads.dynamics() && dynamic[at]);
    mask[at + n] = reads.velocity || reads.dynamics();
  }
  for (int i = 0; i < layout_.n_u; ++i) mask[u + i] = reads.held();
  return mask;
}

void NonlinearProgram::find_sparsity() {
  const int n = layout_.n;
  for (Interval& interval : intervals_) {
    std::vector<std::vector<char>> patterns;
    for (int i = 0; i < 2 * n; ++i) {
      const bool coupled = interval.has_middle() || i >= n;
      std::vector<char> mask =
          coupled ? dynamic_columns(interval) : std::vector<char>(interval.size());
      for (int at : {i, 2 * n + i}) mask[at] = 1;
      if (!coupled) {
        for (int at : {n + i, 3 * n + i, interval.size() - 1}) mask[at] = 1;
      }
      patterns.push_back(mask);
    }

    for (const PathRows& rows : interval.path) patterns.push_back(path_pattern(interval, rows));
    jacobian_at_.push_back(jacobian_.size());
    std::vector<std::vector<int>>& read = patterns_.emplace_back();
    for (const std::vector<char>& mask : patterns) {
      std::vector<int>& columns = read.emplace_back();
      for (int j = 0; j < count_of(mask); ++j)
        if (mask[j]) columns.push_back(j);
    }

    const auto put = [&](int row, const std::vector<int>& columns) {
      for (const int j : columns) {
        jacobian_.rows.push_back(row);
        jacobian_.columns.push_back(interval.columns[j]);
      }
    };
    for (int i = 0; i < 2 * n; ++i) put(interval.defect_row + i, read[i]);
    for (std::size_t k = 0; k < interval.path.size(); ++k)
      for (int i = 0; i < count_of(interval.path[k].term->rows); ++i)
        put(interval.path[k].row + i, read[2 * n + k]);
  }

  jacobian_nodes_at_ = jacobian_.size();
  for (const NodeEntry& entry : node_rows_) {
    for (int i = 0; i < count_of(entry.term.rows); ++i) {
      for (int column : entry.term.columns) {
        jacobian_.rows.push_back(entry.row + i);
        jacobian_.columns.push_back(column);
      }
    }
  }
}

bool NonlinearProgram::update(const ConstVectorRef& x, int level) {
  if (level_ == 0 || (x_.array() != x.array()).any()) {
    x_ = x;
    level_ = 1;
    defined_ = true;
    for (IntervalBatch& batch : batches_) defined_ = defined_ && batch.evaluate(x);
  }
  if (!defined_) return false;
  if (level >= 2 && level_ < 2) {
    for (IntervalBatch& batch : batches_) batch.differentiate();
    level_ = 2;
  }
  return true;
}

bool NonlinearProgram::evaluate_at(const ConstVectorRef& x) {
  level_ = 0;  // the batches' lanes may be of another point from here on
  return std::all_of(intervals_.begin(), intervals_.end(),
                     [&](Interval& interval) { return interval.evaluate(x); });
}

std::vector<NonlinearProgram::PlacedRows> NonlinearProgram::node_rows() const {
  std::vector<PlacedRows> placed;
  for (const NodeEntry& entry : node_rows_) placed.push_back({&entry.term, entry.row});
  return placed;
}

NonlinearProgram::NodeEntry::NodeEntry(NodeTerm of)
    : term(std::move(of)),
      y(Vector::Zero(term.columns.size())),
      value(Vector::Zero(term.rows.size())),
      J(Matrix::Zero(value.size(), y.size())),
      H(Matrix::Zero(y.size(), y.size())) {}

/// Values; J where `first`; H, weighted, where multipliers are given.
bool NonlinearProgram::evaluate(NodeEntry& entry, const ConstVectorRef& x, bool first,
                                const ConstVectorRef* multipliers) {
  for (Eigen::Index i = 0; i < entry.y.size(); ++i) entry.y[i] = x[entry.term.columns[i]];
  if (first) entry.J.setZero();
  if (multipliers) entry.H.setZero();
  return entry.term.evaluate(entry.y, entry.value, first ? &entry.J : nullptr, multipliers,
                             multipliers ? &entry.H : nullptr);
}

bool NonlinearProgram::objective(const ConstVectorRef& x, double& value) {
  value = 0.0;
  for (NodeEntry& entry : node_costs_) {
    if (!evaluate(entry, x, false, nullptr)) return false;
    value += entry.weight * entry.value[0];
  }
  if (integral_costs_.empty()) return true;
  if (!update(x, 1)) return false;
  for (IntervalBatch& batch : batches_) value += batch.integral();
  return true;
}

bool NonlinearProgram::gradient(const ConstVectorRef& x, VectorRef gradient) {
  gradient.setZero();
  for (NodeEntry& entry : node_costs_) {
    if (!evaluate(entry, x, true, nullptr)) return false;
    for (int i = 0; i < count_of(entry.term.columns); ++i)
      gradient[entry.term.columns[i]] += entry.weight * entry.J(0, i);
  }
  if (integral_costs_.empty()) return true;
  if (!update(x, 2)) return false;
  for (IntervalBatch& batch : batches_) {
    gradient_w_.setZero();
    batch.add_integral_gradient(gradient_w_);
    for (int k = 0; k < count_of(batch.members()); ++k)
      for (int i = 0; i < batch.size(); ++i)
        gradient[batch.members()[k]->columns[i]] += lane(gradient_w_[i], k);
  }
  return true;
}

bool NonlinearProgram::constraints(const ConstVectorRef& x, VectorRef values) {
  if (!update(x, 1)) return false;
  for (IntervalBatch& batch : batches_) {
    batch.defects(values);
    batch.path_values(values);
  }
  for (NodeEntry& entry : node_rows_) {
    if (!evaluate(entry, x, false, nullptr)) return false;
    values.segment(entry.row, entry.value.size()) = entry.value;
  }
  return true;
}

/// Defect rows of all members at once: they read the same local variables.
void NonlinearProgram::put_defects(const IntervalBatch& batch, int first, VectorRef values) const {
  const int members = count_of(batch.members());
  std::array<double*, kLanes> at{};
  for (int k = 0; k < members; ++k) at[k] = values.data() + jacobian_at_[first + k];

  for (int i = 0; i < 2 * layout_.n; ++i) {
    for (const int j : patterns_[first][i]) {
      const Lanes& value = batch.defect_jacobian()(i, j);
      for (int k = 0; k < members; ++k) *at[k]++ = lane(value, k);
    }
  }
}

void NonlinearProgram::put_path(const IntervalBatch& batch, int first, VectorRef values) const {
  const int defects = 2 * layout_.n;
  for (int k = 0; k < count_of(batch.members()); ++k) {
    const Interval& interval = *batch.members()[k];
    const std::vector<std::vector<int>>& read = patterns_[first + k];
    int at = jacobian_at_[first + k];
    for (int i = 0; i < defects; ++i) at += count_of(read[i]);

    std::array<int, 3> row{batch.path_place(0), batch.path_place(1), batch.path_place(2)};
    for (std::size_t t = 0; t < interval.path.size(); ++t) {
      for (int i = 0; i < count_of(interval.path[t].term->rows); ++i) {
        const int from = row[interval.path[t].point]++;
        for (const int j : read[defects + t])
          values[at++] = lane(batch.path_jacobian()(from, j), k);
      }
    }
  }
}

bool NonlinearProgram::jacobian(const ConstVectorRef& x, VectorRef values) {
  if (!update(x, 2)) return false;
  for (std::size_t b = 0; b < batches_.size(); ++b) {
    put_defects(batches_[b], batch_begin_[b], values);
    put_path(batches_[b], batch_begin_[b], values);
  }

  int at = jacobian_nodes_at_;
  for (NodeEntry& entry : node_rows_) {
    if (!evaluate(entry, x, true, nullptr)) return false;
    for (int i = 0; i < entry.J.rows(); ++i)
      for (int j = 0; j < entry.J.cols(); ++j) values[at++] = entry.J(i, j);
  }

  return true;
}

}  // namespace jaculus::transcription
