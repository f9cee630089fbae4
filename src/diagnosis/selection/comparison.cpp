#include "diagnosis/selection/comparison.h"

namespace jaculus::diagnosis {

Comparison comparison_about(const Problem& problem, NoiseModel noise) {
  Whitening whitening = whitening_of(problem, noise);
  return {std::move(noise), std::move(whitening)};
}

}  // namespace jaculus::diagnosis
