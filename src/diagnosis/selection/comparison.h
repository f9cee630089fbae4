#pragma once
// The space in which models are compared: a noise model and what it makes white.

#include "diagnosis/noise/noise_model.h"
#include "diagnosis/noise/whitening.h"

namespace jaculus::diagnosis {

/// The space in which models are compared.
struct Comparison {
  NoiseModel noise;
  Whitening whitening;
};
Comparison comparison_about(const Problem& problem, NoiseModel noise);

}  // namespace jaculus::diagnosis
