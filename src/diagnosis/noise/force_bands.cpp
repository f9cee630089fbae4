#include "diagnosis/noise/force_bands.h"

#include <bit>
#include <cmath>
#include <numbers>

namespace jaculus::diagnosis {

int band_of(int cosine) { return std::bit_width(static_cast<unsigned>(cosine) + 1u) - 1; }

int bands_of(int boxes) { return band_of(boxes - 1) + 1; }

double share_of_band(int band, int boxes) {
  int count = 0;
  for (int k = 0; k < boxes; ++k) count += band_of(k) == band ? 1 : 0;
  return static_cast<double>(count) / boxes;
}

double force_of_band(const Hypotheses& hypotheses, const RandomGroup& group, double deviation) {
  const int box = hypotheses.forces[group.force].boxes.front();
  return deviation * std::sqrt(group.share) * hypotheses.parameters[box].scale;
}

Matrix cosines(int boxes) {
  Matrix D(boxes, boxes);
  for (int k = 0; k < boxes; ++k) {
    const double size = std::sqrt((k == 0 ? 1.0 : 2.0) / boxes);
    for (int j = 0; j < boxes; ++j)
      D(j, k) = size * std::cos(std::numbers::pi * k * (j + 0.5) / boxes);
  }
  return D;
}

}  // namespace jaculus::diagnosis
