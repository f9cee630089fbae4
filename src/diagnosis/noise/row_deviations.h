#pragma once
// Standard deviation of every row: its channel's noise floor, more where timing matters.
//
// A zero-order-hold quantity steps a part of a period sooner or later than predicted; an impact
// jumps, and a sampled loop answers it likewise; later impacts inherit the form of the rebound. A
// row that such a jump may have reached or not may be off by half of it.

#include "diagnosis/noise/noise_model.h"

namespace jaculus::diagnosis {

/// Deviations of the rows of a span [unit], a row each.
Vector row_deviations(const Problem& problem, const NoiseModel& noise, int dataset,
                      const RowSpan& span, const Prediction& prediction);

}  // namespace jaculus::diagnosis
