#pragma once
// What a run leaves behind: samples of its motion.

#include "jaculus/simulation/simulate.h"
#include "simulation/contact/plant_equations.h"

namespace jaculus::simulation::detail {

class Recorder {
 public:
  Recorder(const PlantEquations& equations, const Vector& sample_times);

  /// The next instant at which a sample stands; infinite after the last [s].
  [[nodiscard]] double next() const;
  /// The sample at next(): the state then, and what the equations say of it; NaN where they fail or
  /// weren't asked (null).
  void record(const PlantEquations& equations, const State& y, const Evaluation* at);
  /// The samples so far; all else of the result is for the caller.
  Simulation take();

 private:
  Simulation out_;
  Eigen::Index sample_ = 0;
};

}  // namespace jaculus::simulation::detail
