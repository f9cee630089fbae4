#pragma once
// Every limit of a problem along a motion, between its nodes too: path constraints, bounds of
// coordinates and inputs, feet that slip, feet in the air that go below the ground.

#include <map>

#include "jaculus/dynamics/rigid_body.h"
#include "jaculus/solver/verify.h"

namespace jaculus::solver::detail {

class LimitMonitor {
 public:
  explicit LimitMonitor(const transcription::NonlinearProgram& program);

  /// Remembers where the feet stand; `point` must be evaluated at the phase's start.
  void begin_phase(const components::EquationsPoint& point);
  /// Checks one point of the motion: `s` in [0, 1] along interval k, `time` from the plan's start
  /// [s], `u` the input there.
  void check_point(int k, double s, double time, const Vector& u,
                   components::EquationsPoint& point);
  /// What was passed by more than 1e-6 of its scale, by falling scaled amount.
  [[nodiscard]] std::vector<LimitExcess> excesses() const;
  /// Largest scaled amount in each interval, over limits that are none of a foot.
  [[nodiscard]] const Vector& by_interval() const { return by_interval_; }

 private:
  void check(const std::string& name, const std::string& unit, double value, const Bounds& bounds,
             double scale, bool of_foot = false);
  void check_terms(int k, double s, const Vector& u, components::EquationsPoint& point);
  void check_bounds(int k, const Vector& u, const components::EquationsPoint& point);
  void check_torques(const transcription::IntervalBlock& block, const Vector& u,
                     const components::EquationsPoint& point);
  void check_feet(const components::EquationsPoint& point);
  [[nodiscard]] Bounds hull(int first, int second) const;

  const transcription::NonlinearProgram& program_;
  std::map<std::string, LimitExcess> worst_;
  std::vector<Vec2> place_;  ///< of each foot at the phase's start, world [m]
  Vector by_interval_;
  int interval_ = 0;
  std::string phase_;
  double time_ = 0.0;
};

}  // namespace jaculus::solver::detail
