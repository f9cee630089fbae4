#pragma once
// How far a model shrinks the gap, on data that its fit never saw.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/core/types.h"

namespace jaculus::diagnosis {

/// Root mean square of held-out errors of one channel up to a horizon (validation/judge.h).
struct HorizonGap {
  double horizon = kInfinity;          ///< since the start; infinite: the whole motion [s]
  double reach = kNaN;                 ///< of the last sample judged, since the start [s]
  double before = kNaN, after = kNaN;  ///< of the model as stated and of the fitted one [unit]
  double floor = kNaN;  ///< expected of a perfect model: noise, and what starts leave open [unit]
};

struct ChannelShrink {
  double before = kNaN, after = kNaN;  ///< [noise floors]
  std::string dataset{};               ///< empty where there is one
  std::string channel{}, unit{};       ///< "x", "m"
  std::vector<HorizonGap> horizons{};  ///< the whole motion, settings.horizon
};

struct FoldGap {
  double before = kNaN, after = kNaN;  ///< [noise floors]
};

/// What one effect of a set explains of the held-out gap's energy (validation/shares.h).
struct EffectShare {
  double alone = kNaN;      ///< it alone, beyond the tolerances [-]
  double last = kNaN;       ///< lost where it is dropped from the set [-]
  double shapley = kNaN;    ///< mean over the orders in which the set's effects join [-]
  Bounds ci95{kNaN, kNaN};  ///< of shapley
  /// What the builder's tolerances explain as the set has them, without any effect [-].
  double tolerances = 0.0;
};

/// What a gap leaves of another one's energy beyond noise, (after^2 - 1)/(before^2 - 1) [-].
inline double energy_left(double before, double after) {
  return (after * after - 1.0) / (before * before - 1.0);
}

struct HeldOut {
  bool valid = false;
  std::string over;  ///< "conditions" (datasets), "trials", "time"
  int folds = 0;
  double before = kNaN;    ///< of the model as its files state it [noise floors]
  double adjusted = kNaN;  ///< of that with tolerances fitted and no effect [noise floors]
  double after = kNaN;     ///< of the fitted model, effects and tolerances [noise floors]
  double log_gain = kNaN;  ///< log density of all judged rows together, after less adjusted
  std::optional<double> shrink;
  Bounds ci95{kNaN, kNaN};                        ///< of shrink
  std::vector<FoldGap> by_fold;                   ///< NaN where a fold could not be judged
  std::map<std::string, ChannelShrink> channels;  ///< by stream and name, "mocap.x"
};

}  // namespace jaculus::diagnosis
