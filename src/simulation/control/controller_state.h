#pragma once
// The controller at work: samples at t_k = late start + k/rate, commands that arrive `delay` later
// and hold until the next, or without a rate a command that follows the state. Everything that
// changes by a jump does so at an instant of next_change(), which the integration meets exactly.

#include <deque>
#include <optional>
#include <vector>

#include "jaculus/simulation/controller.h"
#include "jaculus/simulation/plant.h"
#include "simulation/plant/drive.h"

namespace jaculus::simulation::detail {

class ControllerState {
 public:
  /// The plant's model gives the order of the motors. InputError where the reference names others,
  /// or a rate is zero. `controller` must outlive it.
  ControllerState(const Plant& plant, const Controller& controller);

  /// The first instant after t at which update() has something to do; infinite where there is none
  /// [s].
  [[nodiscard]] double next_change(double t) const;
  /// Takes what is due at t: joint angles and rates on the motors' side at t.
  void update(double t, const double* position, const double* velocity);
  /// Commands at t, once the first has arrived: held ones, or with no rate those of the state.
  const Command* commands(double t, const double* position, const double* velocity);
  /// Whether nothing has arrived yet.
  [[nodiscard]] bool waiting() const { return waiting_; }

 private:
  /// A motor of the reference and how the controller sees its joint.
  struct Loop {
    int motor;                               ///< of the robot
    double kp, kd;                           ///< of the plant's controller, per motor angle
    double gear;                             ///< [-]
    double position_scale, position_offset;  ///< of the sensor [-, rad]
    double velocity_scale, velocity_offset;  ///< [-, rad/s]
  };
  struct Arrival {
    double time;  ///< [s]
    std::vector<Command> commands;
  };
  struct Wanted {
    double feedforward = 0.0, position = 0.0, velocity = 0.0;
  };
  [[nodiscard]] const Reference& reference() const {
    return lagged_ ? *lagged_ : controller_.reference;
  }
  void lag_behind(std::vector<Command>& commands);
  /// Rates on the motors' side as a sample reads them, from those that are.
  const double* filtered(const double* velocity);
  void find_segment(double at);
  [[nodiscard]] Wanted wanted(Eigen::Index row, double at) const;
  [[nodiscard]] Wanted landing(Eigen::Index row, double at) const;
  void evaluate(double at, const double* position, const double* velocity,
                std::vector<Command>& out) const;
  [[nodiscard]] double instant(double k) const { return late_ + k / rate_; }
  [[nodiscard]] double read_instant(double k) const;

  const Controller& controller_;
  std::optional<Reference> lagged_;  ///< the controller's, where it lags and no sample holds it
  std::vector<Loop> loops_;          ///< one a motor of the reference
  double rate_;                      ///< [Hz]
  double delay_;                     ///< of commands [s]
  double lag_;                       ///< time constant of what the motors make of them [s]
  double velocity_filter_;           ///< time constant of the rates that it reads [s]
  double late_;                      ///< start of the plan as a whole [s]
  double latency_;                   ///< of the sensors that it reads [s]
  double scale_;                     ///< on the feed-forward [-]
  bool continuous_;
  bool waiting_ = true;
  double next_read_ = 0.0;   ///< sample number, whole
  Eigen::Index sample_ = 0;  ///< of the reference, the last at or before the present segment
  bool ended_ = false;       ///< the reference has
  std::deque<Arrival> queue_;
  std::vector<Command> now_;
  std::vector<double> seen_;  ///< a motor each: its filtered rate [rad/s]; empty before all
  std::vector<double> made_;  ///< a motor each: what it makes where a hold ends; empty before all
};

}  // namespace jaculus::simulation::detail
