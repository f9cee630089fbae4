#pragma once
// Defects, path rows and integral costs of up to four intervals of one phase, each in a lane
// (core/lanes.h), with exact first and second derivatives.
//
// In the words of interval.h, with Z_i = d a/d(q, v, u) at point i, the middle's (q, v, u) moves
// with w by
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
  /// `members`, 1 to kLanes, are of one phase, and their path rows are placed. They and the costs'
  /// terms must outlive this.
  IntervalBatch(const components::Equations& equations, const Layout& layout,
                std::vector<Interval*> members, std::vector<IntegralCost> costs);

  [[nodiscard]] const std::vector<Interval*>& members() const { return members_; }
  [[nodiscard]] int size() const { return w_size_; }

  /// Evaluates the points, of the members as well as far as path terms read them. False where the
  /// equations are not defined.
  bool evaluate(const ConstVectorRef& x);
  /// First derivatives of the points, defects and path rows; after evaluate().
  void differentiate();

  void defects(VectorRef rows);      ///< into the members' rows of all rows of the program
  void path_values(VectorRef rows);  ///< the same
  [[nodiscard]] const MatrixOf<Lanes>& defect_jacobian() const { return defect_w_; }  ///< 2n x w
  /// Of all path rows of a member, its lane: rows x w. Those of a point stand together, from
  /// path_place() on, in the order of the member's path.
  [[nodiscard]] const MatrixOf<Lanes>& path_jacobian() const { return path_w_; }
  [[nodiscard]] int path_place(int point) const { return path_place_[point]; }

  /// Of all costs over all members together.
  double integral();
  /// Lane by lane, (w); after differentiate().
  void add_integral_gradient(VectorOf<Lanes>& gradient_w);
  /// The Hessian of lambda . (defects, path rows) + sigma * integral costs by w (w x w), of which
  /// the lower triangle counts. lambda is of all rows of the program. After differentiate().
  const MatrixOf<Lanes>& hessian(const ConstVectorRef& lambda, double sigma);

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
  void place_path();
  void find_curved();
  void differentiate_path();
  int pack_term(int i, int member, const PathTerm& term, int row, MatrixOf<Lanes>& by_s,
                MatrixOf<Lanes>& by_z);
  void chain_forces(int i, const MatrixOf<Lanes>& by_z, MatrixOf<Lanes>& by_s) const;
  void chain_cost(int i, const IntegralCost& cost);

  void add_path_gradient(int i, const ConstVectorRef& lambda);
  void point_hessian(int i, const ConstVectorRef& lambda, double sigma);
  void add_term_hessians(int i, const ConstVectorRef& lambda, double sigma);
  void add_term_curvature(int i);
  void add_middle_hessian();
  void add_end_hessian(int i);
  void add_time_coupling(const Lanes& scale);
  void add_end_gradient(int i, const VectorOf<Lanes>& y, const Lanes& scale);
  void add_defect_times(double sigma);

  const components::Equations& equations_;
  std::vector<Interval*> members_;
  std::vector<IntegralCost> costs_;
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
  // Path rows of a point, all lanes: those of a member are in the order of its path. xi: what a
  // term reads; s: (q, v, u); z: (a, force).
  std::array<int, 3> path_rows_{};              ///< most that a member has
  std::array<int, 3> path_place_{};             ///< the first one in path_w_
  std::array<MatrixOf<Lanes>, 3> by_s_, by_z_;  ///< Jacobian, total by s; by z
  std::array<VectorOf<Lanes>, 3> lambda_;
  std::array<std::vector<int>, 3> curved_;  ///< places of xi with second derivatives
  // Scratch.
  Matrix J_xi_, H_xi_;
  Vector values_;
  MatrixOf<Lanes> cost_s_, cost_z_, cost_w_;
  Lanes cost_value_ = 0.0;
  VectorOf<Lanes> eta_, pull_, phi_, grad_s_, grad_w_, mu_;
  MatrixOf<Lanes> H_, H_s_, H_zz_, H_zs_, HS_, half_, product_;
  bool forces_curved_ = false;  ///< a term has second derivatives by z
};

}  // namespace jaculus::transcription
