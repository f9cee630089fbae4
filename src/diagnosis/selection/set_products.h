#pragma once
// Products from which those of any set of effects near a fit are picked.

#include <vector>

#include "diagnosis/selection/screen.h"

namespace jaculus::diagnosis {

using SetColumns = std::vector<Eigen::Index>;

/// Products of X: the residual r0, the fit's columns, those of every candidate that it lacks.
struct SetProducts {
  Products products;
  std::vector<SetColumns> own;  ///< of a candidate; empty where it has none
  SetColumns nuisances;         ///< of the fit's free parameters, each one place further
};

/// About the fit of the candidates `about`.
SetProducts set_products(const Problem& problem, const Whitening& whitening, const Fit& fit,
                         const std::vector<int>& about, const std::vector<Probe>& probes);

/// Whether u of a candidate's first parameter is on its side of nominal, where that is a boundary.
bool on_its_side(const Problem& problem, int candidate, double u);

}  // namespace jaculus::diagnosis
