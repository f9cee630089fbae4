#include "simulation/control/command_lag.h"

#include <cmath>

namespace jaculus::simulation::detail {

double held_mean(double lag, double hold, double command, double& u) {
  const double gone = -std::expm1(-hold / lag);  // 1 - e
  const double mean = command + (u - command) * gone * lag / hold;
  u += (command - u) * gone;
  return mean;
}

Reference lagged(Reference reference, double lag) {
  const Vector& time = reference.time;
  const Eigen::Index last = time.size() - 1;
  Matrix& feedforward = reference.feedforward;

  for (Eigen::Index row = 0; row < feedforward.rows(); ++row) {
    double u = feedforward(row, 0), before = u;
    for (Eigen::Index k = 0; k <= last; ++k) {
      const double command = feedforward(row, k);
      if (reference.linear) {
        const double length = k == 0 ? 0.0 : time[k] - time[k - 1];
        if (length > 0.0) {
          const double behind = lag * (command - before) / length;
          u = command - behind + (u - before + behind) * std::exp(-length / lag);
        } else {
          u = k == 0 ? command : u;
        }
        feedforward(row, k) = u;
      } else {
        const double hold = (k < last ? time[k + 1] : reference.duration) - time[k];
        if (hold > 0.0) feedforward(row, k) = held_mean(lag, hold, command, u);
      }
      before = command;
    }
  }
  return reference;
}

}  // namespace jaculus::simulation::detail
