#pragma once
// Defects, path rows and integral costs of up to four intervals of one phase, each in a lane
// (core/lanes.h), with exact first and second derivatives.
//
// In the words of interval.h, with Z_i = d a/d(q, v, u) at point i, the middle's (q, v, u) moves with
// w by
//     S = [ 1/2 I,  h/8 I   | 1/2 I, -h/8 I     | 0        | f/8 (v_0 - v_1) ]      q_m
//         [   1/2 (0 I) + h/8 Z_0 | 1/2 (0 I) - h/8 Z_1 (their u as well) | f/8 (a_0 - a_1) ]   v_m
//         [ 0             | 0                   | 1/2 of either end's input | 0 ]       u_m
// where only the rows of v_m are dense; f is the interval's fraction of T. Path terms are functions
// of one point of doubles: they see the intervals' own points, to which lanes are unpacked.

#include <array>
#include <vector>

#include "jaculus/transcription/interval.h"

namespace jaculus::transcription {

class IntervalBatch {
 public:
  /// `members`, 1 to kLanes, are of one phase, and their path rows are placed. They must outlive
  /// this.
  IntervalBatch(const components::Equations& equations, const Layout& layout,
                std::vector<Interval*> members);

  [[nodiscard]] const std::vector<Interval*>& members() const { return members_; }
  [[nodiscard]] int size() const { return w_size_; }

  /// Evaluates the points, of the members as well as far as path terms read them. False where the
  /// equations are not defined.
  bool evaluate(const ConstVectorRef& x);
  /// First derivatives of the points and of the defects; after evaluate().
  void differentiate();
  /// The same of the path rows; after differentiate().
  void differentiate_path();

  void defects(VectorRef rows);      ///< into the members' rows of all rows of the program
  void path_values(VectorRef rows);  ///< the same
  [[nodiscard]] const MatrixOf<Lanes>& defect_jacobian() const { return defect_w_; }  ///< 2n x w
  /// Of all path rows of a member, its lane: rows x w. Those of a point stand together, from
  /// path_place() on, in the order of the member's path.
  [[nodiscard]] const MatrixOf<Lanes>& path_jacobian() const { return path_w_; }
  [[nodiscard]] int path_place(int point) const { return path_place_[point]; }

  /// Of all members together.
  double integral(const IntegralCost& cost);
  /// Lane by lane, (w); after differentiate().
  void add_integral_gradient(const IntegralCost& cost, VectorOf<Lanes>& gradient_w);
  /// The Hessian of lambda . (defects, path rows) + sigma * integral costs by w (w x w), of which
  /// the lower triangle counts. lambda is of all rows of the program. After differentiate().
  const MatrixOf<Lanes>& hessian(const ConstVectorRef& lambda, double sigma,
                                 const std::vector<IntegralCost>& costs);

 private:
  using Point = components::EquationsPointOf<Lanes>;
  [[nodiscard]] double weight(int i) const;  ///< of the quadrature: 1/6, 4/6, 1/6 or 1/2, 0, 1/2
  [[nodiscard]] bool has_middle() const { return members_.front()->has_middle(); }
  /// Where the state and the input of an end stand in w.
  [[nodiscard]] int x_at(int i) const { return i == 0 ? 0 : 2 * n_; }
  [[nodiscard]] int u_at(int i) const { return i == 0 || held_ ? 4 * n_ : 4 * n_ + n_u_; }
  bool evaluate_point(int i, const VectorOf<Lanes>& state);
  void unpack(int i, bool derivatives);
  void differentiate_middle();
  void differentiate_defects();
  void times_middle(const ConstRefOf<Lanes>& by_s, RefOf<Lanes> by_w) const;
  void by_variables(int i, const ConstRefOf<Lanes>& by_s, RefOf<Lanes> by_w) const;
  int pack_term(int i, int member, const PathTerm& term, int row);
  void chain_forces(int i, int rows);
  void chain_cost(int i, const IntegralCost& cost);

  void point_hessian(int i, const ConstVectorRef& lambda, double sigma,
                     const std::vector<IntegralCost>& costs);
  void add_point_term(int i, int member, const PathTerm& term, const ConstVectorRef& multipliers);
  void add_term_curvature(int i);
  void add_middle_hessian();
  void add_end_hessian(int i);
  void add_time_coupling(const Lanes& scale);
  void add_end_gradient(int i, const VectorOf<Lanes>& y, const Lanes& scale);
  void add_defect_times(const std::vector<IntegralCost>& costs, double sigma);

  const components::Equations& equations_;
  std::vector<Interval*> members_;
  bool held_;
  bool poses_read_ = false;  ///< a path term reads configurations
  int n_, n_u_, w_size_;
  Lanes fraction_, h_;
  VectorOf<Lanes> w_;
  std::vector<Point> points_;
  std::array<VectorOf<Lanes>, 3> u_;
  VectorOf<Lanes> x_middle_;
  MatrixOf<Lanes> S_v_, A_w_;  ///< d v_m/dw, d a_m/dw: n x w
  MatrixOf<Lanes> defect_w_, path_w_;
  // Scratch. xi: what a path term reads; s: (q, v, u); z: (a, force).
  Matrix J_xi_, H_xi_;
  Vector values_;
  std::array<int, 3> path_rows_{};  ///< most that a member has at a point
  std::array<int, 3> path_place_{};  ///< first row of a point in path_w_
  MatrixOf<Lanes> by_s_, by_z_, cost_w_;
  Lanes cost_value_ = 0.0;
  VectorOf<Lanes> eta_, pull_, phi_, grad_s_, grad_w_, mu_;
  MatrixOf<Lanes> H_, H_s_, H_zz_, H_zs_, HS_, half_, product_;
  bool curved_ = false;  ///< a term has second derivatives by accelerations or forces
};

}  // namespace jaculus::transcription
