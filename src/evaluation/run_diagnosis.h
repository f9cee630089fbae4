#pragma once
// A diagnosis in a process and folder of its own, which hold one case and nothing that could tell
// its label.

#include "jaculus/evaluation/score.h"

namespace jaculus::evaluation {

struct DiagnosisRun {
  std::filesystem::path binary;   ///< the jaculus program
  std::filesystem::path dataset;  ///< folder of the case: a dataset, or a group
  /// folder for diagnosis.json, augmented.yaml and the program's messages
  std::filesystem::path keep;
  std::vector<std::string> flags;
  std::uint64_t seed = 1;
  double time_limit_s = 900.0;
};

/// Copies the datasets into a fresh folder under the system's temporary one, runs the program there
/// with an environment of PATH, locale and JACULUS_MODELS alone, and reads its prediction. Whatever
/// goes wrong makes a prediction "failed" that says so. The program ends with the process that
/// called this.
Prediction run_diagnosis(const DiagnosisRun& run);

}  // namespace jaculus::evaluation
