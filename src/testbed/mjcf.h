#pragma once
// The robot and its floor as MJCF, MuJoCo's own model format, with the changes that are part of its
// build: segments of the tail's shaft, play behind motors, floor plates on springs, payload,
// masses.
//
// Names: bodies are links, joints are the URDF's; base_x, base_z, base_pitch move the base. Behind
// a motor with play, <joint>_play is the hinge between motor and link; tail_bend_1, ... are those
// of the shaft. Sites pin_<i>_a and pin_<i>_b mark the pins' ends, geoms toe_<i> the toes.

#include <string>

#include "jaculus/testbed/changes.h"
#include "testbed/robot_files.h"

namespace jaculus::testbed {

/// How hard MuJoCo's constraints are and how it steps. None of this is physics of the robot: the
/// tests of agreement show that the motion no longer depends on it.
struct Numerics {
  double step = 1.6e-4;     ///< longest step [s]
  bool runge_kutta = true;  ///< else semi-implicit Euler
  /// time constant of constraints in steps; below 2 stiff legs chatter on the floor [-]
  double stiffness_steps = 2.0;
  double impedance = 0.9999;       ///< of constraints: 1 - softness [-]
  double friction_impedance = 10;  ///< of friction against normal force (impratio) [-]
  int strips = 32;                 ///< of the drag's quadrature
};

/// Share of the step that is taken near a stop, whose stiffness goes with it [-].
inline constexpr double kStopStep = 0.2;

/// What of an experiment is part of the build.
struct Setting {
  bool floor = true;        ///< whether there is one
  bool base_fixed = false;  ///< base held in the world
  bool stops = false;       ///< joints' ranges are stops
};

std::string mjcf(const RobotFiles& files, const Changes& changes, const Setting& setting,
                 const Numerics& numerics);

/// Numerics that a robot needs: one of legs without pins a floor that is less hard, in smaller
/// steps; a changed one: shaft and floor plates on springs are stepped by
/// semi-implicit Euler, whose damping is implicit, at a fraction of their fastest period.
Numerics numerics_for(const RobotFiles& files, const Changes& changes, Numerics numerics);

/// Hinges of the shaft from the tail's pivot [m]; empty where it is rigid. The shaft is flexible up
/// to where the drag begins.
std::vector<double> shaft_hinges(const RobotFiles& files, const Changes& changes);

/// Restitution of MuJoCo's limit at a dampratio [-].
double restitution_of_damping_ratio(double ratio);

/// dampratio of MuJoCo's limit that gives a restitution; 3 where that is below 0.024, which is as
/// plastic as it gets [-].
double damping_ratio_of_restitution(double restitution);

}  // namespace jaculus::testbed
