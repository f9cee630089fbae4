#pragma once
// What to do next where effects can't be told apart: experiments are simulated with each rival in
// turn, and what the rivals would then make of those data is compared.
//
//   expected log Bayes factor of experiment E =
//       mean over rivals r of  log p(D_r | r) - log p(D_r | the other),
//   D_r: trials of E on the plant with r as fitted, sensors as in the present data; both rivals are
//   fitted to them anew.
//
// Experiments: the present one once more; the same by duty instead of torque, or the other way
// round, where the plan has both; and, for a robot with a tail that has drag and a motor, the tail
// on a bench (base held, half the battery's voltage to and fro) and a drop (full command on the
// tail from straight back, legs as now). Those that the robot or the stated controller does not
// allow, or in which the plant is lost, are left out.

#include "diagnosis/forward/problem.h"
#include "diagnosis/noise/noise_model.h"
#include "jaculus/diagnosis/diagnosis.h"
#include "jaculus/diagnosis/options.h"

namespace jaculus::diagnosis {

/// A rival explanation: effects, and what each was fitted to.
struct Rival {
  std::vector<const effects::Effect*> effects;
  std::vector<Vector> theta;  ///< parameters of each, own units
};

/// The experiment that is expected to tell `a` and `b` apart best; nothing where none is expected
/// to (settings.telling) or can be simulated. `noise`: of the present data.
std::optional<NextExperiment> next_experiment(const trajectory::Dataset& present,
                                              const Problem& problem, const NoiseModel& noise,
                                              const Rival& a, const Rival& b,
                                              const DiagnoseOptions& options = {});

/// log evidence of data with each rival's effects at work, all fitted anew from where the rival has
/// them, in one space: that about the first rival, which made the data. NaN where a rival can't be
/// fitted.
std::vector<double> log_evidences(const std::vector<trajectory::Dataset>& datasets,
                                  const std::vector<Rival>& rivals, const DiagnoseOptions& options);

}  // namespace jaculus::diagnosis
