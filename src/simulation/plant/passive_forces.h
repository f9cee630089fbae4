#pragma once
// Forces that no one commands: friction of joints, what the motors themselves have of it
// (components/motor.h), torque beside the commanded one, hinges of
// compliant transmissions, drag, ends of loops. The laws of all but the last are those of plant.h
// and of components/tail_drag.h.
//
// A loop's two links can't pass one another: where they fold onto one another or stretch out into
// one line the pin's side is undecided, and real links meet before. With g > 0 the angle between
// them at the pin, or what is left to a straight angle, below g_0 = 0.1 rad
//     tau = s max(0, (g_0/g - 1)(1 - g'/r)),   along dg/dq = +-(w_a - w_b),
//     s = weight (l_a + l_b),   r = sqrt(gravity/(l_a + l_b)),   gravity at least 1 m/s^2,
// whose potential s (g_0 log(g_0/g) - g_0 + g) has no upper bound: no motion goes through. The
// factor of g' is Hunt and Crossley's (1975): damping that begins with the force, from zero. g_0 is
// a quarter of the 0.4 rad by which Minitaur's stated range stays away from both poses, so that it
// acts on no motion within that range, bit for bit.

#include <vector>

#include "jaculus/simulation/plant.h"
#include "simulation/plant/drive.h"
#include "simulation/plant/fast_part.h"
#include "simulation/plant/inertia.h"
#include "simulation/plant/mechanism.h"

namespace jaculus::simulation::detail {

class PassiveForces {
 public:
  /// InputError where friction names a joint, or an offset a motor, that the robot lacks. `plant`
  /// must outlive it.
  explicit PassiveForces(const Plant& plant);

  /// Adds the generalised forces at (q, v), at which `mechanism` and `inertia` stand. `motors`:
  /// what each makes now; load friction goes by it.
  void add(const Mechanism& mechanism, const Inertia& inertia,
           const std::vector<MotorState>& motors, const double* q, const double* v, double* force);
  /// Whether there are hinges or joints that rub.
  [[nodiscard]] bool has_fast_parts() const {
    return !springs_.empty() || !friction_.empty() || !rubbing_.empty();
  }
  /// Hinges' springs and dampers, joints and motors that rub, with the slopes of their laws at
  /// (q, v) and without responses. After the first add(), at its motors.
  void list_fast_parts(const Mechanism& mechanism, const std::vector<MotorState>& motors,
                       const double* q, const double* v, std::vector<FastPart>& parts) const;

 private:
  struct Friction {
    const JointFriction* law;
    int body;   ///< the joint's link
    int motor;  ///< index, -1: of no motor
    int count;  ///< left and right
  };
  /// A joint that rubs, as it moves.
  struct Rubbing {
    double rate = 0.0;         ///< [rad/s, m/s]
    const Row* row = nullptr;  ///< d(rate)/dv; the mechanism's, or that of `state`
    double sign = 0.0;         ///< smoothed, of the rate
    double level = 0.0;        ///< of dry friction [N m, N]
  };
  struct Spring {
    double stiffness;      ///< [N m/rad]
    double damping_ratio;  ///< [-]
    double half_play;      ///< [rad]
    double smoothing;      ///< of the play's corners [rad]
    /// [N m s/rad]; negative until the first state, whose inertia it goes by
    double damping = -1.0;
  };
  struct MotorRub {
    int motor;  ///< index
    model::PlanarMotor data;
  };
  struct Offset {
    int motor;      ///< index
    double torque;  ///< of left and right together [N m]
  };
  void add_motor_friction(const Mechanism& mechanism, const double* v, double* force) const;
  /// `state`: that of a joint without a motor.
  [[nodiscard]] Rubbing rubbing(const Friction& f, const Mechanism& mechanism,
                                const std::vector<MotorState>& motors, const double* q,
                                const double* v, JointState& state) const;
  void add_friction(const Mechanism& mechanism, const std::vector<MotorState>& motors,
                    const double* q, const double* v, double* force) const;
  void add_springs(const Mechanism& mechanism, const Inertia& inertia, const double* q,
                   const double* v, double* force);
  void add_drag(const Mechanism& mechanism, double* force) const;
  void add_loop_ends(const Mechanism& mechanism, double* force) const;

  const Plant& plant_;
  std::vector<Friction> friction_;
  std::vector<MotorRub> rubbing_;
  std::vector<Offset> offsets_;
  std::vector<Spring> springs_;  ///< one a hinge of the mechanism
};

}  // namespace jaculus::simulation::detail
