#pragma once
// How far a model shrinks the gap, on data that its fit never saw.
//
// Folds: over conditions where there are several, else over trials, else (one trial) over its windows in time. In a fold the model is
// fitted on the rest; a held-out run's own nuisances (shift, start, offsets) are estimated from its prefix alone:
//   n = argmin |W (y - f - A n)|^2 over rows before prefix_end + |(n - m)/s|^2,
// and rows after it are judged by what may be predicted at all (P: covariance of n that the prefix leaves):
//   e_i = (y - f - A n)_i/sqrt(sigma_i^2 (1 + 1/n_train) + (A P A^T)_ii).
// Log density of the judged rows jointly: N(0, W^-1 + A P A^T).
// Gap: square root of the mean over channels of the mean square of e. Shrink = 1 - (after - 1)/(before - 1), nothing where before <
// 1.5. Its interval is Student's t over the folds.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/diagnosis/fit.h"

namespace jaculus {

struct ChannelShrink {
  double before = kNaN, after = kNaN;  ///< [noise floors]
};

struct HeldOut {
  bool valid = false;
  std::string over;  ///< "conditions", "trials", "time"
  int folds = 0;
  double before = kNaN, after = kNaN;  ///< [noise floors]
  double log_gain = kNaN;              ///< log density of all judged rows together, after less before
  std::optional<double> shrink;
  Bounds ci95{kNaN, kNaN};                        ///< of shrink
  std::map<std::string, ChannelShrink> channels;  ///< by stream and name, "mocap.x"
};

/// Judges a fitted model (its free parameters refitted in each fold by two Gauss-Newton steps from where they are) against the nominal
/// one, in which only condition-wide nuisances are fitted.
HeldOut held_out(const DiagnosisProblem& problem, const Linearisation& about, const Fit& none, const Fit& model);

}  // namespace jaculus
