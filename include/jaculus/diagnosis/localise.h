#pragma once
// Where the gap lies: by channel, by time and by component. Every statement carries its uncertainty; what the data can't tell
// stands in `notes`.
//
// By channel    gap = rms over trials and samples of measured - predicted; multiple = gap over the channel's noise floor.
// By time       the model is restarted from the measured state at the start of every window, so that an early error doesn't
//               smear into late ones; the share of a phase is the energy of its windows' errors beyond noise, in noise floors.
// Departure     the first time at which the mean residual over the trials leaves its band and stays out (band: normal
//               quantile at 5 % over channels times effective samples), then a hinge fitted back to its onset:
//                   r_c(t) = a_c (t - t0)+^2 + b_c (t - t0)+^3   (rates: one power less),
//               t0 by profile likelihood over all channels together.
// By component  linear signatures S_e of every effect of the catalogue through simulation, nuisances projected out, in the linear
//               Gaussian model r = sum_{e in subset} S_e theta_e + noise; average over all subsets of up to three effects by
//               their evidence; share of a component = its Shapley value of the explained energy, over explained + unexplained.
//               Where base and joints are both measured, a second answer: the generalised force that the model lacks along
//               the measured motion, through a smoother, shared among what the same effects would exert there.

#include <cstdint>
#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/diagnosis/forward.h"
#include "jaculus/diagnosis/linearisation.h"
#include "jaculus/effects/effect.h"

namespace jaculus {

/// The gap in one channel.
struct ChannelGap {
  std::string stream, name, unit;
  double gap = 0.0;          ///< rms of measured - predicted over trials and samples, in `unit`
  double noise_floor = 0.0;  ///< standard deviation of one trial about what repeats, in `unit`
  double multiple = 0.0;     ///< gap / noise_floor [-]
  int samples = 0;           ///< over all trials
  double effective = 0.0;    ///< independent ones among them, by autocorrelation
};

/// When the robot first leaves the model.
struct Departure {
  bool found = false;
  double time = kNaN;                 ///< onset, from the start of the command [s]
  Bounds ci95{kNaN, kNaN};            ///< of the onset, by profile likelihood [s]
  double crossing = kNaN;             ///< when the residual left its band for good [s]
  double band = kNaN;                 ///< half width of the band in standard errors of the mean over trials [-]
  double false_alarm = 1.0;           ///< probability that noise alone goes this far out, over all channels and samples
  std::vector<std::string> channels;  ///< that were out at the crossing or next to it, farthest first
};

/// One multiple-shooting window: the model restarted from the measured state at `start`.
struct RestartedWindow {
  double start = 0.0, end = 0.0;  ///< [s]
  std::string phase;              ///< of the plan, where the window begins
  bool done = false;              ///< false: the model could not be run from the measured state
  double error = kNaN;            ///< rms of the prediction error, every channel in its noise floor [-]
  double noise = kNaN;            ///< what it would be by the noise of sensors and restart alone [-]
  double free_run = kNaN;         ///< rms in the same window of the prediction from the start of the trial [-]
};

/// Share of the gap in a phase of the plan, or in a window of equal length where there are no phases.
struct PhaseShare {
  std::string name;
  double start = 0.0, end = 0.0;  ///< [s]
  double share = 0.0;             ///< of the windows' error energy beyond noise; they sum to 1 where there is a gap [-]
  Bounds ci95{0.0, 1.0};
};

/// Share of the gap's energy that a component accounts for.
struct ComponentShare {
  Component component = Component::body;
  double share = 0.0;           ///< posterior mean [-]
  Bounds ci95{0.0, 1.0};        ///< equal-tailed
  double involved = 0.0;        ///< posterior probability that any effect of it is at work [-]
  bool visible = false;         ///< whether an effect of it at its prior's width would show in these channels
  std::vector<Component> like;  ///< components that these data can't tell from it
};

/// Generalised force that the model lacks along the measured motion; one row a coordinate.
struct ForceResidual {
  std::vector<std::string> coordinates;
  std::vector<std::string> units;  ///< N or N m
  Vector time;                     ///< [s]
  Matrix mean;                     ///< coordinates x times, stance forces removed
  Matrix deviation;                ///< standard deviation of `mean` by measurement noise
};

struct Localisation {
  std::vector<ChannelGap> channels;
  std::vector<PhaseShare> phases;
  Departure departure;
  std::vector<RestartedWindow> windows;
  std::vector<ComponentShare> components;  ///< all of them, in the enum's order; by signatures
  std::vector<ComponentShare>
      force_components;            ///< by the force residual; empty where not every coordinate is measured
  ForceResidual force;             ///< likewise
  double unexplained = 0.0;        ///< share of the gap's energy that no effect of the catalogue accounts for [-]
  double strength = 0.0;           ///< overall gap, rms in noise floors [-]
  std::vector<std::string> notes;  ///< what can't be told, and why
};

struct LocaliseOptions {
  int windows = 8;         ///< restarts over the data's duration
  std::uint64_t seed = 1;  ///< of the draws behind intervals
};

/// Localises the gap that a linearisation leaves: at nominal effects the whole one, at fitted ones what remains. `forward` made
/// the problem's hypotheses. What is judged in time has its nuisances from the prefix alone; for the components they
/// are marginalised.
Localisation localise(const DiagnosisProblem& problem, const Linearisation& about, const PlantForward& forward,
                      const LocaliseOptions& options = {});

}  // namespace jaculus
