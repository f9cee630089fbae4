#pragma once
// The middle of samples, and their scatter.
//
// The scatter of samples that are equally spaced, by their second differences. Of white noise those
// of neighbours, x_{i-1} - 2 x_i + x_{i+1}, have the variance 6 s^2, and of what swings slowly they
// see next to nothing (von Neumann 1941; Gasser, Sroka and Jennen-Steinmetz 1986). The largest
// tenth is left out, for commands have steps, and made up for as of normal numbers. Where a driver
// filters its log, so that neighbours agree, or what is logged is itself as quick, this says less
// or more than the noise.
//
// Noise of instruments is seldom white: it has a part of as much power in every octave (flicker, of
// the spectral density h/f), of which neighbours tell next to nothing. Of means over m samples in a
// row, by second differences (the Hadamard variance: Riley 2008, NIST SP 1065, noise types),
//   H_m = s^2/m + h/2 ln(256/27) + what was logged itself,
// the last not negative. So with s^2 <= H_1
//   h/2 ln(256/27) <= (H_m - H_1/m)/(1 - 1/m),   m > 1, and <= H_1,
// and the least of these over m bounds the flicker, as the bias instability of an instrument does
// (IEEE Std 952).

#include <vector>

namespace jaculus::diagnosis {

/// The middle of values, of an even number the greater one; at least one value.
double median(std::vector<double> values);

/// Deviation of white noise on equally spaced samples [unit of x]; 0 for fewer than ten.
double scatter_of(const std::vector<double>& x);

/// H_m of equally spaced samples, m = 1, 2, 4, ..., while there are means enough [unit of x
/// squared]; empty for fewer than ten samples.
std::vector<double> scatter_by_octaves(std::vector<double> x);

/// The most that the root of h may be, by H_1, H_2, H_4, ...; 0 of none.
double most_flicker(const std::vector<double>& octaves);

}  // namespace jaculus::diagnosis
