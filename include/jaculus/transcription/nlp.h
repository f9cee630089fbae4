#pragma once
// A sparse nonlinear program with exact first and second derivatives:
//   minimise f(x)  subject to  x_lower <= x <= x_upper,  row_lower <= g(x) <= row_upper.
// The solver knows nothing else of a problem; the transcription knows nothing of the solver.

#include <string>
#include <vector>

#include "jaculus/core/types.h"

namespace jaculus::transcription {

/// Positions of the entries of a sparse matrix; duplicates are summed.
struct Sparsity {
  std::vector<int> rows;
  std::vector<int> columns;
  [[nodiscard]] int size() const { return count_of(rows); }
};

class Nlp {
 public:
  virtual ~Nlp() = default;

  [[nodiscard]] virtual int variables() const = 0;
  [[nodiscard]] virtual int rows() const = 0;
  [[nodiscard]] virtual const Vector& variable_lower() const = 0;
  [[nodiscard]] virtual const Vector& variable_upper() const = 0;
  [[nodiscard]] virtual const Vector& row_lower() const = 0;
  [[nodiscard]] virtual const Vector& row_upper() const = 0;

  /// Typical size of each variable, row and of the objective, from bounds and physics; all
  /// positive. The solver divides by them.
  [[nodiscard]] virtual const Vector& variable_scale() const = 0;
  [[nodiscard]] virtual const Vector& row_scale() const = 0;
  [[nodiscard]] virtual double objective_scale() const = 0;

  /// Names that a user can read in a report: "all_feet, node 12: front_a voltage". Units: "V".
  [[nodiscard]] virtual std::string variable_name(int column) const = 0;
  [[nodiscard]] virtual std::string row_name(int row) const = 0;
  [[nodiscard]] virtual std::string variable_unit(int column) const = 0;
  [[nodiscard]] virtual std::string row_unit(int row) const = 0;

  [[nodiscard]] virtual const Sparsity& jacobian_sparsity() const = 0;  ///< of g
  [[nodiscard]] virtual const Sparsity& hessian_sparsity()
      const = 0;  ///< lower triangle of the Hessian of the Lagrangian

  // Evaluations. Not const: they share scratch space, so one Nlp serves one thread. They return
  // false where the functions are not defined at x (a loop that can't close); outputs are then
  // unspecified. None of them allocates once running.
  virtual bool objective(const ConstVectorRef& x, double& value) = 0;
  virtual bool gradient(const ConstVectorRef& x, VectorRef gradient) = 0;
  virtual bool constraints(const ConstVectorRef& x, VectorRef values) = 0;
  virtual bool jacobian(const ConstVectorRef& x, VectorRef values) = 0;
  /// sigma * Hessian of f + sum of lambda_i * Hessian of g_i, in the order of hessian_sparsity().
  virtual bool hessian(const ConstVectorRef& x, double sigma, const ConstVectorRef& lambda,
                       VectorRef values) = 0;
};

}  // namespace jaculus::transcription
