#pragma once
// Quantiles of the normal that intervals and thresholds of 95 % use. They keep the digits that
// their results were made with: another digit would move the last digits of those results.

namespace jaculus::diagnosis::quantiles {

constexpr double kTwoSided95 = 1.959964;     // of |z|
constexpr double kTwoSided95Rounded = 1.96;  // the same, of a reported interval's widening by form
constexpr double kOneSided95 = 1.645;        // of z
constexpr double kChi2Of95 = 3.84;           // of z^2, chi^2 with one degree of freedom

}  // namespace jaculus::diagnosis::quantiles
