#include "evaluation/events.h"

#include <cmath>
#include <set>
#include <utility>

namespace jaculus::evaluation {
namespace {

constexpr double kEventMiddle = 0.1;  ///< how near an event's middle has to be told [s]
constexpr double kEventSize = 0.3;    ///< how near its peak, relative [-]

}  // namespace

bool tells_event(const testbed::TrueEvent& actual, const SaidEvent& said) {
  const double apart = std::abs(0.5 * (actual.from + actual.to) - 0.5 * (said.from + said.to));
  // A peak within 30 % has the true sign; of a peak of zero there is none.
  return said.joint == actual.joint && apart <= kEventMiddle && said.peak * actual.peak > 0.0 &&
         std::abs(said.peak - actual.peak) <= kEventSize * std::abs(actual.peak);
}

EventCounts count_events(const CaseTruth& truth, const Prediction& prediction) {
  std::set<int> found;
  std::set<std::pair<std::string, int>> told;  // a trial, a true event
  EventCounts counts;

  for (const SaidEvent& said : prediction.events) {
    bool there = false;
    for (int e = 0; e < count_of(truth.events) && !there; ++e) {
      if (!tells_event(truth.events[e], said)) continue;
      there = told.emplace(said.trial, e).second;
      found.insert(e);
    }
    counts.invented += there ? 0 : 1;
  }

  counts.found = count_of(found);
  return counts;
}

}  // namespace jaculus::evaluation
