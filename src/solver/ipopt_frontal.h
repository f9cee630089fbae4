#pragma once
// Lets Ipopt factorise its KKT systems with frontal.h. Debian's Ipopt 3.11 has no headers for
// linear solvers of one's own, but HSLLoader.h, by which a program hands over routines in place of
// HSL's: ours answer by the interface of MA57 (Duff, "MA57, a code for the solution of sparse
// symmetric definite and indefinite systems", ACM TOMS 30, 2004).
//
// Ipopt's unknowns are (x free, s, y_c, y_d): slacks s of the inequality rows, multipliers of
// equality rows and of inequality rows. Columns of an Nlp are in the order of time, what holds for
// all of it last, and so
//     a row belongs to the group of its first column,
//     a group begins where a run of columns begins that are an equality row's first,
//     a column that one row alone reads (a slack of the elastic problem) goes with that row.

#include <IpTypes.hpp>

#include "jaculus/transcription/nlp.h"
#include "solver/frontal.h"

namespace jaculus::solver::detail {

/// Numbers of unknowns of each kind, in Ipopt's order; as many y_d as s.
struct KktSizes {
  int x = 0, s = 0, y_c = 0;
};

/// Groups by the rule above; indices from 0.
EliminationOrder order_along_time(const SymmetricPattern& pattern, const KktSizes& sizes);

/// While it lives, Ipopt's "ma57" is ours, for the rows of one Nlp; one at a time.
class FrontalInIpopt {
 public:
  explicit FrontalInIpopt(const transcription::Nlp& nlp);
  ~FrontalInIpopt();
  FrontalInIpopt(const FrontalInIpopt&) = delete;
  FrontalInIpopt& operator=(const FrontalInIpopt&) = delete;

  /// Whether this Ipopt can be given routines.
  static bool available();
  /// Whether a system was refused, for its fronts would be too wide.
  [[nodiscard]] static bool refused();
};

}  // namespace jaculus::solver::detail
