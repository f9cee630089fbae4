#pragma once
// Channels resampled into coordinates of a model.

#include <vector>

#include "jaculus/model/planar.h"
#include "jaculus/report/stick_figure.h"

namespace jaculus {

/// Value of a channel at t, linear between samples; NaN outside and next to gaps.
double channel_at(const MotionChannel& channel, double t);

/// Coordinates over frames.
struct CoordinateFrames {
  std::vector<double> time;  ///< frames [s]
  Matrix q, v;               ///< n x frames
  std::vector<bool> known;   ///< n: whether anything determines the coordinate
  bool height_known = true;  ///< false: z of a free base is not
};

CoordinateFrames coordinate_frames(const PlanarModel& model, const MotionChannels& channels, int most_frames);

/// Bodies whose place every coordinate on their way determines.
std::vector<bool> known_bodies(const PlanarModel& model, const std::vector<bool>& known);

}  // namespace jaculus
