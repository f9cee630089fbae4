#pragma once
// How far a model shrinks the gap, on data that its fit never saw.

#include <map>
#include <optional>
#include <string>

#include "jaculus/core/types.h"

namespace jaculus::diagnosis {

struct ChannelShrink {
  double before = kNaN, after = kNaN;  ///< [noise floors]
};

struct HeldOut {
  bool valid = false;
  std::string over;  ///< "conditions" (datasets), "trials", "time"
  int folds = 0;
  double before = kNaN, after = kNaN;  ///< [noise floors]
  double log_gain = kNaN;  ///< log density of all judged rows together, after less before
  std::optional<double> shrink;
  Bounds ci95{kNaN, kNaN};                        ///< of shrink
  std::map<std::string, ChannelShrink> channels;  ///< by stream and name, "mocap.x"
};

}  // namespace jaculus::diagnosis
