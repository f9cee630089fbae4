#pragma once
// Whether one account holds for every dataset of a robot, in physical units.

#include <string>
#include <vector>

#include "jaculus/core/types.h"

namespace jaculus::diagnosis {

/// Root mean square over a channel's time from the command on of what predictions leave of the mean
/// over trials, each prediction with its own clocks, about rest [unit].
struct ChannelAgreement {
  std::string stream, channel, unit;  ///< SI
  double stated = kNaN;               ///< the model as the files state it
  double unknowns = kNaN;             ///< with what the files leave open fitted, no effect
  double account = kNaN;              ///< with the effects that are named, or lead
  double held_out = kNaN;             ///< the same, fitted to the other datasets alone
  double noise_floor = kNaN;          ///< of one trial
};

/// What the account does in one dataset. A cause that fits one set and harms another is not the
/// cause.
struct SetAgreement {
  std::string dataset;
  std::vector<ChannelAgreement> channels;
  /// Effects of the account without which this dataset is predicted better, the others and the
  /// unknowns fitted again.
  std::vector<std::string> harmed_by;
  /// Held out it is predicted better than as stated (settings.least_improvement), and no effect
  /// harms it.
  bool agrees = false;
};

/// What the files leave open, as fitted with the account.
struct FittedUnknown {
  std::string name;  ///< "feedforward", "kp", "kd_tail", "clock of leap_1"
  /// "factor" on the first value, "share of its stated range" or "ms later than its stamps"
  std::string kind;
  double value = kNaN;      ///< [-], of a clock [ms]
  Bounds ci95{kNaN, kNaN};  ///< by the curvature at the optimum
  bool at_bound = false;    ///< the value is where its range ends, and says no more than that
};

struct Agreement {
  std::vector<FittedUnknown> unknowns;
  /// Effects that these data would tell, were it not for the unknowns, which can pass for them.
  std::vector<std::string> hidden;
  std::vector<SetAgreement> sets;  ///< of several datasets; empty for one

  /// Channels of all sets, each once, in order.
  [[nodiscard]] std::vector<std::string> channels() const;
  /// Share of a channel's energy, summed over the sets, that is explained of the gap as stated:
  /// 1 - sum after^2/sum stated^2 with `after` one of unknowns, account and held_out; NaN where no
  /// set has it.
  [[nodiscard]] double explained(const std::string& channel, double ChannelAgreement::*after) const;
};

}  // namespace jaculus::diagnosis
