#pragma once
// A model fitted to some datasets, to predict the others.
//
// Trials of a dataset are alike, so that a fold without some of them is fitted by the slopes of the
// fit to all (held_out.cpp). Datasets are not: without one the others' optimum may lie far off, and
// what ends where it began has seen what it is to predict. So the fit sets out with
// unknowns where the files have them, for from the whole's optimum a flat cost would keep what the
// dataset that is left out told; by the slopes of the fit to all at first, which are told anew
// where they end. Limits of validity: one start, so the valley that is found from there.

#include <optional>

#include "diagnosis/selection/fit.h"

namespace jaculus::diagnosis {

/// Parameters of a model, fitted to the segments of `mask` alone; nothing where that fails. `all`:
/// the space of `fit`; `others`: that of the mask.
std::optional<Vector> fit_to_others(const Problem& problem, const Whitening& all,
                                    const Whitening& others, const SegmentMask& mask,
                                    const Fit& fit);

}  // namespace jaculus::diagnosis
