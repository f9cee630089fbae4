#pragma once
// Forces that no one commands: friction of joints, hinges of compliant transmissions, drag. Their
// laws are those of plant.h and of components/tail_drag.h.

#include <vector>

#include "jaculus/simulation/plant.h"
#include "simulation/plant/drive.h"
#include "simulation/plant/inertia.h"
#include "simulation/plant/mechanism.h"

namespace jaculus::simulation::detail {

class PassiveForces {
 public:
  /// InputError where friction names a joint that the robot lacks. `plant` must outlive it.
  explicit PassiveForces(const Plant& plant);

  /// Adds the generalised forces at (q, v), at which `mechanism` and `inertia` stand. `motors`:
  /// what each makes now; load friction goes by it.
  void add(const Mechanism& mechanism, const Inertia& inertia,
           const std::vector<MotorState>& motors, const double* q, const double* v, double* force);

 private:
  struct Friction {
    const JointFriction* law;
    int body;   ///< the joint's link
    int motor;  ///< index, -1: of no motor
    int count;  ///< left and right
  };
  struct Spring {
    double stiffness;      ///< [N m/rad]
    double damping_ratio;  ///< [-]
    double half_play;      ///< [rad]
    double smoothing;      ///< of the play's corners [rad]
    /// [N m s/rad]; negative until the first state, whose inertia it goes by
    double damping = -1.0;
  };
  void add_friction(const Mechanism& mechanism, const std::vector<MotorState>& motors,
                    const double* q, const double* v, double* force) const;
  void add_springs(const Mechanism& mechanism, const Inertia& inertia, const double* q,
                   const double* v, double* force);
  void add_drag(const Mechanism& mechanism, double* force) const;

  const Plant& plant_;
  std::vector<Friction> friction_;
  std::vector<Spring> springs_;  ///< one a hinge of the mechanism
};

}  // namespace jaculus::simulation::detail
