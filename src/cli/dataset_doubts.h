#pragma once
// What of a dataset contradicts itself or its robot, before anything is simulated.

#include <string>
#include <vector>

#include "jaculus/model/robot.h"
#include "jaculus/trajectory/dataset.h"

namespace jaculus::cli {

struct DatasetDoubts {
  std::vector<std::string> strange_channels;  ///< of no joint or sensor of this robot
  /// one sentence on each of these, and on values beyond limits that are stated and nothing holds
  std::vector<std::string> notes;
  std::vector<std::string> contradictions;  ///< one sentence each
};

DatasetDoubts dataset_doubts(const trajectory::Dataset& dataset, const model::Robot& robot);

/// One line each, indented.
std::string to_text(const DatasetDoubts& doubts);

}  // namespace jaculus::cli
