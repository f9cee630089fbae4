#pragma once
// L D L^T of a sparse symmetric indefinite matrix whose graph is a chain with a border, as a
// KKT system along time is: the frontal method (Irons, "A frontal solution program for finite
// element analysis", Int. J. Numer. Meth. Engng. 2, 1970) with the pivots of Duff and Reid ("The
// multifrontal solution of indefinite sparse symmetric linear equations", ACM TOMS 9, 1983).
//
// Unknowns belong to groups, in order of elimination. A dense front holds the unknowns that the
// groups so far have touched and none has eliminated. A group adds its entries to the front, then
// eliminates what no later group touches. A pivot is
//     1 x 1   where |f_pp| >= u max_i |f_ip|,
//     2 x 2   where |E^-1| (max_i |f_ip|, max_i |f_iq|)^T <= (1/u, 1/u)^T,
// and what has no pivot stays in the front for a later group, so that L is bounded whatever the
// matrix, and the inertia (Sylvester) is that of D. The work is (groups) x (front)^3: linear in
// time where the front is as wide as a step and the border.
//
// Slack rows, unknowns s and y with
//     sigma s + b y = r_s,     b s + a . x + e y = r_y,
// that a group knows as such are eliminated in pairs without entering the front:
//     [sigma b; b e]^-1 has the entry (y, y) = sigma / (sigma e - b^2),  one pivot of either sign.
// Where sigma is so large that the pair would swamp what it adds to, s alone is eliminated and y
// enters the front with e - b^2 / sigma, to be pivoted like all others.
//
// Arithmetic is that of single elements in a fixed order, also where a wide instruction does four
// at a time: results are the same bits on every machine.

#include <array>
#include <span>
#include <vector>

#include "solver/front.h"

namespace jaculus::solver {

/// Entry of the lower or upper triangle (each off-diagonal pair once); repeated ones add up.
struct SymmetricPattern {
  int size = 0;
  std::vector<int> rows, columns;
};

/// Two unknowns that may be eliminated as a pair: `slack` meets nothing but `row`.
struct SlackRow {
  int slack = 0;
  int row = 0;
};

/// Unknowns in order of elimination; every unknown that is in no slack row has its group.
struct EliminationOrder {
  std::vector<int> group;  ///< [size] of an unknown, in [0, groups); slack rows: of both unknowns
  std::vector<SlackRow> slack_rows;
  int groups = 0;
};

struct Inertia {
  int negative = 0;
  int zero = 0;  ///< pivots that are zero to rounding: the matrix is singular
};

class FrontalFactorization {
 public:
  /// Lays out groups and fronts.
  FrontalFactorization(SymmetricPattern pattern, const EliminationOrder& order);

  /// Unknowns in the widest front, where all pivots are taken when they are due.
  [[nodiscard]] int widest_front() const { return widest_; }

  /// `values` in the order of the pattern; `threshold` is u above, in (0, 0.5].
  Inertia factorize(std::span<const double> values, double threshold);

  /// Solves in place, size values. After factorize() of a matrix that is not singular.
  void solve(std::span<double> rhs) const;

 private:
  struct Entry {
    int value, row, column;
  };
  struct SlackEntries {
    SlackRow of;
    int group = 0;
    std::vector<int> sigma, b, e;  ///< places of values
    std::vector<Entry> a;          ///< column: the unknown x
    // Of the last factorisation.
    double s = 0.0, off = 0.0, ee = 0.0;
    bool paired = true;
    std::vector<double> weights;  ///< values of a
  };
  struct Group {
    std::vector<int> own;    ///< unknowns that are complete once it is added
    std::vector<int> enter;  ///< of later groups, that this one touches first
    std::vector<Entry> entries;
    std::vector<int> slack_rows;
  };
  void place_entries(const EliminationOrder& order);
  void place_entrances(const EliminationOrder& order);
  void add_group(Group& group, std::span<const double> values);
  void add_slack_row(SlackEntries& row);
  void add_lines();
  void read_slack_row(SlackEntries& row, std::span<const double> values) const;
  void reduce_slack(const SlackEntries& row, std::span<double> rhs) const;
  void restore_slack(const SlackEntries& row, std::span<double> rhs) const;

  SymmetricPattern pattern_;
  std::vector<SlackEntries> slack_rows_;
  std::vector<Group> groups_;
  int widest_ = 0;
  Front front_;
  Inertia inertia_;
  std::vector<char> is_due_;  ///< [size], of an unknown: may be eliminated
  /// Slack rows that are to be added: a by places in the front, and what its square counts.
  std::vector<double> lines_;
  std::array<double, Front::kLines> scales_{};
  int waiting_ = 0;
};

}  // namespace jaculus::solver
