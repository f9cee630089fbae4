#pragma once
// What a missing force follows, and how much of it, judged on segments that no fit saw.
//
// Of the groups that stand by stability (sparse_fit.h), coefficients are fitted by generalised
// least squares to all folds but one and predict that one; folds are runs of chunks in time. With
// the missing force's energy E = sum f^2 less what the rates' noise makes of it, a set S of groups
// explains
//   v(S) = (sum f^2 - sum (f - x_S b_S)^2)/E
// on held-out boxes. Its groups share v by Shapley's mean over the orders in which they may join
// (1953), each with Student's interval over the folds. A group is stated where that interval is
// above zero and its share is settings.least_followed or more.

#include "diagnosis/remainder/sparse_fit.h"

namespace jaculus::diagnosis {

/// The place described; no pattern where there are too few boxes to judge one.
RemainderPlace describe(const PlaceRegressors& place, const Settings& settings);

}  // namespace jaculus::diagnosis
