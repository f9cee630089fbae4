#pragma once
// First-order lag of what motors make behind a command c, T u' = c - u, solved exactly between the
// command's jumps:
//     constant c over a time h    u(h) = c + (u0 - c) e,  e = exp(-h/T)
//                                 mean over h: c + (u0 - c) (1 - e) T/h
//     line from c0 to c1          u(h) = c1 - s T + (u0 - c0 + s T) e,  s = (c1 - c0)/h
// A hold is played at its mean: the same impulse as the exponential, without steps that are short
// beside T. Torque that changes within a hold is what is left out; at a millisecond it moves a
// joint by less than |u0 - c| h^2/(8 I).

#include "jaculus/simulation/controller.h"

namespace jaculus::simulation::detail {

/// The mean of u over a hold of a constant command; `u` goes on to its end. lag: T [s], hold: h
/// [s], both above 0.
double held_mean(double lag, double hold, double command, double& u);

/// A reference whose feed-forward lags behind its own, from its first sample on; that of linear
/// ones at their samples, else each the mean of its hold.
Reference lagged(Reference reference, double lag);

}  // namespace jaculus::simulation::detail
