#pragma once
// One collocation interval: its variables, its three points and the rows that hold there. Defects
// and derivatives are those of interval_batch.h, four intervals at a time.
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
  [[nodiscard]] double fraction() const { return fraction_; }  ///< of its phase's duration
  [[nodiscard]] const std::vector<int>& feet() const { return points_.front().feet; }

  /// Evaluates the points. False where the equations are not defined.
  bool evaluate(const ConstVectorRef& x);

  [[nodiscard]] const components::EquationsPoint& point(int i) const { return points_[i]; }
  [[nodiscard]] components::EquationsPoint& point(int i) { return points_[i]; }
  [[nodiscard]] const Vector& input(int i) const { return u_[i]; }
  [[nodiscard]] Vector& input(int i) { return u_[i]; }
  [[nodiscard]] double length() const { return h_; }  ///< [s]
  void set_length(double h) { h_ = h; }
  [[nodiscard]] PointView view(int i) { return {equations_, points_[i], u_[i], n_, n_u_}; }

 private:
  const components::Equations& equations_;
  Scheme scheme_;
  bool held_;
  int n_, n_u_;
  double fraction_, h_ = 0.0;
  std::vector<components::EquationsPoint> points_;
  std::array<Vector, 3> u_;
  Vector w_, x_middle_;  ///< scratch
};

}  // namespace jaculus::transcription
