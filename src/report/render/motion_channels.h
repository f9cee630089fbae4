#pragma once
// Channels of plans and logs, and what coordinates of a model follow from them.

#include <map>
#include <string>
#include <vector>

#include "jaculus/model/planar.h"
#include "jaculus/trajectory/csv.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::report {

/// One quantity over time, SI; gaps are NaN.
struct MotionChannel {
  std::vector<double> time;   ///< [s], never falling
  std::vector<double> value;  ///< as many
};

/// By column name without unit: "x", "front_a", "front_a_velocity", "front_foot_force_z".
using MotionChannels = std::map<std::string, MotionChannel>;

/// All columns of a plan's table against its column `time`.
MotionChannels motion_channels(const trajectory::Table& plan);
/// All channels of a trial, each at its own rate; the first stream that has a channel gives it.
MotionChannels motion_channels(const trajectory::Trial& trial);

/// Value of a channel at t, linear between samples; NaN outside and next to gaps.
double channel_at(const MotionChannel& channel, double t);

/// Coordinates over frames.
struct CoordinateFrames {
  std::vector<double> time;  ///< frames [s]
  Matrix q, v;               ///< n x frames
  std::vector<bool> known;   ///< n: whether anything determines the coordinate
  bool height_known = true;  ///< false: z of a free base is not
};

CoordinateFrames coordinate_frames(const model::PlanarModel& model, const MotionChannels& channels,
                                   int most_frames);

/// Bodies whose place every coordinate on their way determines.
std::vector<bool> known_bodies(const model::PlanarModel& model, const std::vector<bool>& known);

}  // namespace jaculus::report
