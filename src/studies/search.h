#pragma once
// The inner search of a study: the value of one parameter that makes a figure of merit largest.

#include <functional>
#include <optional>
#include <string>

#include "jaculus/core/types.h"

namespace jaculus::studies {

/// Over what to search.
struct SearchSpace {
  double lower = 1.0;
  double upper = 50.0;
  /// every integer of [lower, upper]; otherwise a scan of 64 points, refined by Brent's method
  bool integer = true;
};

struct SearchResult {
  double argument = kNaN;     ///< of the largest value; the smaller one of equals
  double value = -kInfinity;  ///< -infinity where no argument gave a finite value
  /// "lower" or "upper" where the search ended there, so that more might lie beyond; else empty
  std::string bound;
  int evaluations = 0;
};

/// Maximises; an argument whose value is NaN doesn't count. Needs lower <= upper, and an integer
/// between if integer.
SearchResult maximise(const SearchSpace& space, const std::function<double(double)>& value);

}  // namespace jaculus::studies
