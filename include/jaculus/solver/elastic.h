#pragma once
// Which constraints can't hold together. Every row that may give way gets slacks p, n >= 0 [in the
// row's unit],
//   minimise  sum (p + n) / row_scale  +  proximity/2 sum ((x - x_ref) / variable_scale)^2
//   subject to  row_lower <= g(x) - p + n <= row_upper,  x in its bounds,
// the elastic mode of Gill, Murray, Saunders (SNOPT, SIAM Review 47, 2005) without the objective.
// The L1 sum leaves most slacks at zero, so the rows with a slack are few; they and the limits that
// push against them are the conflict. The answer is local and not unique: other rows may give way
// with the same sum. x_ref is the given start.

#include <functional>
#include <string>
#include <vector>

#include "jaculus/solver/ipopt.h"
#include "jaculus/solver/sensitivities.h"

namespace jaculus::solver {

/// A row that has to give way, and by how much.
struct Relaxation {
  int row = 0;
  std::string name;
  std::string unit;
  double amount =
      /// g(x) minus the bound it passes: positive above the upper one, negative below the lower one
      /// [unit]
      0.0;
  double scaled = 0.0;  ///< |amount| over the row's scale [-]
};

struct Conflict {
  Status status = Status::failed;  ///< of the elastic solve
  bool feasible = false;           ///< it converged and nothing has to give way: start again from x
  /// by falling scaled amount; may be empty only where feasible or not converged
  std::vector<Relaxation> relaxed;
  std::vector<LimitSensitivity>
      /// limits that the relaxed rows push against, by weight; rate: d scaled sum/d limit
      against;
  /// all limits that the sum of scaled slacks depends on, relaxed rows among them, by weight
  std::vector<LimitSensitivity> limits;
  Vector x;  ///< [n] the least infeasible point found
  int iterations = 0;
  WallSeconds wall_seconds;
};

struct ElasticOptions {
  std::function<bool(int row)> may_relax = {};  ///< rows that may give way; empty: all of them
  double tolerance = 1e-5;                      ///< smallest scaled slack that counts [-]
  /// weight of staying near the start; only settles what the slacks leave open
  double proximity = 1e-8;
  int most = 20;  ///< longest list of `against`
  SolverOptions solver = {};
};

/// How close a feasibility stage stays to its start: far enough from 0 that it does not wander, and
/// small beside any slack that matters. Measured on the leaps: of 150 smooth random starts all
/// converge after such a stage; without it 4 to 8 % of those with a tail end where no point nearby
/// is feasible.
inline constexpr double kStageProximity = 1e-2;

/// Finds the conflict of a problem near x [n]. Bounds of variables never give way.
Conflict find_conflict(transcription::Nlp& nlp, const Vector& x,
                       const ElasticOptions& options = {});

/// The elastic problem itself; refers to `nlp`. Variables: x, then one slack for each finite side
/// of each relaxed row.
class ElasticNlp : public transcription::Nlp {
 public:
  ElasticNlp(transcription::Nlp& nlp, Vector reference,
             const std::function<bool(int row)>& may_relax, double proximity);

  /// Slacks that satisfy the rows at the reference, where the functions are defined there:
  /// [variables()].
  [[nodiscard]] Vector start();
  /// Sum of p - n for each row of the original at a point of the elastic problem [rows()].
  [[nodiscard]] Vector excess(const Vector& point) const;

  [[nodiscard]] int variables() const override { return count_of(lower_); }
  [[nodiscard]] int rows() const override { return nlp_.rows(); }
  [[nodiscard]] const Vector& variable_lower() const override { return lower_; }
  [[nodiscard]] const Vector& variable_upper() const override { return upper_; }
  [[nodiscard]] const Vector& row_lower() const override { return nlp_.row_lower(); }
  [[nodiscard]] const Vector& row_upper() const override { return nlp_.row_upper(); }
  [[nodiscard]] const Vector& variable_scale() const override { return scale_; }
  [[nodiscard]] const Vector& row_scale() const override { return nlp_.row_scale(); }
  [[nodiscard]] double objective_scale() const override { return 1.0; }
  [[nodiscard]] std::string variable_name(int column) const override;
  [[nodiscard]] std::string row_name(int row) const override { return nlp_.row_name(row); }
  [[nodiscard]] std::string variable_unit(int column) const override;
  [[nodiscard]] std::string row_unit(int row) const override { return nlp_.row_unit(row); }
  [[nodiscard]] const transcription::Sparsity& jacobian_sparsity() const override {
    return jacobian_;
  }
  [[nodiscard]] const transcription::Sparsity& hessian_sparsity() const override {
    return hessian_;
  }
  bool objective(const ConstVectorRef& x, double& value) override;
  bool gradient(const ConstVectorRef& x, VectorRef gradient) override;
  bool constraints(const ConstVectorRef& x, VectorRef values) override;
  bool jacobian(const ConstVectorRef& x, VectorRef values) override;
  bool hessian(const ConstVectorRef& x, double sigma, const ConstVectorRef& lambda,
               VectorRef values) override;

 private:
  /// One slack column: g + sign * slack enters the row.
  struct Slack {
    int row;
    double sign;
  };
  transcription::Nlp& nlp_;
  int n_;  ///< variables of the original
  Vector reference_;
  Vector pull_;  ///< proximity / variable_scale^2 [n]
  std::vector<Slack> slacks_;
  Vector lower_, upper_, scale_;
  transcription::Sparsity jacobian_, hessian_;
};

}  // namespace jaculus::solver
