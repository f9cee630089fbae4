#pragma once
// What a run leaves behind: samples of its motion.

#include "jaculus/simulation/simulate.h"
#include "simulation/contact/plant_equations.h"

namespace jaculus::simulation::detail {

class Recorder {
 public:
  Recorder(const PlantEquations& equations, const Vector& sample_times, Sampled sampled);

  /// The next instant at which a sample stands; infinite after the last [s].
  [[nodiscard]] double next() const;
  /// The sample at next(): the state then, and what the equations say of it; NaN where they fail or
  /// weren't asked (null).
  void record(const PlantEquations& equations, const State& y, const Evaluation* at);
  /// The same with motors and bus alone.
  void record(const PlantEquations& equations, const State& y, const DriveSample& drive);
  /// The samples so far; all else of the result is for the caller.
  Simulation take();

 private:
  void record_motion(const PlantEquations& equations, const State& y);
  void record_motors(const std::vector<MotorState>& motors, double bus);

  Simulation out_;
  Sampled sampled_;
  Eigen::Index sample_ = 0;
};

}  // namespace jaculus::simulation::detail
