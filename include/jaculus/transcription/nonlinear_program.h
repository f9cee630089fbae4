#pragma once
// A problem transcribed into a nonlinear program: intervals and terms put together, with sparsity
// from what they declare to read.

#include <memory>

#include "jaculus/transcription/interval_batch.h"
#include "jaculus/transcription/nlp.h"

namespace jaculus::transcription {

/// A problem made executable. Owns its equations; one thread at a time may evaluate it.
class NonlinearProgram : public Nlp {
 public:
  /// Validates the problem against its robot and lays it out. InputError with file:line where they
  /// do not fit.
  explicit NonlinearProgram(const Problem& problem, const model::PlanarModel& model);

  [[nodiscard]] int variables() const override { return layout_.columns(); }
  [[nodiscard]] int rows() const override { return count_of(rows_); }
  [[nodiscard]] const Vector& variable_lower() const override { return layout_.lower; }
  [[nodiscard]] const Vector& variable_upper() const override { return layout_.upper; }
  [[nodiscard]] const Vector& row_lower() const override { return row_lower_; }
  [[nodiscard]] const Vector& row_upper() const override { return row_upper_; }
  [[nodiscard]] const Vector& variable_scale() const override { return layout_.scale; }
  [[nodiscard]] const Vector& row_scale() const override { return row_scale_; }
  [[nodiscard]] double objective_scale() const override { return 1.0; }
  [[nodiscard]] std::string variable_name(int column) const override {
    return layout_.names[column];
  }
  [[nodiscard]] std::string row_name(int row) const override { return rows_[row].name; }
  [[nodiscard]] std::string variable_unit(int column) const override {
    return layout_.units[column];
  }
  [[nodiscard]] std::string row_unit(int row) const override { return rows_[row].unit; }
  [[nodiscard]] const Sparsity& jacobian_sparsity() const override { return jacobian_; }
  [[nodiscard]] const Sparsity& hessian_sparsity() const override { return hessian_; }

  bool objective(const ConstVectorRef& x, double& value) override;
  bool gradient(const ConstVectorRef& x, VectorRef gradient) override;
  bool constraints(const ConstVectorRef& x, VectorRef values) override;
  bool jacobian(const ConstVectorRef& x, VectorRef values) override;
  bool hessian(const ConstVectorRef& x, double sigma, const ConstVectorRef& lambda,
               VectorRef values) override;

  [[nodiscard]] const Problem& problem() const { return problem_; }
  [[nodiscard]] const components::Equations& equations() const { return *equations_; }
  [[nodiscard]] const Layout& layout() const { return layout_; }
  [[nodiscard]] const std::vector<Interval>& intervals() const { return intervals_; }
  /// Path constraints by phase, in the order of the problem.
  [[nodiscard]] const std::vector<std::vector<PathTerm>>& path_terms() const { return path_terms_; }
  /// The intervals with all points evaluated at x; false where the equations are not defined there.
  bool evaluate_at(const ConstVectorRef& x);
  /// Rows of a node term and where they begin in the program.
  struct PlacedRows {
    const NodeTerm* term;
    int row;
  };
  [[nodiscard]] std::vector<PlacedRows> node_rows() const;
  /// redundant rows left out, and why
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  void place_rows();
  void place_path_rows(Interval& interval, const IntervalBlock& block);
  void make_batches();
  void put_defects(const IntervalBatch& batch, int first, VectorRef values) const;
  void put_path(const IntervalBatch& batch, int first, VectorRef values) const;
  void find_sparsity();
  void find_hessian_pattern();
  [[nodiscard]] std::vector<char> path_pattern(const Interval& interval,
                                               const PathRows& rows) const;
  [[nodiscard]] std::vector<char> dynamic_columns(const Interval& interval) const;
  int add_row(const RowSpec& row);
  bool update(const ConstVectorRef& x, int level);
  /// A node term with its scratch.
  struct NodeEntry {
    explicit NodeEntry(NodeTerm of);
    NodeTerm term;
    int row = -1;         ///< first row in the program; costs have none
    double weight = 1.0;  ///< costs only
    Vector y, value;
    Matrix J, H;
    std::vector<int> hessian_at;  ///< places of the lower triangle; empty where linear
  };
  static bool evaluate(NodeEntry& entry, const ConstVectorRef& x, bool first,
                       const ConstVectorRef* multipliers);

  Problem problem_;
  std::unique_ptr<components::Equations> equations_;
  Layout layout_;
  std::vector<std::vector<PathTerm>> path_terms_;
  std::vector<PathTerm> integral_terms_;
  std::vector<IntegralCost> integral_costs_;
  std::vector<NodeEntry> node_rows_, node_costs_;
  double sign_ = 1.0;  ///< -1 where the problem maximises
  std::vector<Interval> intervals_;
  std::vector<IntervalBatch> batches_;
  std::vector<int> batch_begin_;  ///< first interval of a batch
  std::vector<RowSpec> rows_;
  Vector row_lower_, row_upper_, row_scale_;
  Sparsity jacobian_, hessian_;
  /// per interval: where its Jacobian begins, and the local variables that its defect rows read,
  /// then its path terms
  std::vector<int> jacobian_at_;
  int jacobian_nodes_at_ = 0;  ///< where that of the node terms begins
  std::vector<std::vector<std::vector<int>>> patterns_;
  /// per interval: place of (i, j <= i), or -1
  std::vector<std::vector<int>> interval_hessian_at_;
  std::vector<std::string> notes_;
  // Cache of the point last evaluated: 0 nothing, 1 values, 2 first derivatives.
  Vector x_;
  int level_ = 0;
  bool defined_ = false;
  // Scratch.
  VectorOf<Lanes> gradient_w_;
};

}  // namespace jaculus::transcription
