#pragma once
// Held-out errors in units that people read, and whether they are within the user's tolerances.
//
// Lengths are in mm, angles in deg, all else in SI. A tolerance is met where the root mean square
// error up to the horizon is no larger: `--horizon`, else the whole motion.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "jaculus/diagnosis/held_out.h"

namespace jaculus::diagnosis {

/// How good the augmented model must be.
struct Accuracy {
  std::vector<std::string> tolerances;  ///< "x=5mm", "mocap.pitch=1 deg"
  std::optional<double> horizon;        ///< since the start [s]; nothing: the whole motion
};

/// One channel's tolerance.
struct Tolerance {
  std::string unit;     ///< of the channel, SI
  double value = kNaN;  ///< [unit]
};
/// By key of HeldOut::channels, "mocap.x", "dataset.mocap.x".
using Tolerances = std::map<std::string, Tolerance>;

/// A unit in which values are shown, and its size in the SI unit.
struct ShownUnit {
  std::string unit;
  double size = 1.0;
};
/// "m": mm; "rad": deg; another as it is.
ShownUnit shown_unit(const std::string& si);

/// Errors of one channel as users read them.
struct PhysicalGap {
  std::string name;  ///< "x"; with stream or dataset before it where that is needed to tell it
  std::string unit;  ///< of all values here
  std::vector<HorizonGap> horizons;   ///< the whole motion first
  HorizonGap judged;                  ///< at the horizon by which tolerances are judged
  std::optional<double> tolerance{};  ///< that the user named
  std::optional<bool> met{};          ///< by the augmented model; nothing: it could not be judged
  std::optional<bool> met_before{};   ///< by the nominal one
};

/// All judged channels, by key. One that has a tolerance and was not judged has a row without
/// horizons.
std::vector<PhysicalGap> physical_gaps(const HeldOut& gap, const Tolerances& tolerances,
                                       const std::optional<double>& horizon);

}  // namespace jaculus::diagnosis
