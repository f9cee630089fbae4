#pragma once
// The one place that differentiates the forward model: one-sided differences through simulation.

#include <optional>
#include <vector>

#include "diagnosis/forward/problem.h"

namespace jaculus::diagnosis {

/// rows(p + step e_i) - rows(p) of all datasets.
struct Difference {
  double step = 0.0;         ///< taken, in the parameter's unit
  std::vector<Vector> rows;  ///< a dataset each [units of its rows]
};

/// At exactly this step; nothing where the simulation fails there.
std::optional<Difference> difference_at(const Problem& problem,
                                        const std::vector<Alignment>& alignments, const Vector& p,
                                        const std::vector<Vector>& rows_at_p, int parameter,
                                        double step);

/// Forwards, or backwards where that leaves the parameter's bounds or can't be simulated; nothing
/// where neither can.
std::optional<Difference> difference(const Problem& problem,
                                     const std::vector<Alignment>& alignments, const Vector& p,
                                     const std::vector<Vector>& rows_at_p, int parameter,
                                     double step);

/// rows(p + move) - rows(p), several parameters moved at once, as a difference by a step of 1; or
/// rows(p - move) - rows(p), by -1, where that can't be simulated; nothing where neither can.
std::optional<Difference> difference_along(const Problem& problem,
                                           const std::vector<Alignment>& alignments,
                                           const Vector& p, const std::vector<Vector>& rows_at_p,
                                           const Vector& move);

/// Step in prior scales of a difference, by the norm of the whitened slope: half a standard
/// deviation by this parameter or direction alone, within settings.least_step and most_step. Large
/// beside the simulation's rounding, small beside its curvature.
double difference_step(double sensitivity, const Settings& settings);

}  // namespace jaculus::diagnosis
