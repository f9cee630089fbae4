#pragma once
// Motors, battery and winding: from a command to the torque at the joint.
//
// With the motor's torque t before the gear, k_t and R of the warm winding, w the joint's rate:
//     i = t'(a + c t'^2), t' = t/(1 - 0.001 T)      V = R i + k_t G w
//       R = R_0 (1 + 0.0039 T), k_t = k_t0 (1 - 0.001 T)
//     torque command:   t = command within +- the torque and current limits; |V| <= bus, else t is
//                       what V = +-bus makes
//     voltage command:  V within +- bus, t by the inverse;  duty: V = duty bus, |duty| <= 1
//     With dead time a driver that is told V leaves V - V_d tanh(R i/V_d) on the winding, V_d its
//     share of V_bus. The sign of the current is rounded over a current of V_d/R: chosen, for what
//     ripple there is depends on the winding's inductance. A loop of the current tells V so that
//     the winding has R i + k_t G w, as far as V stays within V_bus: drivers go on switching there,
//     for their gates are fed by it.
//     joint torque    = G eta t times the joint's scale.
// The battery feeds drivers that keep power, so that the winding's V i / V_bus flows through its
// resistance (dead time shifts the share of a period that is switched on, and takes no power):
//     V_bus = V_0 - R_b sum count (V - lost) i / V_bus,
// solved for V_bus by a bracketed root finder, since V and i depend on it where a motor is limited
// or driven by duty.

#include <vector>

#include "jaculus/components/motor.h"
#include "jaculus/simulation/plant.h"
#include "jaculus/trajectory/quantity.h"

namespace jaculus::simulation::detail {

using trajectory::Quantity;

/// A command for one motor; one that is off makes no torque.
struct Command {
  bool on = false;
  double value = 0.0;  ///< in the quantity [N m before the gear, -, V]
};

struct MotorState {
  double torque = 0.0;   ///< at the joint, scaled [N m]
  double current = 0.0;  ///< [A]
  double voltage = 0.0;  ///< that the driver is told, or its loop of the current tells it [V]
  double lost = 0.0;     ///< of it, to dead time, against the current [V]
  bool limited = false;  ///< by voltage, current or torque
};

/// What laws change of motors, battery and ground at an instant.
struct PlantChanges {
  std::vector<double> torque_scale;  ///< one a motor, on the torque that arrives [-]
  double bus_drop = 0.0;             ///< of the battery's voltage [V]
  double friction_scale = 1.0;       ///< on the ground's coefficient of friction [-]
};

class Drive {
 public:
  /// InputError where a motor can't take a command of `quantity`.
  Drive(const Plant& plant, Quantity quantity);

  /// Until the next change(); none at first.
  void change(const PlantChanges& changes);
  /// States of all motors by their commands, at their joints' rates [rad/s] and windings'
  /// temperatures [K] (null: cold). Returns the bus voltage.
  double set(Quantity quantity, const Command* commands, const double* rates,
             const double* temperatures);

  std::vector<MotorState> motors;  ///< as set() left them

 private:
  [[nodiscard]] MotorState one(std::size_t m, Quantity quantity, const Command& command,
                               double rate, double temperature, double bus) const;
  double set_at(double bus, Quantity quantity, const Command* commands, const double* rates,
                const double* temperatures);

  struct Motor {
    model::PlanarMotor data;
    components::MagneticSaturation saturation;
    double ratio;          ///< G eta
    double largest;        ///< motor torque by current and torque limits [N m]
    double scale;          ///< torque that arrives [-]
    double dead_time;      ///< largest voltage lost, of the bus voltage [-]
    double changed = 1.0;  ///< on top of it, by laws [-]
  };
  std::vector<Motor> data_;
  double resistance_, open_voltage_;
  double drop_ = 0.0;  ///< of all voltages, by laws [V]
  bool warm_;
};

}  // namespace jaculus::simulation::detail
