#pragma once
// What all imports of logs share: the dataset that the logs go into.

#include <filesystem>
#include <string>

#include "jaculus/trajectory/dataset.h"

namespace jaculus::trajectory {

struct ImportSetup {
  ExperimentKind experiment = ExperimentKind::leap;
  std::string robot;
  std::filesystem::path plan;  ///< what was commanded; empty: none
  std::string
      /// as in dataset.yaml, YAML; empty: feed-forward and PD of unknown gains where there is a
      /// plan
      controller;
};

/// A dataset without trials; its notes say what was assumed. InputError where plan or controller
/// are faulty or neither is given.
Dataset begin_dataset(const ImportSetup& setup);

}  // namespace jaculus::trajectory
