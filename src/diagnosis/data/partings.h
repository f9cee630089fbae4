#pragma once
// Left and right that part. The model of the plane moves them as one, at the mean of what their
// encoders read, q. What they do together, of sides at q + d and q - d, is
//   (f(q + d) + f(q - d)) / 2 = f(q) + f''(q) d^2 / 2 + ...
// so sides that differ count in the second order only, until they part: in a leap as soon as one
// foot of a pair leaves the floor before the other. Where a log has both sides (channel
// <joint>_apart, their difference 2 d), data from there on are no test of a model of the plane:
// from where the difference began to rise to what it parts by.

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/data/observations.h"

namespace jaculus::diagnosis {

/// Whether a channel tells how far the robot is from the plane: what sides of a joint of the model
/// differ by; y, roll and yaw of a tracked body.
bool tells_of_plane(const model::PlanarModel& model, const std::string& stream,
                    const std::string& channel);

/// What sides of one joint differ by in a trial, about its zero.
struct Sides {
  Parting names;                    ///< dataset, trial, joint and unit
  double limit = 0.0;               ///< from which on they part [unit]
  double noise = 0.0;               ///< by which one sample is no move [unit]
  double rise = 0.0;                ///< settings.sides_rise [s]
  std::vector<double> time, apart;  ///< gaps left out [s], [unit]
};

/// Every joint of a trial whose log has both sides. They part by more than settings.sides_apart (of
/// what slides that times settings.lever) or settings.sides_scatter times what the difference
/// scatters by. Zeros of encoders differ: what counts is the difference beyond its median at rest
/// before the command, or over all of a log that itself drove the robot.
std::vector<Sides> sides_of(const ObservedDataset& observed, const trajectory::Trial& trial,
                            const Settings& settings);

/// Where a trial's sides first part within [from, to], two samples in a row; nothing where none do.
std::optional<Parting> first_parting(const std::vector<Sides>& sides, double from, double to);

/// The first of some; null of none.
const Parting* earliest(const std::vector<Parting>& partings);

/// Those of a trial's windows as one: the first, by as much as they part at most. Nothing of none.
std::optional<Parting> as_one(const std::vector<Parting>& partings);

/// What was seen and left out, a sentence for the partings of a dataset of so many trials.
std::string note_of(const std::vector<Parting>& partings, int trials);

/// By how much the body left the plane at `end` since it stood at `begin` [s], of the channels y,
/// roll and yaw: mean over trials and scatter from one to the next. What repeats tells that left
/// and right differ. Empty where none is tracked.
std::string out_of_plane(const trajectory::Dataset& dataset, const std::string& label, double begin,
                         double end);

}  // namespace jaculus::diagnosis
