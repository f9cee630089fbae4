#pragma once
// Pushes that a prediction says against those that were there. One said counts as found where its
// joint is right, its middle within 0.1 s, its peak within 30 % and its sign right.

#include <string>

#include "jaculus/evaluation/predictions.h"

namespace jaculus::evaluation {

/// Whether a said time, peak and joint are as near the true ones as is asked; the trial aside.
bool tells_event(const testbed::TrueEvent& actual, const SaidEvent& said);

struct EventCounts {
  int found = 0;  ///< of the true ones, each once, in whatever trials it was said
  /// Said, and not there. Of those that tell one true event in one trial the first alone is right:
  /// it was there once.
  int invented = 0;
};
EventCounts count_events(const CaseTruth& truth, const Prediction& prediction);

}  // namespace jaculus::evaluation
