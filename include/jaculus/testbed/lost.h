#pragma once
// What ends a run on the testbed before it has begun or midway.

#include <stdexcept>

#include "jaculus/core/error.h"

namespace jaculus::testbed {

/// A robot that can't be played: MuJoCo loses it or takes no such body.
class LostRobot : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A start pose that the robot can't take, its pins not meeting.
class UnreachablePose : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace jaculus::testbed
