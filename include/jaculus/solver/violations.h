#pragma once
// What a point leaves unsatisfied, by name and unit.

#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/transcription/nlp.h"

namespace jaculus::solver {

/// One row, or one variable outside its bounds.
struct Violation {
  bool is_row = true;
  int index = 0;  ///< of the row or variable
  std::string name;
  std::string unit;
  double value = 0.0;  ///< value, lower and upper in `unit`
  double lower = 0.0;
  double upper = 0.0;
  double amount = 0.0;  ///< distance to the nearer bound, in `unit`
  double scaled = 0.0;  ///< the same over the row's or variable's scale [-]
};

/// The `count` largest violations at x [n], by scaled amount, then rows before variables, then
/// index; none whose scaled amount is not above `least` (rounding, where a solver held all rows to
/// its tolerance). Nothing where the constraints are not defined at x.
std::optional<std::vector<Violation>> ranked_violations(transcription::Nlp& nlp,
                                                        const ConstVectorRef& x, int count,
                                                        double least = 0.0);

struct WorstViolation {
  double absolute = 0.0;  ///< units mixed
  double scaled = 0.0;    ///< [-]
};
/// Largest violation over all rows and bounds at x [n]; nothing where the constraints are not
/// defined there.
std::optional<WorstViolation> worst_violation(transcription::Nlp& nlp, const ConstVectorRef& x);

}  // namespace jaculus::solver
