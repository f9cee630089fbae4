#pragma once
// Measured states at the borders of boxes, from positions and, where they agree, rates.
//
// About each border t a parabola q(t + s) = a + b s + c s^2 is fitted to the samples within half a
// box: positions by a + b s + c s^2 and, where a rate is logged, its samples by b + 2 c s, weighted
// by the scatter that each channel has about a parabola and a line of its own. A rate is used only
// where it is the positions': if the mean square of rate less the positions' slope is more than
// `rates_agree` times what their scatter makes of it (a filter's lag, a wrong scale), positions
// stand alone.

#include <vector>

#include "diagnosis/data/observations.h"

namespace jaculus::diagnosis {

struct BoxState {
  Vector q, v;  ///< coordinates [rad or m] and rates
};

/// At the start of every segment, in order; empty vectors where a coordinate has too few samples.
/// `half_width`: of the parabolas [s].
std::vector<BoxState> box_states(const ObservedDataset& observed, double half_width,
                                 const Settings& settings);

/// A box that holds enough samples of every position for its parabolas: settings.pattern_rows of
/// the slowest, settings.pattern_box at least and settings.force_box at most [s].
double pattern_box(const std::vector<ObservedDataset>& datasets, const Settings& settings);

}  // namespace jaculus::diagnosis
