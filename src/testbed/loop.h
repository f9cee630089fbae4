#pragma once
// The robot's control loop: at its own instants it reads encoders, works out a command for every
// motor and sends it; it arrives after the delay and is held until the next one does.

#include <deque>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "jaculus/testbed/changes.h"
#include "jaculus/testbed/motor_commands.h"
#include "testbed/sizes.h"

namespace jaculus::testbed {

/// A value that may be missing.
inline double value_of(const std::map<std::string, double>& values, const std::string& key,
                       double otherwise) {
  const auto found = values.find(key);
  return found == values.end() ? otherwise : found->second;
}

class Loop {
 public:
  Loop(const RobotFiles& files, const Changes& changes, const Commands& commands,
       const LoopSensors& sensors);

  /// When encoders are read or commands arrive next, after `t` [s].
  [[nodiscard]] double next() const;
  /// Does what is due at `t`: angles and rates are those of the motors' side now.
  void update(double t, const std::vector<double>& angles, const std::vector<double>& rates);
  /// Whether no command has arrived yet.
  [[nodiscard]] bool waiting() const { return waiting_; }
  /// What the motors hear now, one a drive; NaN: off.
  [[nodiscard]] const std::vector<double>& now() const { return now_; }

 private:
  struct Sent {
    double arrives;
    std::vector<double> commands;
  };
  [[nodiscard]] double instant() const;    ///< of the next sample [s]
  [[nodiscard]] double read_time() const;  ///< when its encoders are read [s]
  std::vector<double> evaluate(double moment, const std::vector<double>& angles,
                               const std::vector<double>& rates);
  /// Whether what is sent at the present instant gets lost; the first never is.
  [[nodiscard]] bool loses() const;
  /// What the driver of drive `i` makes of a command that it hears.
  double driven(std::size_t i, double command);

  const Commands& commands_;
  std::vector<Eigen::Index> row_;  ///< of each drive in the commands, -1 where it hears none
  std::vector<double> kp_, kd_, gear_, scale_, offset_;
  std::vector<double> full_;      ///< command of each driver that is all it can [its quantity]
  std::vector<double> driven_;    ///< command that each driver made last
  std::vector<JointSize> sizes_;  ///< of each drive
  const Disturbances& outside_;
  double period_ = 1e-3, delay_ = 0.0, late_ = 0.0, latency_ = 0.0;
  LoopSensors sensors_;
  std::mt19937_64 random_;
  long index_ = 0;
  bool waiting_ = true;
  std::deque<Sent> sent_;
  std::vector<double> now_;
};

}  // namespace jaculus::testbed
