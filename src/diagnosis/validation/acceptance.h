#pragma once
// What held-out data say of a proposed set of effects.

#include "diagnosis/validation/held_out.h"

namespace jaculus::diagnosis {

/// The model without those members that don't help to predict, the least missed first, as long as
/// all that are left out are idle together: a set is smaller than is good where the held-out error
/// is larger by settings.least_improvement and its energy beyond noise settings.named_beside times
/// as large as with all members. Evidence alone may ask for an effect (a few milliseconds of delay
/// under a noisy input) that changes no motion that anybody would notice; but under a plan members
/// stay without which the set, fitted anew, is settings.strong_odds less probable than with all,
/// if held-out data are predicted no worse with them. Smaller sets that the search did not fit are
/// fitted here; tolerances stay where the model has them, and where datasets judge one another a
/// set must do as well by its own.
ModelFit without_idle_members(HeldOutGaps& gaps, ModelFit model);

/// The model without those members that make the error of a dataset larger by
/// settings.least_improvement where no fit saw it, by the larger set's tolerances and by those of
/// the smaller one's own, the one first without which the error of all is least: a cause that fits
/// one set and harms another is not the cause. One always stays. For single datasets the model
/// itself.
ModelFit without_harmful_members(HeldOutGaps& gaps, ModelFit model);

/// The model without those members that explain less than settings.remainder_share of the held-out
/// gap's energy in the mean over the orders in which its members may join (shares.h), of the gap
/// that a robot within its tolerances has where that is a plain one (HeldOut::adjusted), the least
/// first: what would not be worth stating as a remainder is not worth a name. One always stays, and
/// so do members that the odds need, as above.
ModelFit without_members_of_no_share(HeldOutGaps& gaps, ModelFit model);

}  // namespace jaculus::diagnosis
