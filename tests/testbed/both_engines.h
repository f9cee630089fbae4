#pragma once
// One experiment on two engines that share no physics: the plant (rigid contact found as events,
// minimal coordinates) and MuJoCo (soft contact, pins as constraints, left and right legs).

#include <filesystem>
#include <numbers>
#include <string>

#include "jaculus/core/installation.h"
#include "jaculus/effects/effect.h"
#include "jaculus/testbed/trials.h"

namespace jaculus::test {

inline const std::filesystem::path kModels = source_folder() / "models";

inline constexpr double kDegree = std::numbers::pi / 180.0;  // [rad]

// Half the noise floor of motion capture (0.3 mm, 0.15 deg).
inline constexpr double kHalfPosition = 0.15e-3;                        // [m]
inline constexpr double kHalfAngle = 0.075 * std::numbers::pi / 180.0;  // [rad]

/// x from rest, z, pitch from rest; rows, at the times of the MuJoCo run's motion capture.
struct Motion {
  Vector time;
  Matrix base;
};

Motion on_testbed(const trajectory::Dataset& asked, const testbed::Changes& changes, double after);

/// `effect` with its parameters `theta`; null for none.
Motion on_plant(const trajectory::Dataset& asked, const effects::Effect* effect,
                const Vector& theta, const Vector& time);

/// With no effect both engines differ by less than half the noise floor.
void expect_agreement(const trajectory::Dataset& asked, double after);

/// The same name and number mean the same thing on both: the difference that is left is small
/// beside the effect itself.
void expect_the_same_gap(const trajectory::Dataset& asked, const std::string& effect, double value,
                         double after);

}  // namespace jaculus::test
