#pragma once
// Noise of a logged input.
//
// A torque or a current that was logged is a measurement: the model is driven by it as it was
// recorded, scatter and all, while the robot was driven by what the log meant to show. So a window
// differs from its prediction, with nothing wrong, by what a force at the joint does that is as
// large as the log's noise:
//   y = f + G D w + ...,
// G the rows' slopes by a force in each of a window's B boxes, D their cosines (force_bands.h). Of
// white noise with the deviation s on each sample, n samples a box, and of flicker with the
// spectral density h/f (data/scatter.h) cosine k, of k/2 periods a window, has
//   w_k ~ N(0, s^2/n + B h ln((2k + 1)/(2k - 1))),   k > 0,
// the integral of h/f over the frequencies about its own; w_0 has what is slower, an octave of it:
// B h ln 2. Slower still is a log's offset, which is a cause and no noise. As nuisances of the
// windows these serve all models alike, and what a perfect model leaves of held-out rows has them
// too.
//
// The log itself tells s, but of h only the most that it may be, for torques move as slowly as
// flicker does. So of h as much is granted as the model needs that the noise is told about, by the
// forces that it lacks, and no more than the log allows. Without flicker a healthy arm, whose
// drivers' noise had a slow part of 1 % of the torque, lacked forces by 450 nats.

#include <map>
#include <string>

#include "diagnosis/noise/nuisances.h"

namespace jaculus::diagnosis {

/// Noise of a log as a force at its joint [N m, N where it slides].
struct InputNoise {
  double white = 0.0;    ///< its deviation, of the mean over a box of settings.force_box
  double flicker = 0.0;  ///< the root of h, at most
};

/// That of the log of each motor that has one, a joint each. Empty where no input was logged.
std::map<std::string, InputNoise> input_noise(const ObservedDataset& observed,
                                              const Settings& settings);

/// Deviations of the cosines of a window of so many boxes.
Vector deviations_of(const InputNoise& noise, int boxes);

/// The root of h of a flicker whose cosines together are a force of this root mean square over the
/// boxes of a window.
double flicker_of_force(double rms, int boxes);

/// The nuisances of a window and those of its input's noise. `slopes`: of the window's rows by the
/// boxes of all forces in their order, a prior scale each (random_effects.h).
SegmentNuisances with_input_noise(SegmentNuisances nuisances, const Hypotheses& hypotheses,
                                  const std::map<std::string, InputNoise>& noise,
                                  const Matrix& slopes);

}  // namespace jaculus::diagnosis
