#pragma once
// Of many sets of effects the most probable, at a glance.
//
// There are thousands of sets beside eighty nuisances, so that deviations follow for the foremost
// alone (linear_sets.h). These are told by one step of reweighted least squares at the fit's
// deviations: with the nuisances at their best for every w = [1; -u],
//   n = K w,  K = (N^T V^-1 N + I)^-1 N^T V^-1 [r0 Y],
//   u = (S_uu + I)^-1 S_u0,  S = [r0 Y]^T V^-1 [r0 Y] - (N^T V^-1 [r0 Y])^T K,
// and E_c = w^T M_c w, the energies that this leaves in each coordinate, M_c with n put in, a set
// is worth
//   -[sum_c (-2 log density of E_c at its most likely misfit) + r^T V^-1 r of the rows of none
//     + log det V of these + |u|^2 + |n|^2 + log det (S_uu + I)]/2 + log prior,
// V of the forces that move them, and the most of it by these at the fit's deviations, a third and
// a tenth of them: a set that explains what forces did needs smaller ones. E_c is that at the most
// probable u; log det and K are by the fit's misfits, which a set that explains much would make
// smaller: larger sets look a little better than they are, so that sets of each size are ranked
// among themselves.
// K, S and M_c are those of all candidates; a set's are picked out of them, in microseconds.

#include <vector>

#include "diagnosis/selection/set_products.h"

namespace jaculus::diagnosis {

/// The settings.sets_followed most probable of some sets of each size, as they stood; all where
/// they are no more.
std::vector<std::vector<int>> foremost_sets(const Problem& problem, const RandomEffects& random,
                                            const Vector& scales, const SetProducts& table,
                                            std::vector<std::vector<int>> sets);

}  // namespace jaculus::diagnosis
