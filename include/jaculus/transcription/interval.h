#pragma once
// One collocation interval: defects, path rows and integral costs with exact first and second
// derivatives.
//
// State x = (q, v), dynamics f(x, u) = (v, a(q, v, u)), interval length h = fraction * T with T the
// phase's duration.
//   Hermite-Simpson, compressed:  x_m = (x_0 + x_1)/2 + h/8 (f_0 - f_1),
//                                 defect = x_1 - x_0 - h/6 (f_0 + 4 f_m + f_1)       (fourth order)
//   trapezoidal:                  defect = x_1 - x_0 - h/2 (f_0 + f_1)               (second order)
// Source: Hargraves and Paris 1987; Betts, Practical Methods for Optimal Control, ch. 4.
// The input is held over the interval or linear between its ends, and f at both ends uses this
// interval's own input: a jump of a held input between intervals is no error of the scheme.
//
// Local variables w, in order: x_0 (2n), x_1 (2n), inputs (n_u held, 2 n_u linear), T.

#include <array>

#include "jaculus/transcription/term.h"

namespace jaculus::transcription {

/// A path term at one point of one interval.
struct PathRows {
  const PathTerm* term = nullptr;
  int point = 0;  ///< 0 start, 1 middle, 2 end
  int row = 0;    ///< first row in the nonlinear program
};

/// An integral cost: its term and its weight in the objective.
struct IntegralCost {
  const PathTerm* term = nullptr;
  double weight = 1.0;
};

class Interval {
 public:
  Interval(const components::Equations& equations, const Layout& layout, const IntervalBlock& block,
           Scheme scheme);

  std::vector<int> columns;    ///< column of each local variable in the nonlinear program
  std::vector<PathRows> path;  ///< filled by NonlinearProgram
  int defect_row = 0;          ///< first of its 2n rows

  [[nodiscard]] int size() const { return count_of(columns); }
  [[nodiscard]] bool has_middle() const { return scheme_ == Scheme::hermite_simpson; }

  /// Evaluates the points. False where the equations are not defined.
  bool evaluate(const Eigen::Ref<const Vector>& x);
  /// First derivatives of the points; after evaluate().
  void differentiate();

  void defects(VectorRef out) const;  ///< 2n
  /// 2n x w; after differentiate()
  [[nodiscard]] const Matrix& defect_jacobian() const { return defect_w_; }
  void path_values(const PathRows& rows, VectorRef out);
  void path_jacobian(const PathRows& rows, Matrix& out);  ///< rows x w; after differentiate()
  double integral(const IntegralCost& cost);
  void add_integral_gradient(const IntegralCost& cost, double scale, Vector& gradient_w);
  /// Adds the Hessian of eta . defect + sum of multipliers . path rows + sigma * integral costs to
  /// H (w x w), whose lower triangle counts.
  void add_hessian(const Vector& eta, const ConstVectorRef& row_multipliers, double sigma,
                   const std::vector<IntegralCost>& costs, Matrix& H);

  [[nodiscard]] const components::EquationsPoint& point(int i) const { return points_[i]; }
  [[nodiscard]] components::EquationsPoint& point(int i) { return points_[i]; }
  [[nodiscard]] const Vector& input(int i) const { return u_[i]; }
  [[nodiscard]] double length() const { return h_; }  ///< [s]

 private:
  [[nodiscard]] PointView view(int i);
  [[nodiscard]] double weight(int i) const;  ///< of the quadrature: 1/6, 4/6, 1/6 or 1/2, 0, 1/2
  void f_into(int i, Vector& f) const;
  void f_jacobian(int i, Matrix& F) const;  ///< 2n x (2n + n_u)
  void build_maps();
  void differentiate_defects();
  void point_hessian(int i, const Vector& phi, const ConstVectorRef& row_multipliers, double sigma,
                     const std::vector<IntegralCost>& costs);
  void add_point_term(int i, const PathTerm& term, const ConstVectorRef& multipliers);
  void add_term_curvature(const Matrix& Z);
  void chain_term(int i, const PathTerm& term, Matrix& by_s);
  void add_time_coupling(const Vector& gradient_w, double scale, Matrix& H);

  const components::Equations& equations_;
  Scheme scheme_;
  bool held_;
  int n_, n_u_;
  double fraction_, h_ = 0.0;
  std::vector<components::EquationsPoint> points_;
  std::array<Vector, 3> u_, f_;
  std::array<Matrix, 3> S_;    ///< d(q, v, u at the point)/dw
  std::array<Matrix, 3> F_;    ///< d f/d(q, v, u) at the point
  std::array<Matrix, 3> F_w_;  ///< d f/dw, total
  Matrix defect_w_;
  // Scratch.
  Vector w_, phi_, grad_s_, mu_, grad_w_, values_, pull_;
  Matrix J_xi_, by_s_, H_xi_, H_s_, HS_, S_middle_t_, half_, product_;
};

}  // namespace jaculus::transcription
