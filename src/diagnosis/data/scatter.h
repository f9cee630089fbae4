#pragma once
// The middle of samples, and their scatter.
//
// The scatter of samples that are equally spaced, by their second differences. Of white noise those
// of neighbours, x_{i-1} - 2 x_i + x_{i+1}, have the variance 6 s^2, and of what swings slowly they
// see next to nothing (von Neumann 1941; Gasser, Sroka and Jennen-Steinmetz 1986). The largest
// tenth is left out, for commands have steps, and made up for as of normal numbers. Where a driver
// filters its log, so that neighbours agree, or what is logged is itself as quick, this says less
// or more than the noise.

#include <vector>

namespace jaculus::diagnosis {

/// The middle of values, of an even number the greater one; at least one value.
double median(std::vector<double> values);

/// Deviation of white noise on equally spaced samples [unit of x]; 0 for fewer than ten.
double scatter_of(const std::vector<double>& x);

}  // namespace jaculus::diagnosis
