#pragma once
// The step of a quadratic model that stays within bounds.
//
//   argmin g.d + d.H d/2,  lower <= d <= upper,  H symmetric and positive definite
// by block principal pivoting (Judice and Pires 1994, "A block principal pivoting algorithm for
// large-scale strictly monotone linear complementarity problems with bounds"): each parameter is
// free or held at a bound; the free ones take their best values; then all that leave their bounds
// are held there, and all that are held where the model falls inwards are freed, at once. Some five
// factors, as a rule. Where that brings fewer faults no more, an active set ends it (Nocedal and
// Wright 2006, algorithm 16.3): on the way to the best values of the free ones the first that meets
// its bound is held, and at the best that one is freed along which the model falls most. It falls
// at every step, so that no set comes twice.

#include "jaculus/core/types.h"

namespace jaculus::diagnosis {

/// How far a parameter at u may move within its range: its bounds for a step, nothing outwards
/// where rounding has it past an end.
Bounds room_within(const Bounds& range, double u);

/// g, lower, upper: n; H: n x n. `lower` must not be positive, nor `upper` negative.
Vector box_step(const Matrix& H, const Vector& g, const Vector& lower, const Vector& upper);

}  // namespace jaculus::diagnosis
