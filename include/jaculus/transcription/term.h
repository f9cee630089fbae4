#pragma once
// Terms: families of constraints or costs. A path term is evaluated at every collocation point of a
// phase, a node term once.
//
// A path term reads xi = (q, v, u, a, f) of one point: coordinates (n), rates (n), inputs (n_u),
// accelerations (n), forces of the feet in contact (2 a foot). It declares which blocks it reads;
// sparsity follows from that and never from values.

#include <functional>
#include <string>
#include <vector>

#include "jaculus/transcription/key.h"
#include "jaculus/transcription/layout.h"

namespace jaculus::transcription {

/// Blocks of xi that a path term depends on.
struct Reads {
  bool position = false;
  bool velocity = false;
  bool input = false;
  bool acceleration = false;
  bool force = false;
  [[nodiscard]] bool dynamics() const { return acceleration || force; }
  /// may jump where an interval ends
  [[nodiscard]] bool held() const { return input || dynamics(); }
};

/// What a path term sees of a point. `point` holds q, v, a, force and the configuration's
/// kinematics.
struct PointView {
  const components::Equations& equations;
  components::EquationsPoint& point;
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

/// Most rows that one path term may have; more are several terms. Scratch is sized by it,
/// make_terms checks it.
inline constexpr int kMaxTermRows = 32;

/// How the best objective moves with the figure of the problem that sets a term's limits: -df*/dp
/// of one row from its multiplier, by the envelope theorem (formulas in solver/plan.h). Summed over
/// all rows of all terms that name the same figure.
struct Sensitivity {
  std::string figure;  ///< "voltage"; empty where none is stated
  std::string unit;    ///< of the figure: "V"
  /// `point` is where a path term holds, null for a node term.
  std::function<double(int row, double multiplier, const components::EquationsPoint* point)> gain;
};

struct PathTerm {
  std::string name;
  std::vector<RowSpec> rows;
  Reads reads;
  /// holds at the points of a phase that lie after this fraction of its duration ...
  double after = -1.0;
  /// ... and before this one: a window in time, which a finer mesh does not move
  double before = 2.0;
  bool only_last = false;  ///< only the phase's last point, with the last interval's input
  bool linear = false;     ///< no second derivatives: evaluate() is not asked for them
  /// The foot that must carry load for the rows to have an interior: the point where it carries
  /// nothing is left out. -1: none.
  int loaded_foot = -1;
  Sensitivity sensitivity = {};
  /// values (rows); J (rows x xi, zero on entry in the blocks it reads) where not null; adds sum_i
  /// multipliers_i d2 row_i/dxi2 to H where not null. One may be asked for without the other.
  std::function<void(const PointView&, VectorRef values, Matrix* J,
                     const ConstVectorRef* multipliers, Matrix* H)>
      evaluate;
  /// Whether it holds at the fraction s in [0, 1] of its phase.
  [[nodiscard]] bool holds_at(double s) const {
    constexpr double kRounding = 1e-9;
    return only_last ? s > 1.0 - kRounding : s > after + kRounding && s < before - kRounding;
  }
};

/// A term on chosen columns of the nonlinear program: boundary conditions, impacts, objectives.
struct NodeTerm {
  std::string name;
  std::vector<RowSpec> rows;
  Sensitivity sensitivity = {};
  std::vector<int> columns;
  bool linear = false;  ///< no second derivatives
  /// places feet on the ground: rows that fixed variables make redundant are left out
  bool stance = false;
  /// y = x[columns]. False where not defined at y. J and H are zero on entry.
  std::function<bool(const ConstVectorRef& y, VectorRef values, Matrix* J,
                     const ConstVectorRef* multipliers, Matrix* H)>
      evaluate;
};

/// What the factories of terms fill.
struct TermContext {
  const Problem& problem;
  const components::Equations& equations;
  Layout& layout;
  std::vector<std::vector<PathTerm>> path;  ///< constraints, by phase
  std::vector<NodeTerm> node_rows;
  /// integral over all phases, with its weight
  std::vector<std::pair<PathTerm, double>> integral_costs;
  std::vector<std::pair<NodeTerm, double>> node_costs;  ///< with its weight
  /// (phase, foot) that carries nothing at the phase's end
  std::vector<std::pair<int, int>> unloaded;
  std::vector<std::string> notes;  ///< what a user should know, one sentence each
  [[nodiscard]] const model::PlanarModel& model() const { return equations.model(); }
};

/// A kind of constraint or cost, declared in one place: what a problem file calls it, its keys,
/// what help says of it, and how its rows are made.
struct TermType {
  std::string name;     ///< `type` in the file: {type: friction}
  std::string meaning;  ///< one line for help
  bool cost = false;
  std::string unit = {};       ///< of a cost's value
  std::vector<Key> keys = {};  ///< beside `type`, `name` and the `weight` of a cost
  /// Its own keys as in a file, such that it has rows in problems/leap_tail.yaml: help shows them,
  /// the test that walks the catalogue checks their derivatives.
  std::string example = {};
  /// Adds the rows or the cost. The keys are read and checked: `spec.values` holds them.
  std::function<void(const TermSpec& spec, TermContext& context)> make;

  /// The example as it stands in a file: "{type: friction, name: mine, coefficient: 0.4}".
  [[nodiscard]] std::string in_file(const std::string& own_name = "") const;
};

/// All terms that come with the library. A program that has terms of its own copies this, adds
/// them, and reads its problems with it.
const TermCatalogue& term_catalogue();

/// Index of the phase, foot or motor that a declared key names.
int named(const TermSpec& spec, std::string_view key, const TermContext& context);
/// Indices of all that a declared key lists; of all that there are where it is absent.
std::vector<int> all_named(const TermSpec& spec, std::string_view key, const TermContext& context);

/// Builds the terms that the problem names, and those that every problem has (stance, impact).
TermContext make_terms(const Problem& problem, const components::Equations& equations,
                       Layout& layout);

}  // namespace jaculus::transcription
