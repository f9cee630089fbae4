#pragma once
// What acts on a plant from outside: the controller's commands and pushes. Until the first command
// arrives, torques that hold the start's pose stand in for it (a standing robot stands still until
// its leap arrives).

#include <vector>

#include "simulation/control/controller_state.h"

namespace jaculus::simulation::detail {

class Inputs {
 public:
  /// InputError as of ControllerState. Both must outlive it.
  Inputs(const Plant& plant, const Controller& controller);

  /// The first instant after t at which update() has something to do; infinite where there is none
  /// [s].
  [[nodiscard]] double next_change(double t) const;
  /// Takes what is due at t: joint angles and rates on the motors' side at t.
  void update(double t, const double* position, const double* velocity);

  /// Whether no command of the controller has arrived yet.
  [[nodiscard]] bool waiting() const { return controller_.waiting(); }
  /// Torque commands, one a motor, until the first of the controller arrives; after the update() at
  /// which waiting() is asked.
  void hold(std::vector<Command> torques) { hold_ = std::move(torques); }

  /// Of the commands at present.
  [[nodiscard]] Quantity quantity() const { return hold_.empty() ? quantity_ : Quantity::torque; }
  /// One a motor, at t and joint angles and rates there; valid until the next call.
  const Command* commands(double t, const double* position, const double* velocity) {
    return hold_.empty() ? controller_.commands(t, position, velocity) : hold_.data();
  }
  /// Those that act at present.
  [[nodiscard]] const std::vector<const Push*>& pushes() const { return acting_; }

 private:
  const Plant& plant_;
  ControllerState controller_;
  Quantity quantity_;
  std::vector<Command> hold_;  ///< empty: the controller's own
  std::vector<const Push*> acting_;
};

}  // namespace jaculus::simulation::detail
