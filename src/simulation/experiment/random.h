#pragma once
// Normal and uniform numbers that are the same wherever the program runs.

#include <cmath>
#include <cstdint>
#include <numbers>

#include "jaculus/core/tasks.h"
#include "jaculus/simulation/experiment.h"

namespace jaculus::simulation {

class Random {
 public:
  explicit Random(std::uint64_t seed) : seed_(seed) {}

  /// In [0, 1).
  double uniform() { return double(task_seed(seed_, ++count_) >> 11) * 0x1.0p-53; }
  /// Of deviation 1, after Box and Muller.
  double normal() {
    const double r = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return r * std::cos(2.0 * std::numbers::pi * uniform());
  }
  /// What is added to a nominal value, or taken for it where the spread is a range.
  double draw(const Spread& spread) {
    if (spread.range)
      return spread.range->lower + uniform() * (spread.range->upper - spread.range->lower);
    return spread.deviation == 0.0 ? 0.0 : spread.deviation * normal();
  }

 private:
  std::uint64_t seed_, count_ = 0;
};

}  // namespace jaculus::simulation
