#pragma once
// Where the gap lies: by channel, by time and by component. Every statement carries its
// uncertainty; what the data can't tell stands in `notes`.

#include <string>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/effects/effect.h"

namespace jaculus::diagnosis {

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
  double time = kNaN;       ///< onset, from the start of the command [s]
  Bounds ci95{kNaN, kNaN};  ///< of the onset, by profile likelihood [s]
  double crossing = kNaN;   ///< when the residual left its band for good [s]
  double band = kNaN;  ///< half width of the band in standard errors of the mean over trials [-]
  double false_alarm =
      1.0;  ///< probability that noise alone goes this far out, over all channels and samples
  std::vector<std::string>
      channels;  ///< that were out at the crossing or next to it, farthest first
};

/// One multiple-shooting window: the model restarted from the measured state at `start`.
struct RestartedWindow {
  double start = 0.0, end = 0.0;  ///< [s]
  std::string phase;              ///< of the plan, where the window begins
  bool done = false;              ///< false: the model could not be restarted there
  double error = kNaN;  ///< rms of the prediction error, every channel in its noise floor [-]
  double noise = kNaN;  ///< what it would be by the noise of sensors and restart alone [-]
  double free_run =
      kNaN;  ///< rms in the same window of the prediction from the start of the trial [-]
};

/// Share of the gap in a phase of the plan, or in a window of equal length where there are no
/// phases.
struct PhaseShare {
  std::string name;
  double start = 0.0, end = 0.0;  ///< [s]
  double share =
      0.0;  ///< of the windows' error energy beyond noise; they sum to 1 where there is a gap [-]
  Bounds ci95{0.0, 1.0};
};

/// Share of the gap's energy that a component accounts for.
struct ComponentShare {
  effects::Component component = effects::Component::body;
  double share = 0.0;      ///< posterior mean [-]
  Bounds ci95{0.0, 1.0};   ///< equal-tailed
  double inclusion = 0.0;  ///< posterior probability that any effect of it is at work [-]
  /// whether an effect of it at its prior's width would show in these channels
  bool visible = false;
  std::vector<effects::Component>
      indistinguishable;  ///< components that these data can't tell from it
  bool present = false;   ///< whether the robot has it: an effect was tried there
};

/// Generalised force that the model lacks along the measured motion; one row a coordinate.
struct ForceResidual {
  std::vector<std::string> coordinates;
  std::vector<std::string> units;  ///< N or N m
  Vector time;                     ///< [s]
  Matrix mean;                     ///< coordinates x times, stance forces removed
  Matrix deviation;                ///< standard deviation of `mean` by measurement noise
};

/// The robot at a telling time of one segment (localise/postures.h).
struct Posture {
  int dataset = 0, segment = 0;
  double time = 0.0;  ///< since the segment's start, on the model's clock [s]
  std::string why;    ///< "leaves the model", "largest error"
  Vector measured;    ///< coordinates, the judged model's where nothing measures them [rad or m]
  Vector nominal;     ///< as the nominal model predicts them
  Vector augmented;   ///< as the judged model does
  std::vector<bool> known;   ///< a coordinate each: whether sensors tell it
  Vector force{};            ///< that the nominal model lacks, a coordinate each; empty: unknown
  Vector force_deviation{};  ///< its standard deviation by measurement noise [N m or N]
};

struct Localisation {
  std::vector<ChannelGap> channels;
  std::vector<PhaseShare> phases;
  Departure departure;
  std::vector<RestartedWindow> windows;
  std::vector<ComponentShare> components;  ///< all of them, in the enum's order
  ForceResidual force;                     ///< empty where not every coordinate is measured
  std::vector<Posture> postures;           ///< of one segment, rising in time
  double unexplained =
      0.0;  ///< share of the gap's energy that no effect of the catalogue accounts for [-]
  double strength = 0.0;           ///< overall gap, rms in noise floors [-]
  std::vector<std::string> notes;  ///< what can't be told, and why
};

}  // namespace jaculus::diagnosis
