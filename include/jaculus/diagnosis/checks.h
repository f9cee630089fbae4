#pragma once
// What is wrong with data before any effect is looked for, and what happened to one trial only.

#include <string>
#include <vector>

#include "jaculus/diagnosis/linearisation.h"

namespace jaculus {

/// Channels whose sign or unit contradicts the prediction, one sentence each ("pitch looks inverted"): measured against predicted
/// over all runs, means removed, correlation c and slope b. Inverted: c < -0.9 and -f fits three times better than f. Another
/// unit: c > 0.95 and b within 15 % of 180/pi, 1000 or their inverses. Only where the motion is ten times the noise.
std::vector<std::string> contradictions(const DiagnosisProblem& problem, const Linearisation& about);

/// A disturbance of one run alone.
struct OneOff {
  int condition = 0, run = 0;
  double onset = 0.0;   ///< [s]
  double excess = 0.0;  ///< rms about the other runs' mean over the usual scatter from there on [-]
  std::string channel;  ///< where it shows most
};
/// Runs (of four or more) that leave the others: scatter about the mean over runs, the mean square from a time on at least nine
/// times the median of the runs' own, and quiet before it.
std::vector<OneOff> one_off_disturbances(const DiagnosisProblem& problem, const Linearisation& about);

/// Cuts the run's data from the onset on.
void cut(DiagnosisProblem& problem, const OneOff& disturbance);

}  // namespace jaculus
