#pragma once
// Inertias of first drafts: ones, or hundreds, in every link of a robot that fits under an arm.

#include <vector>

#include "jaculus/model/urdf.h"

namespace jaculus::model {

/// Links whose largest moment is that of their mass at a distance beyond the whole robot's size.
struct SwollenLinks {
  std::vector<int> links;
  double farthest = 0.0;  ///< largest such distance [m]
  double size = 0.0;      ///< of the robot, across [m]
};
SwollenLinks swollen_links(const SpatialTree& tree);

}  // namespace jaculus::model
