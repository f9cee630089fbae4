#pragma once
// The law of effects/lugre.yaml in C++: what a file does is set beside it, and its time.

#include <cmath>
#include <string>

#include "jaculus/simulation/law.h"

namespace jaculus::test {

/// effects/lugre.yaml's law written out; theta: its parameters in their order.
inline simulation::Law lugre(const std::string& joint, const Vector& theta) {
  simulation::Law law;
  law.name = "lugre";
  law.readings = {{simulation::ReadingKind::joint_rate, joint}};
  law.actions = {{simulation::ActionKind::joint_torque, joint}};
  law.states = {{0.0, 1.0}};
  law.functions = [theta] {
    return simulation::LawFunctions{
        nullptr, [theta](const double* read, const double* state, double* act, double* rate) {
          const double qd = read[0], s = state[0], slow = qd / theta[2];
          const double level = 1.0 + theta[1] * std::exp(-slow * slow);
          rate[0] = (qd - std::abs(qd) * s / level) / theta[3];
          act[0] = -theta[0] * (s + theta[4] * rate[0]);
        }};
  };
  return law;
}

}  // namespace jaculus::test
