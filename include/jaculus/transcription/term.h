#pragma once
// Terms: families of constraints or costs. A path term is evaluated at every collocation point of a phase, a node term once.
//
// A path term reads xi = (q, v, u, a, f) of one point: coordinates (n), rates (n), inputs (n_u), accelerations (n), forces of the
// feet in contact (2 a foot). It declares which blocks it reads; sparsity follows from that and never from values.

#include <functional>
#include <string>
#include <vector>

#include "jaculus/transcription/layout.h"

namespace jaculus {

/// Blocks of xi that a path term depends on.
struct Reads {
  bool position = false;
  bool velocity = false;
  bool input = false;
  bool acceleration = false;
  bool force = false;
  [[nodiscard]] bool dynamics() const { return acceleration || force; }
  [[nodiscard]] bool held() const { return input || dynamics(); }  ///< may jump where an interval ends
};

/// What a path term sees of a point. `point` holds q, v, a, force and the configuration's kinematics.
struct PointView {
  const Equations& equations;
  EquationsPoint& point;
  Eigen::Ref<const Vector> u;
  int n, n_u;
  [[nodiscard]] int q_at() const { return 0; }
  [[nodiscard]] int v_at() const { return n; }
  [[nodiscard]] int u_at() const { return 2 * n; }
  [[nodiscard]] int a_at() const { return 2 * n + n_u; }
  [[nodiscard]] int f_at() const { return 3 * n + n_u; }
};

/// Names, bounds and scale of one row.
struct RowSpec {
  std::string name;
  std::string unit;
  Bounds bounds;
  double scale = 1.0;
};

/// Most rows that one path term may have; more are several terms. Scratch is sized by it, make_terms checks it.
inline constexpr int kMaxTermRows = 32;

/// The figure of the problem that a term's bounds or values follow from; what it costs is summed over all its rows.
enum class LimitKind { other, voltage, friction, normal_force, touchdown_pitch };

struct PathTerm {
  std::string name;
  std::vector<RowSpec> rows;
  Reads reads;
  double after = -1.0;     ///< holds at the points of a phase that lie after this fraction of its duration ...
  double before = 2.0;     ///< ... and before this one: a window in time, which a finer mesh does not move
  bool only_last = false;  ///< only the phase's last point, with the last interval's input
  LimitKind kind = LimitKind::other;
  int foot = -1;  ///< the foot whose force it limits, -1 for other terms
  /// values (rows); J (rows x xi, zero on entry) where not null; adds sum_i multipliers_i d2 row_i/dxi2 to H where not null.
  std::function<void(const PointView&, VectorRef values, Matrix* J, const ConstVectorRef* multipliers, Matrix* H)>
      evaluate;
  /// Whether it holds at the fraction s in [0, 1] of its phase.
  [[nodiscard]] bool holds_at(double s) const {
    constexpr double kRounding = 1e-9;
    return only_last ? s > 1.0 - kRounding : s > after + kRounding && s < before - kRounding;
  }
};

/// A term on chosen columns of the programme: boundary conditions, impacts, objectives.
struct NodeTerm {
  std::string name;
  std::vector<RowSpec> rows;
  LimitKind kind = LimitKind::other;  ///< of its row `kind_row`
  int kind_row = 0;
  std::vector<int> columns;
  bool linear = false;  ///< no second derivatives
  bool stance = false;  ///< places feet on the ground: rows that fixed variables make redundant are left out
  /// y = x[columns]. False where not defined at y. J and H are zero on entry.
  std::function<bool(const ConstVectorRef& y, VectorRef values, Matrix* J, const ConstVectorRef* multipliers,
                     Matrix* H)>
      evaluate;
};

/// What the factories of terms fill.
struct TermContext {
  const Problem& problem;
  const Equations& equations;
  Layout& layout;
  std::vector<std::vector<PathTerm>> path;  ///< constraints, by phase
  std::vector<NodeTerm> node_rows;
  std::vector<std::pair<PathTerm, double>> integral_costs;  ///< integral over all phases, with its weight
  std::vector<std::pair<NodeTerm, double>> node_costs;      ///< with its weight
  std::vector<std::pair<int, int>> unloaded;                ///< (phase, foot) that carries nothing at the phase's end
  std::vector<std::string> notes;                           ///< what a user should know, one sentence each
  [[nodiscard]] const PlanarModel& model() const { return equations.model(); }
};

/// A row of the catalogue: what a problem file calls it, what it does, and its factory, which reads its own keys strictly.
struct TermEntry {
  std::string type;
  std::string caption;
  bool cost = false;
  std::function<void(const TermSpec&, TermContext&)> make;
};

/// All terms that a problem may name.
const std::vector<TermEntry>& term_catalogue();

/// Builds the terms that the problem names, and those that every problem has (stance, impact).
TermContext make_terms(const Problem& problem, const Equations& equations, Layout& layout);

}  // namespace jaculus
