#pragma once
// Bands of the forces that a plant lacks over a window.
//
// A force of one size at every frequency is no model of what logged inputs leave: their scatter is
// quick (a driver's loop, quantised currents), so that its slow part is small, and a slow fault (a
// friction, a wrong torque constant) would drown in the size of the quick one. Over the B boxes of
// a window the force is therefore a sum of cosines,
//   f_j = sum_k D_jk w_k,   D the orthonormal cosine transform (type II) of B points,
// cosine k of k/(2 T) Hz over a window of T, and each band k = 2^b - 1 ... 2^(b+1) - 2 has a
// deviation of its own, estimated over all windows.
//
// No band's deviation is below that of the one before it. What a model's form gets wrong slowly
// (a friction that is not quite proportional) it gets wrong quickly as well, where the motion
// turns; and a fit that trusted quick details more than slow forces would rest on the details. With
// equal deviations it is least squares of force, as parameters of robots are commonly identified
// (Gautier and Poignet 2001).

#include "diagnosis/noise/random_effects.h"

namespace jaculus::diagnosis {

int band_of(int cosine);
/// Bands of so many boxes.
int bands_of(int boxes);
/// Share of all cosines that lie in a band [-].
double share_of_band(int band, int boxes);
/// Root mean square over the boxes of the force that a group's deviation is, of its band alone
/// [unit of the force].
double force_of_band(const Hypotheses& hypotheses, const RandomGroup& group, double deviation);
/// D, boxes x boxes.
Matrix cosines(int boxes);

}  // namespace jaculus::diagnosis
