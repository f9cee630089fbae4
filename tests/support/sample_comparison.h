#pragma once
// A comparison of two leaps, made up.

#include "jaculus/studies/comparison.h"
#include "support/sample_summary.h"

namespace jaculus::test {

/// A leap without a tail and one with it, planned under other conditions.
inline std::vector<studies::ComparisonRow> two_rows() {
  solver::Summary base = sample_summary();
  base.name = "tailless";
  base.average_acceleration = 6.0;
  solver::Summary tail = sample_summary();
  tail.average_acceleration = 6.6;
  return {{base, studies::TailKind::none, "a"}, {tail, studies::TailKind::drag, "b"}};
}

}  // namespace jaculus::test
