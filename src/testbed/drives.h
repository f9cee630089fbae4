#pragma once
// The testbed's motors and battery: equations in jaculus/testbed/playback.h. Written for this robot
// alone; the cubic and the battery's voltage are solved by Newton and by iteration rather than in
// closed form.

#include <string>
#include <vector>

#include "jaculus/testbed/changes.h"
#include "jaculus/trajectory/quantity.h"
#include "testbed/robot_files.h"

namespace jaculus::testbed {

/// What one motor does at an instant.
struct DriveState {
  double torque = 0.0;   ///< at the joint [N m]
  double current = 0.0;  ///< [A]
  double voltage = 0.0;  ///< at its terminals [V]
};

class Drives {
 public:
  /// InputError where an ideal motor is to take duty or voltage.
  Drives(const RobotFiles& files, const Changes& changes, trajectory::Quantity quantity);

  /// All motors under `commands` (NaN: off) at joint rates `rates` [rad/s]; returns the bus voltage
  /// [V].
  double run(const std::vector<double>& commands, const std::vector<double>& rates,
             std::vector<DriveState>& states) const;
  /// Warms the windings over `seconds`.
  void warm(const std::vector<DriveState>& states, double seconds);

 private:
  struct One {
    model::PlanarMotor motor;
    double constant = 1.0;     ///< on the torque constant, true over believed
    double temperature = 0.0;  ///< above that of the stated resistance [K]
  };
  [[nodiscard]] DriveState one(const One& drive, double command, double rate, double bus) const;

  trajectory::Quantity quantity_;
  double current_limit_ = kInfinity, battery_ = 0.0, battery_resistance_ = 0.0, heat_ = 0.0;
  std::vector<One> all_;
};

/// Current that a stated motor torque takes [A], before the gear.
double current_of_torque(const model::PlanarMotor& motor, double torque);
/// Its inverse [N m].
double torque_of_current(const model::PlanarMotor& motor, double current);

}  // namespace jaculus::testbed
