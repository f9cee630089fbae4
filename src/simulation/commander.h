#pragma once
// The controller at work: samples at t_k = late start + k/rate, commands that arrive `delay` later and hold until the next, or without a
// rate a command that follows the state. Everything that changes by a jump does so at an instant of next_change(), which the
// integration meets exactly.
//
// Until the first command arrives the motors hold the start pose (a standing robot stands still until its leap arrives).

#include <deque>
#include <vector>

#include "jaculus/simulation/controller.h"
#include "jaculus/simulation/plant.h"
#include "simulation/drive.h"

namespace jaculus::detail {

class Commander {
 public:
  /// `model` gives the order of the motors. InputError where the reference names others, or a rate is zero.
  Commander(const Plant& plant, const Controller& controller);

  /// The first instant after t at which update() has something to do; infinite where there is none [s].
  [[nodiscard]] double next_change(double t) const;
  /// Takes what is due at t: joint angles and rates on the motors' side at t.
  void update(double t, const double* position, const double* velocity);
  /// Commands at t, once the first has arrived: held ones, or with no rate those of the state.
  const Command* commands(double t, const double* position, const double* velocity);
  [[nodiscard]] bool continuous() const { return continuous_; }
  /// Whether nothing has arrived yet, so that the start pose is held.
  [[nodiscard]] bool waiting() const { return waiting_; }

 private:
  struct Arrival {
    double time;
    std::vector<Command> commands;
  };
  struct Wanted {
    double feedforward = 0.0, position = 0.0, velocity = 0.0;
  };
  void find_segment(double at);
  [[nodiscard]] Wanted wanted(Eigen::Index row, double at) const;
  [[nodiscard]] Wanted landing(Eigen::Index row, double at) const;
  void evaluate(double at, const double* position, const double* velocity, std::vector<Command>& out) const;
  [[nodiscard]] double instant(long k) const { return late_ + static_cast<double>(k) / rate_; }
  [[nodiscard]] double read_instant(long k) const;

  const Controller& controller_;
  std::vector<int> motor_;  ///< of the robot, a motor of the reference; -1 never
  std::vector<double> kp_, kd_, ratio_, position_scale_, position_offset_, velocity_scale_, velocity_offset_;
  double rate_, delay_, late_, latency_, scale_;
  bool continuous_, waiting_ = true;
  long next_read_ = 0, next_arrival_ = 0;  ///< sample numbers
  Eigen::Index sample_ = 0;                ///< of the reference, the last at or before the present segment
  bool ended_ = false;
  std::deque<Arrival> queue_;
  std::vector<Command> now_;
};

}  // namespace jaculus::detail
