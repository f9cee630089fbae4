#pragma once
// What to do next where effects can't be told apart: each experiment that could follow is
// simulated, and what it would tell of the rivals is stated.
//
//   expected log Bayes factor of experiment E =
//       mean over rivals r of  E log p(D_r | r) - E log p(D_r | the other)  (expected_evidence.h),
//   D_r: data of E with r at work as fitted, sensors as in the present data; the other imitates it
//   as well as it can.
//
// Experiments: experiments.h. Those that the robot or the stated controller does not allow, or in
// which the plant is lost, are left out.

#include "diagnosis/noise/noise_model.h"
#include "diagnosis/preflight/simulated_data.h"
#include "jaculus/diagnosis/diagnosis.h"
#include "jaculus/diagnosis/options.h"

namespace jaculus::diagnosis {

/// The experiment that is expected to tell `a` and `b` apart best; nothing where none is expected
/// to (settings.telling) or can be simulated. `noise`: of the present data.
std::optional<NextExperiment> next_experiment(const trajectory::Dataset& present,
                                              const Problem& problem, const NoiseModel& noise,
                                              const Explanation& a, const Explanation& b,
                                              const DiagnoseOptions& options = {});

}  // namespace jaculus::diagnosis
