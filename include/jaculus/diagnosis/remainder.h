#pragma once
// What the judged model leaves, described: at which joint, how large, what it follows.

#include <algorithm>
#include <string>
#include <vector>

#include "jaculus/core/types.h"

namespace jaculus::diagnosis {

/// What a force that the model lacks may follow.
enum class Regressor {
  constant,
  sign_of_speed,       ///< dry friction
  speed,               ///< viscous friction
  speed_squared,       ///< |speed| speed: drag
  motor_torque,        ///< of the joint's own motor: a scale
  torque_friction,     ///< the size of that, against the motion: friction of a loaded gear
  weight_friction,     ///< the size of the weight that the joint carries, against the motion
  position,            ///< a spring, towards where it is zero
  periodic,            ///< in the joint's position
  gravity_direction,   ///< sine and cosine of the link's absolute angle: a weight
  acceleration,        ///< an inertia
  time,                ///< since the trial's start
  other_speed,         ///< of another joint
  other_acceleration,  ///< of another joint
  channel,             ///< a logged one: bus voltage, temperature
  periodic_in_time
};
/// "sign of speed", "periodic in position".
const char* to_text(Regressor regressor);

/// A share of what is left at a joint that follows something.
struct Dependence {
  Regressor regressor = Regressor::constant;
  std::string of{};      ///< another joint, or the channel; empty: the joint itself
  double period = kNaN;  ///< [unit]
  std::string unit{};    ///< of the period, "rad" or "m"
  double share = kNaN;   ///< of the missing force's mean square, on segments that no fit saw [-]
  Bounds ci95{kNaN, kNaN};
  double selected = 0.0;  ///< share of random halves of the data that choose it as well [-]
  /// Force a unit of each of its functions: amplitudes of sine and cosine, slope and constant, ...
  std::vector<double> coefficients;
  std::string hypothesis{};  ///< the file of an effect, where one was simulated to find it
  std::string form{};        ///< in words, where the regressor says only what it depends on
  bool brief = false;        ///< a push that every trial had, told among the events as well
};

/// What is left along one coordinate, or at one place.
struct RemainderPlace {
  std::string joint;                  ///< a coordinate; a group of joints, a foot
  double rms = kNaN;                  ///< of the missing force, without what sensors' noise makes
  std::string unit;                   ///< "N m", "N"
  int boxes = 0;                      ///< of time in which it is known
  double rest = kNaN;                 ///< speed below which its sign counts in part [rad/s or m/s]
  std::vector<Dependence> follows{};  ///< the largest share first; empty: no pattern in it
  std::string place = "joint";        ///< "joint", "body", "feet"
  /// Found by simulation of the whole motion: shares are of the gap's energy that the model leaves,
  /// and no force is known box by box.
  bool by_simulation = false;

  /// Whether a push is all that it follows, which is told among the events.
  [[nodiscard]] bool is_push() const {
    return !follows.empty() &&
           std::all_of(follows.begin(), follows.end(), [](const Dependence& d) { return d.brief; });
  }
};

struct Remainder {
  double share = kNaN;  ///< of the held-out gap's energy that the judged model leaves [-]
  Bounds ci95{kNaN, kNaN};
  std::vector<RemainderPlace> places;  ///< a coordinate each; empty where no force can be had
};

}  // namespace jaculus::diagnosis
